"""A store in a folder of its own, a clock that ticks, and recordings small enough to file by the dozen."""

from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, date, datetime, timedelta
from pathlib import Path
from random import Random

import pytest

from footscan.records import Measured, NewPatient, NewResult, NewTake, RecordStore
from footscan.scanning.recorder import manifest_of

NOON = datetime(2026, 11, 23, 12, 0, tzinfo=UTC)


class Clock:
    """A second passes with every look."""

    def __init__(self) -> None:
        self.now = NOON

    def __call__(self) -> datetime:
        self.now += timedelta(seconds=1)
        return self.now


@pytest.fixture
def data(tmp_path):
    return tmp_path / "data"


@pytest.fixture
def store(data):
    with RecordStore(data, wait_s=5.0, now=Clock()) as opened:
        yield opened


@pytest.fixture
def ana(store):
    return store.add_patient(NewPatient("Ana", date(1962, 3, 31)), "op")


@pytest.fixture
def bo(store):
    return store.add_patient(NewPatient("Bo", date(1980, 1, 1)), "op")


@pytest.fixture
def said():
    return NewTake("left", "op", NOON, load="seated", surface="bare", machine="m-1")


@pytest.fixture
def make_scan(data) -> Callable[..., Path]:
    """A scan folder of the data folder, different with every seed."""

    def make(seed: int = 0, *, finished: bool = True, results: bool = True) -> Path:
        scan = data / "scans" / f"20261123-1200{seed:02d}-left"
        recording, random = scan / "recording", Random(seed)
        (recording / "frames").mkdir(parents=True)
        (recording / "recording.toml").write_text(f'format = "footscan-recording/1"\nnotes = "{seed}"\n')
        for k in range(3):
            (recording / f"frames/{k:06d}.png").write_bytes(random.randbytes(100))
        if finished:
            (recording / "manifest.sha256").write_text(manifest_of(recording))
        if results:
            (scan / "results").mkdir()
            (scan / "results/scan.json").write_text(f'{{"seed": {seed}}}')
        (scan / "calibration.toml").write_text("calibration of the clinic\n")
        return scan

    return make


@pytest.fixture
def result():
    length = Measured("foot_length", 251.25, "mm", True, "", None, None, "heel to toe", "v1")
    girth = Measured("ball_girth", 240.5, "mm", False, "not seen", (231.0, 250.0), "wide", "tape around the ball", "v1")
    empty = Measured("instep_girth", None, "mm", False, "cut off", None, None, "over the instep", "v1")
    settings = {"threshold": None, "filter": {"kind": "off"}}
    return NewResult("left", "seated", (), "c" * 64, settings, {"footscan": "0.1"}, "", (length, girth, empty))


@pytest.fixture
def file_scan(store, make_scan, said, result):
    """File scan number `seed` for a patient."""

    def file(patient, seed=0, **changes):
        scan = make_scan(seed)
        fitting = replace(result, **{key: changes[key] for key in ("side", "load") if key in changes})
        parts = (scan / "recording", fitting, scan / "results", scan / "calibration.toml")
        return store.file_take(patient.id, replace(said, **changes), *parts)

    return file
