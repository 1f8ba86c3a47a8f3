"""Emulated devices behind ports, for the tests of the drivers."""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import pytest

from footscan.config.device_models import QsbModel
from footscan.config.io_models import AdamModel
from footscan.devices.values import Inputs
from footscan.sim.emulators.adam import AdamEmulator
from footscan.sim.emulators.panel import WiredPanel
from footscan.sim.emulators.pty_line import PtyLine
from footscan.sim.emulators.qsb import QsbEmulator


@dataclass
class Head:
    """A head that turns in one step; counts are what the encoder's signal shows."""

    count: int = 0

    def count_at(self, time_s: float) -> int:
        return self.count

    def turn(self, counts: int) -> int:
        self.count += counts
        return counts


@dataclass
class EmulatedQsb:
    head: Head
    device: QsbEmulator
    line: PtyLine

    def model(self, **settings: Any) -> QsbModel:
        return QsbModel(kind="qsb", port=self.line.port, **{"baud": self.device.baud, **settings})


@dataclass
class EmulatedIo:
    model: AdamModel
    panel: WiredPanel
    device: AdamEmulator
    line: PtyLine

    def press(self, name: str, closed: bool) -> None:
        self.panel.inputs = replace(self.panel.inputs, **{name: closed})


IO_TABLE: dict[str, Any] = {
    "kind": "adam",
    "dialect": "adam4055",
    "port": "/dev/nothing",
    "reply_timeout_s": 0.2,
    "outputs": {"laser_left": 0, "laser_right": 1, "motor_run": 2, "motor_reverse": 3},
    "inputs": {"estop_ok": 0, "home": 1, "button": 2, "inverted": ["home"]},
}


@pytest.fixture
def plug_qsb() -> Iterator[Callable[..., EmulatedQsb]]:
    lines: list[PtyLine] = []

    def plug(baud: int = 230400, bridge_s: float = 0.0, **settings: Any) -> EmulatedQsb:
        head = Head()
        count_at = settings.pop("count_at", head.count_at)
        device = QsbEmulator(count_at, time.monotonic(), baud=baud, **settings)
        lines.append(PtyLine(device, bridge_s=bridge_s))
        return EmulatedQsb(head, device, lines[-1])

    yield plug
    for line in lines:
        line.close()


@pytest.fixture
def plug_io() -> Iterator[Callable[..., EmulatedIo]]:
    lines: list[PtyLine] = []

    def plug(obeys_tripped: bool = True, **settings: Any) -> EmulatedIo:
        model = AdamModel.model_validate(IO_TABLE | settings)
        panel = WiredPanel(model, Inputs(0.0, estop_ok=True, home=False))
        device = AdamEmulator(
            model.dialect, panel, model.baud, model.address, model.checksum, obeys_tripped=obeys_tripped
        )
        lines.append(PtyLine(device))
        return EmulatedIo(model.model_copy(update={"port": lines[-1].port}), panel, device, lines[-1])

    yield plug
    for line in lines:
        line.close()
