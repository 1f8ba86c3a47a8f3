"""Commands are done in order on one thread, one long job at a time; what goes wrong is told and the page goes on."""

import threading
from collections.abc import Generator
from dataclasses import replace

import pytest

from footscan.errors import CancelledError, DeviceError, InputError
from footscan.gui import texts
from footscan.gui.desk import Desk, Progress
from tests.gui.until import until

Told = list[tuple[str, str, bool]]


@pytest.fixture
def told() -> Told:
    return []


@pytest.fixture
def desk(told: Told) -> Generator[Desk]:
    desk = Desk(lambda title, body, wrong: told.append((title, body, wrong)))
    desk.start()
    yield desk
    desk.close()


def _settle(desk: Desk) -> None:
    done = threading.Event()
    desk.post(done.set)
    assert done.wait(20.0)


def test_commands_are_done_one_after_the_other_in_order(desk: Desk) -> None:
    done: list[int] = []
    for number in range(500):
        desk.post(lambda number=number: done.append(number))
    _settle(desk)

    assert done == list(range(500))


def test_a_new_state_is_shown_and_the_old_one_is_left_as_it_was(desk: Desk) -> None:
    shown: list[str] = []
    desk.listen(lambda state: shown.append(state.operator))
    before = desk.state
    desk.post(lambda: desk.change(operator="Anna"))
    _settle(desk)

    assert (before.operator, desk.state.operator, shown) == ("", "Anna", ["Anna"])


def test_what_goes_wrong_is_told_in_words_and_the_next_command_is_done(desk: Desk, told: Told) -> None:
    def refuse() -> None:
        raise InputError("the date is impossible.")

    desk.post(refuse)
    desk.post(lambda: 1 / 0)  # type: ignore[arg-type]
    desk.post(lambda: desk.change(operator="Anna"))
    _settle(desk)

    assert told[0] == (texts.FAILED, "the date is impossible.", True)
    assert "ZeroDivisionError" in told[1][1] and "division by zero" not in told[1][1]
    assert desk.state.operator == "Anna"


def test_only_one_job_runs_and_its_end_comes_to_the_desk(desk: Desk, told: Told) -> None:
    go, ended = threading.Event(), []

    def work(progress: Progress) -> int:
        progress(1, 2)
        go.wait(20.0)
        return 7

    desk.post(lambda: desk.job("first", work, ended.append) and None)
    desk.post(lambda: desk.job("second", lambda progress: 8, ended.append) and None)
    _settle(desk)
    until(lambda: desk.state.job is not None and desk.state.job.total == 2)
    assert told == [(texts.WORKING, texts.BUSY, True)]
    go.set()
    until(lambda: desk.state.job is None and bool(ended))

    assert ended == [7]


def test_a_cancelled_job_stops_where_it_tells_its_progress(desk: Desk) -> None:
    stopped, failures, steps = threading.Event(), [], []

    def work(progress: Progress) -> None:
        for step in range(10_000):
            progress(step, 10_000)
            steps.append(step)
            stopped.wait(0.01)

    desk.post(lambda: desk.job("long", work, lambda made: None, failures.append, stopped.set) and None)
    until(lambda: bool(steps))
    desk.cancel()
    until(lambda: desk.state.job is None)

    assert stopped.is_set()
    assert isinstance(failures[0], CancelledError)
    assert len(steps) < 10_000


def test_cancelling_is_shown_at_once_and_its_end_is_no_failure(desk: Desk, told: Told) -> None:
    go = threading.Event()

    def work(progress: Progress) -> None:
        progress(0, 1)
        go.wait(20.0)  # a long step that cannot be broken off
        progress(1, 1)

    desk.post(lambda: desk.job("customising", work, lambda made: None) and None)
    until(lambda: desk.state.job is not None and desk.state.job.total == 1)
    desk.cancel()
    until(lambda: desk.state.job is not None and desk.state.job.words == texts.CANCELLING)
    go.set()
    until(lambda: desk.state.job is None and bool(told))

    assert told == [(texts.CANCELLED.format(what="customising"), "", False)]


def test_what_was_only_computed_is_left_when_it_was_cancelled_meanwhile(desk: Desk) -> None:
    computing, go = threading.Event(), threading.Event()
    kept: list[int] = []

    def work(progress: Progress) -> int:
        computing.set()
        go.wait(20.0)  # it never looks whether somebody cancelled
        return 7

    for keeps_nothing in (True, False):
        computing.clear(), go.clear()
        desk.post(lambda it=keeps_nothing: desk.job("ranking", work, kept.append, keeps_nothing=it) and None)
        assert computing.wait(20.0)
        desk.cancel()
        go.set()
        until(lambda: desk.state.job is None)
    until(lambda: bool(kept))

    assert kept == [7]


def test_asking_often_whether_somebody_cancelled_shows_nothing_anew(desk: Desk) -> None:
    shown: list[object] = []
    desk.listen(lambda state: shown.append(state.job))

    def work(progress: Progress) -> None:
        for _ in range(1000):
            progress(2, 3)

    desk.post(lambda: desk.job("customising", work, lambda made: None) and None)
    until(lambda: len(shown) > 1 and shown[-1] is None)

    assert len(shown) < 6


def test_a_job_that_fails_says_why_and_frees_the_desk(desk: Desk, told: Told) -> None:
    def work(progress: Progress) -> None:
        raise DeviceError("the camera is gone.")

    desk.post(lambda: desk.job("scan", work, lambda made: None) and None)
    until(lambda: bool(told))
    _settle(desk)

    assert told == [(texts.FAILED, "the camera is gone.", True)]
    assert desk.state == replace(desk.state, job=None)


def test_between_the_jobs_of_a_row_the_desk_is_not_idle(desk: Desk) -> None:
    gate, seen = threading.Event(), list[bool]()

    def second(_: None) -> None:
        seen.append(desk.idle)  # the first job has ended, the second has not begun
        desk.job("second", lambda progress: gate.wait(20.0), lambda _: None)

    desk.post(lambda: desk.job("first", lambda progress: None, second) or None)
    until(lambda: bool(seen) and desk.state.job is not None)
    seen.append(desk.idle)
    gate.set()
    until(lambda: desk.idle)

    assert seen == [False, False]
    assert desk.state.job is None
