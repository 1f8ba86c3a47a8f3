"""A seeded sample of the fault drill; the whole of it is `make drill`."""

from dataclasses import replace
from pathlib import Path

import pytest

from footscan import app
from footscan.optics.tables import build_tables
from footscan.scanning.recording import open_recording
from footscan.scanning.session.assembly import SessionSetup
from footscan.workflow.designs import builtin_rig
from footscan.workflow.drill import CASES, Drill
from footscan.workflow.drill_result import TARGET_S
from footscan.workflow.scan import find_scans
from tests.scanning.session.conftest import small_rig


def small_drill(folder: Path, seed: int) -> Drill:
    rig = small_rig()
    calibration = app.true_machine(rig).calibration
    setup = SessionSetup(rig.scanner, rig.motion, calibration, build_tables(calibration))
    return Drill(rig, app.open_rig, app.serve_emulators, setup, seed, folder)


@pytest.mark.parametrize(
    "case",
    [
        "exception in the grab thread",
        "exception in the keeper thread",
        "exception in the live thread",
        "exception in the control thread",
        "program closed",
        "page closed",
        "full disk",
    ],
)
def test_a_broken_scan_ends_dark_and_still_told_and_kept(case: str, tmp_path: Path):
    (result,) = small_drill(tmp_path, seed=CASES.index(case)).run((case,))

    assert 0.0 <= result.off_after_s <= TARGET_S
    assert len(result.told) > 20
    assert result.captured == result.named
    assert result.kept > 0
    assert result.well


def test_a_killed_program_leaves_a_dark_machine_and_a_readable_scan(tmp_path: Path):
    rig = builtin_rig()
    calibration = app.true_machine(rig).calibration
    drill = replace(
        small_drill(tmp_path, seed=4), rig=rig, setup=SessionSetup(rig.scanner, rig.motion, calibration, None)
    )
    (result,) = drill.run(("kill -9",))
    (stored,) = find_scans(tmp_path / "kill--9")

    assert 0.0 <= result.off_after_s <= TARGET_S
    assert result.kept >= 10
    assert result.unlisted <= 1
    assert not stored.finished
    assert stored.frames == result.kept == len(open_recording(stored.folder / "recording").frames)
