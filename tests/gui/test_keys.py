"""One browser controls; who asks gets control by an answer, by waiting, or when the other one has gone."""

import pytest

from footscan.gui.keys import ANSWER_S, Keys


class Desk:
    """Keys with a clock and a log that can be looked at."""

    def __init__(self) -> None:
        self.now_s = 0.0
        self.log: list[str] = []
        self.keys = Keys(self.log.append, lambda: self.now_s)


@pytest.fixture
def desk() -> Desk:
    desk = Desk()
    desk.keys.come(1)
    desk.keys.come(2)
    return desk


def test_the_first_browser_controls_the_second_watches(desk: Desk) -> None:
    assert desk.keys.holder == 1


def test_control_is_given_by_an_answer_and_logged(desk: Desk) -> None:
    assert not desk.keys.ask(2)
    desk.keys.answer(1, give=True)

    assert desk.keys.holder == 2
    assert desk.log[-1] == "browser 2 controls: was given control"


def test_who_keeps_control_is_not_overruled_later(desk: Desk) -> None:
    desk.keys.ask(2)
    desk.keys.answer(1, give=False)
    desk.now_s = 2 * ANSWER_S

    assert not desk.keys.wait_out(busy=False)
    assert desk.keys.holder == 1


def test_no_answer_gives_control_but_never_while_the_machine_is_busy(desk: Desk) -> None:
    desk.keys.ask(2)
    assert not desk.keys.wait_out(busy=False)
    desk.now_s = ANSWER_S + 1
    assert not desk.keys.wait_out(busy=True)
    assert desk.keys.wait_out(busy=False)

    assert desk.keys.holder == 2


def test_nobody_answers_for_another_browser(desk: Desk) -> None:
    desk.keys.come(3)
    desk.keys.ask(2)
    desk.keys.answer(3, give=True)

    assert desk.keys.holder == 1


def test_a_browser_that_goes_leaves_control_to_who_asked_and_to_nobody_else(desk: Desk) -> None:
    desk.keys.go(1)
    assert desk.keys.holder is None
    assert desk.keys.ask(2)
    desk.keys.come(3)
    desk.keys.ask(3)
    desk.keys.go(2)

    assert desk.keys.holder == 3


def test_a_browser_that_comes_when_nobody_controls_gets_control(desk: Desk) -> None:
    desk.keys.go(1)
    desk.keys.come(4)

    assert desk.keys.holder == 4
