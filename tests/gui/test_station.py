"""Examining tells every fault in words, also when the machine cannot be opened again, and the next look opens it."""

from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from footscan import app
from footscan.config.rig_file import Rig
from footscan.devices.diagnosis import Finding
from footscan.errors import DeviceError
from footscan.gui.station import Station
from footscan.workflow.designs import builtin_rig

GONE = "the camera /dev/video0 is gone; plug it in."


class Machine:
    """Its camera is plugged in, or not."""

    plugged = True
    opened = 0

    def examine(self, rig: Rig) -> Iterator[Finding]:
        yield Finding("encoder", "good", "it counts.")
        yield Finding("camera", "good", "it sees.") if self.plugged else Finding("camera", "trouble", GONE)

    def open(self, rig: Rig) -> Any:
        if not self.plugged:
            raise DeviceError(GONE)
        self.opened += 1
        return SimpleNamespace(give_back=lambda: None)


@pytest.fixture
def machine(monkeypatch: pytest.MonkeyPatch) -> Machine:
    machine = Machine()
    monkeypatch.setattr(app, "examine_devices", machine.examine)
    monkeypatch.setattr(app, "open_rig", machine.open)
    monkeypatch.setattr(app, "start_session", lambda opened, calibration: SimpleNamespace(close=lambda: None))
    monkeypatch.setattr(app, "calibration_in_force", lambda rig, data: (None, "no calibration"))
    return machine


def test_a_camera_that_is_gone_is_told_among_all_findings_and_opened_again_when_it_is_back(
    machine: Machine, tmp_path: Path
) -> None:
    station = Station(builtin_rig(), tmp_path, None)  # type: ignore[arg-type]
    station.open()
    machine.plugged = False
    ill = station.examine()
    machine.plugged = True
    well = station.examine()

    assert [finding.device for finding in ill[-3:]] == ["encoder", "camera", "machine"]
    assert [finding.grade for finding in ill[-3:]] == ["good", "trouble", "trouble"]
    assert GONE in ill[-1].sentence and "examine again" in ill[-1].sentence
    assert [finding.grade for finding in well if finding.device != "calibration"][-2:] == ["good", "good"]
    assert machine.opened == 2
