"""A sample of the drill over the real drivers, in real time; the whole of it is `make drill`."""

from pathlib import Path

import pytest

from footscan import app
from footscan.config.rig_file import Rig, load_rig
from footscan.config.toml_file import read_toml, toml_bytes, write_whole
from footscan.errors import ConfigError
from footscan.optics.tables import build_tables
from footscan.scanning.session.assembly import SessionSetup
from footscan.workflow.designs import builtin_config, builtin_rig
from footscan.workflow.drill import EMULATED_CASES, Drill, cases_of
from footscan.workflow.drill_result import TARGET_S, WATCHDOG_TARGET_S
from footscan.workflow.scan import find_scans

SMALLER = 3


@pytest.fixture(scope="module")
def rig(tmp_path_factory: pytest.TempPathFactory) -> Rig:
    """The emulated rig with a ninth of the pixels and a quick head, as a file: another program has to read it."""
    table = read_toml(builtin_config("rig-emulated"))
    camera = table["camera"]
    for key in ("width_px", "height_px"):
        camera[key] //= SMALLER
    for key in ("pixel_pitch_y_mm", "pixel_pitch_z_mm"):
        camera[key] *= SMALLER
    camera["principal_point_px"] = [value / SMALLER for value in camera["principal_point_px"]]
    table["motion"] |= {"speeds_deg_per_s": [30.0, 90.0], "acceleration_deg_per_s2": 800.0}
    table["motion"]["profile"] = [{"name": "standard", "angle_step_deg": 4.0}]
    table["devices"]["world"]["person"] = "statue"
    path = tmp_path_factory.mktemp("rig") / "rig.toml"
    write_whole(path, toml_bytes(table))
    return load_rig(path)


def drill_of(rig: Rig, folder: Path, seed: int = 0) -> Drill:
    calibration = app.true_machine(rig).calibration
    setup = SessionSetup(rig.scanner, rig.motion, calibration, build_tables(calibration))
    return Drill(rig, app.open_rig, app.serve_emulators, setup, seed, folder)


@pytest.mark.parametrize(("case", "target_s"), [("camera-frozen", TARGET_S), ("io-unplugged", WATCHDOG_TARGET_S)])
def test_a_scan_over_real_drivers_ends_dark_told_and_kept(case: str, target_s: float, rig: Rig, tmp_path: Path):
    (result,) = drill_of(rig, tmp_path).run((case,))

    assert result.target_s == target_s
    assert result.well


def test_a_killed_program_leaves_the_beams_to_the_modules_watchdog(rig: Rig, tmp_path: Path):
    (result,) = drill_of(rig, tmp_path).run(("kill -9",))
    stored = find_scans(tmp_path / "kill--9")

    assert 0.0 < result.off_after_s <= WATCHDOG_TARGET_S
    assert result.well
    assert not stored[-1].finished
    assert stored[-1].frames == result.kept >= 10


def test_every_fault_of_an_emulated_machine_is_a_case(rig: Rig):
    assert cases_of(rig) == EMULATED_CASES
    assert len(set(EMULATED_CASES)) == len(EMULATED_CASES)
    assert set(cases_of(builtin_rig())) - set(EMULATED_CASES) == set()


def test_a_rig_without_emulators_is_not_served(tmp_path: Path):
    with (
        pytest.raises(ConfigError, match='nothing in it is "emulated"'),
        app.serve_emulators(builtin_rig(), tmp_path),
    ):
        pass
