from pathlib import Path

import pytest

from footscan.config import load_scanner
from footscan.optics.scanner import Scanner
from footscan.sim.machine import TrueMachine, workshop_machine

CONFIGS = Path(__file__).parents[2] / "configs"


@pytest.fixture(scope="session")
def prototype() -> Scanner:
    return load_scanner(CONFIGS / "prototype.toml")


@pytest.fixture(scope="session")
def machine(prototype: Scanner) -> TrueMachine:
    return workshop_machine(prototype, seed=5)
