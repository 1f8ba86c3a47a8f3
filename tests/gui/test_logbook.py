"""The log of the page: on the disk, newest first, one line per change of state."""

from pathlib import Path

from footscan.gui.logbook import Logbook
from footscan.scanning.session.states import Snapshot, State


def test_lines_are_on_the_disk_and_shown_newest_first(tmp_path: Path) -> None:
    log = Logbook(tmp_path / "page.log")
    log.write("browser 1\ncontrols")
    log.write("browser 2 asks")

    assert [line.split("  ", 1)[1] for line in log.latest(9)] == ["browser 2 asks", "browser 1 controls"]
    assert len((tmp_path / "page.log").read_text().splitlines()) == 2


def test_a_state_is_written_once(tmp_path: Path) -> None:
    log = Logbook(tmp_path / "page.log")
    for _ in range(5):
        log.note_state(Snapshot(State.PARKED))
    log.note_state(Snapshot(State.FAULT, "the camera is gone"))

    assert log.count == 2
    assert log.latest(1)[0].endswith("machine: the camera is gone")


def test_a_disk_that_cannot_be_written_is_said_and_ends_nothing(tmp_path: Path) -> None:
    log = Logbook(tmp_path / "missing" / "page.log")
    log.write("something")

    assert "cannot be written" in log.latest(1)[0]
    assert "something" in log.latest(2)[1]
