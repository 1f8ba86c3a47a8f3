"""Fixtures shared by all rooms: shared data when it is there, a simulated scan that the project makes itself."""

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings

from footscan.config import load_calibration
from footscan.optics.calibration import Calibration
from footscan.optics.scanner import Scanner, calibration_from_design
from footscan.workflow.designs import builtin_scanner
from footscan.workflow.simulate import SimulateSettings, simulate_scan

settings.register_profile("footscan", deadline=None)  # how long an example takes says how busy the computer is
settings.load_profile("footscan")
_REAL_TIME = ("tests/devices/", "tests/gui/", "tests/sim/test_emulat", "tests/cli/test_emulate", "tests/cli/test_serve",
              "tests/workflow/test_drill")  # fmt: skip
"""Tests of wires, watchdogs and browsers: with `-n 2` they run one after the other in one of the workers. What a busy
computer was too slow for is tried again, as the drill itself does."""
_THREADS = (*_REAL_TIME, "tests/scanning/session/", "tests/cli/test_scan_command", "tests/workflow/test_guided")
"""Their clock is virtual or their waits are long; yet threads that the computer leaves waiting can come too late."""


@pytest.hookimpl(tryfirst=True)  # before xdist reads the groups
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    for item in items:
        place = item.path.relative_to(config.rootpath).as_posix()
        if place.startswith(_REAL_TIME):
            item.add_marker(pytest.mark.xdist_group("real time"))
        if place.startswith(_THREADS) and not item.get_closest_marker("browser"):  # those: on the command line
            item.add_marker(pytest.mark.flaky(reruns=2))


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--rig", help="rig file of a real machine, for the tests marked hardware")


@pytest.fixture(scope="session")
def shared_dir() -> Path:
    place = os.environ.get("FOOTSCAN_SHARED")
    if not place or not (Path(place) / "data").is_dir():
        pytest.skip("FOOTSCAN_SHARED does not name the shared data")
    return Path(place)


@pytest.fixture(scope="session")
def prototype() -> Scanner:
    return builtin_scanner("prototype")


@pytest.fixture(scope="session")
def ideal(prototype: Scanner) -> Calibration:
    return calibration_from_design(prototype)


@pytest.fixture(scope="session")
def small_scan(tmp_path_factory: pytest.TempPathFactory, prototype: Scanner) -> Path:
    """A recording of the built-in foot on a workshop machine, 48 frames a sweep; never written to."""
    folder = tmp_path_factory.mktemp("simulated") / "scan"
    simulate_scan(prototype, SimulateSettings("foot", seed=3, frames_per_sweep=48), folder, lambda done, total: None)
    return folder


@pytest.fixture(scope="session")
def workshop(small_scan: Path) -> Calibration:
    """The true calibration of the machine of `small_scan`: nothing about it is ideal."""
    return load_calibration(small_scan / "truth-calibration.toml")


@pytest.fixture
def scan_copy(small_scan: Path, tmp_path: Path) -> Path:
    """A copy of `small_scan` to break."""
    return Path(shutil.copytree(small_scan, tmp_path / "scan"))


@pytest.fixture
def edit_csv() -> Callable[[Path, Callable[[list[str]], list[str]]], None]:
    def edit(path: Path, change: Callable[[list[str]], list[str]]) -> None:
        lines = path.read_text().splitlines()
        path.write_text("\n".join([lines[0], *change(lines[1:])]) + "\n")

    return edit


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(11)
