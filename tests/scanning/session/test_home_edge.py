from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from footscan import app
from footscan.devices.clock import Clock
from footscan.devices.protocols import DigitalIo
from footscan.devices.values import Inputs, Outputs
from footscan.scanning.session.home_edge import Crossing, fit_edge
from footscan.scanning.session.programs import home
from footscan.sim.clock import VirtualClock
from tests.scanning.session.conftest import Bench, small_rig

brackets = st.lists(st.tuples(st.floats(0.0, 40.0), st.floats(0.0, 40.0)), min_size=1, max_size=6)


@given(brackets, st.integers(-(10**6), 10**6))
def test_an_edge_lies_in_what_its_crossings_have_in_common(parts: list[tuple[float, float]], edge: int) -> None:
    crossings = [Crossing(edge - before, edge + after) for before, after in parts]
    found, sigma = fit_edge(crossings)
    halved = fit_edge([*crossings, Crossing(found, max(c.open_counts for c in crossings))])

    assert abs(found - edge) <= 0.5 * min(c.open_counts - c.closed_counts for c in crossings) + 1e-6
    assert sigma <= min(c.sigma_counts for c in crossings) + 1e-12
    assert halved[1] <= sigma


def test_a_switch_that_plays_is_found_in_the_middle_and_its_play_is_said() -> None:
    found, sigma = fit_edge([Crossing(10.0, 12.0), Crossing(20.0, 22.0)])

    assert found == pytest.approx(16.0)
    assert sigma >= 5.0


class SlowIo:
    """A module behind a slow line: each look at its inputs takes a while, and they are those of half-way."""

    def __init__(self, io: DigitalIo, clock: Clock, takes_s: float) -> None:
        self._io, self._clock, self._takes_s, self._looks = io, clock, takes_s, 0

    def __getattr__(self, name: str) -> object:
        return getattr(self._io, name)

    def set_outputs(self, outputs: Outputs) -> None:
        self._io.set_outputs(outputs)

    def read_inputs(self) -> Inputs:
        self._looks += 1
        if self._looks == 1:  # while the session is built, outside of the clock's threads
            return self._io.read_inputs()
        self._clock.wait(self._clock.now_s() + 0.5 * self._takes_s)
        inputs = self._io.read_inputs()
        self._clock.wait(self._clock.now_s() + 0.5 * self._takes_s)
        return inputs


@pytest.mark.parametrize(("takes_s", "at_most_deg"), [(0.0, 0.05), (0.015, 0.08), (0.03, 0.08)])
def test_homing_finds_the_switch_also_through_a_slow_line(
    open_bench: Callable[..., Bench], monkeypatch: pytest.MonkeyPatch, takes_s: float, at_most_deg: float
) -> None:
    rig = small_rig(speeds_deg_per_s=(18.75, 60.0))
    opening = app.open_rig

    def slow(*arguments: object) -> object:
        opened = opening(*arguments)  # type: ignore[arg-type]
        devices = opened.devices
        return replace(opened, devices=replace(devices, io=SlowIo(devices.io, devices.clock, takes_s)))

    monkeypatch.setattr(app, "open_rig", slow)
    bench = open_bench(rig)
    assert isinstance(bench.session.clock, VirtualClock)
    bench.session.post_arm(no_faces_at_beam_height=True).wait(30)
    off_deg = []
    for _ in range(3):
        bench.session.post(home).wait(60)
        shown_deg = bench.session.snapshot().theta_deg
        calibration = bench.session.setup.calibration
        assert shown_deg is not None
        assert calibration is not None
        off = calibration.encoder.zero_count * 360.0 / 8000
        off_deg.append(
            shown_deg - off - np.rad2deg(float(bench.world.theta_at(np.array([bench.session.clock.now_s()]))[0]))
        )

    assert np.abs(off_deg).max() < at_most_deg
