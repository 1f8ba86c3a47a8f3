"""A returning patient: what was said of the feet before is proposed, never taken for granted; a day begins anew."""

from collections.abc import Generator
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from footscan.coordinates import Side
from footscan.gui.earlier import Earlier, find_earlier
from footscan.gui.proposed import earlier_html
from footscan.gui.state import PageState
from footscan.records import Foot, FootFacts, NewPatient, NewTake, Patient, RecordStore, Take
from footscan.scanning.recorder import manifest_of

FIRST = datetime(2026, 3, 2, 12, 0, tzinfo=UTC)
TOE = FootFacts(("toe_2",), "gauze on the <heel>", "hallux valgus", "too tired")


class Calendar:
    """The clock of the records, put to another day by hand."""

    now = FIRST

    def __call__(self) -> datetime:
        return self.now


@pytest.fixture
def calendar() -> Calendar:
    return Calendar()


@pytest.fixture
def store(tmp_path: Path, calendar: Calendar) -> Generator[RecordStore]:
    with RecordStore(tmp_path / "data", now=calendar) as opened:
        yield opened


@pytest.fixture
def patient(store: RecordStore) -> Patient:
    return store.add_patient(NewPatient("Rita Returning"), "op")


def _declare(store: RecordStore, patient: Patient, side: Side, facts: FootFacts) -> None:
    store.declare_foot(store.open_visit(patient.id, "op").id, side, facts, "op")


def _proposed(store: RecordStore, patient: Patient, calendar: Calendar) -> Earlier:
    return find_earlier(store, patient.id, calendar.now.astimezone().date(), "bipedal", "bare")


def test_what_was_declared_is_proposed_at_the_next_visit_and_is_not_yet_true(
    store: RecordStore, patient: Patient, calendar: Calendar
) -> None:
    _declare(store, patient, "left", TOE)
    on_the_day = _proposed(store, patient, calendar)
    calendar.now += timedelta(days=30)
    proposed = _proposed(store, patient, calendar)
    words = earlier_html(proposed)

    assert not on_the_day
    assert [(foot.side, foot.facts) for foot in proposed.feet] == [("left", replace(TOE, not_scanned=""))]
    assert proposed.days == (FIRST.date(),)
    assert "toe 2 is missing" in words and "gauze on the &lt;heel&gt;" in words and "too tired" not in words
    assert len(store.visits(patient.id)) == 1


def test_what_is_declared_today_is_not_proposed_again(store: RecordStore, patient: Patient, calendar: Calendar) -> None:
    _declare(store, patient, "left", TOE)
    _declare(store, patient, "right", FootFacts(deformity="hammer toe 2"))
    calendar.now += timedelta(days=30)
    _declare(store, patient, "left", FootFacts(("toe_1",)))

    assert [foot.side for foot in _proposed(store, patient, calendar).feet] == ["right"]


def test_why_a_foot_was_not_scanned_held_on_its_day_alone(
    store: RecordStore, patient: Patient, calendar: Calendar
) -> None:
    _declare(store, patient, "left", FootFacts(not_scanned="too tired"))
    calendar.now += timedelta(days=1)

    assert not _proposed(store, patient, calendar)


def test_load_and_skin_of_the_last_take_are_proposed_when_they_differ(
    store: RecordStore, patient: Patient, calendar: Calendar
) -> None:
    recording = store.data / "scans/20260302-120000-left/recording"
    (recording / "frames").mkdir(parents=True)
    (recording / "recording.toml").write_text('format = "footscan-recording/1"\n')
    (recording / "manifest.sha256").write_text(manifest_of(recording))
    take = store.file_take(patient.id, NewTake("left", "op", FIRST, load="seated", surface="bare"), recording)
    calendar.now += timedelta(days=30)
    proposed = _proposed(store, patient, calendar)

    assert (proposed.load, proposed.surface, proposed.feet) == ("seated", None, ())
    assert bool(proposed) and "scanned seated" in earlier_html(proposed)
    assert not find_earlier(store, patient.id, calendar.now.astimezone().date(), "seated", "bare")
    assert PageState(takes=(replace(take, in_use=True),)).next_side == "left"


def _take(side: Side, recorded: datetime) -> Take:
    said = NewTake(side, "op", recorded)
    return Take(1, 1, 1, 1, 1, said, (), datetime.now(UTC), True, "accepted", "op", "", True, "0" * 64)


def test_the_order_of_the_feet_begins_anew_with_every_day() -> None:
    now = datetime.now(UTC)
    long_ago = now - timedelta(days=200)
    both_then = (_take("left", long_ago), _take("right", long_ago))

    assert PageState(takes=both_then).next_side == "left"
    assert PageState(takes=(_take("left", now), *both_then)).next_side == "right"
    assert PageState(takes=(_take("left", now), _take("right", now), *both_then)).next_side is None


def test_a_foot_that_is_not_scanned_today_is_not_waited_for() -> None:
    left_out = Foot(1, 1, "left", FootFacts(not_scanned="in plaster"))

    assert PageState(feet=(left_out,)).next_side == "right"
