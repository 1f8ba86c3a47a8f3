from collections.abc import Callable, Iterator

import numpy as np
import pytest

from footscan.config import DEFAULT_BOARD, board_toml
from footscan.config.recording_file import RecordingInfo
from footscan.errors import InterlockError, RecordingError
from footscan.scanning.recording import open_recording
from footscan.scanning.session.states import State
from footscan.scanning.session.stops import (
    PassOrder,
    StopsOrder,
    begin_calibration,
    even_stops,
    record_pass,
    record_stops,
)
from footscan.workflow.guided_calibration import GuidedCalibration
from tests.scanning.session.conftest import Bench, opened_bench

INFO = RecordingInfo("calibration", "none", "2026-01-01T00:00:00+00:00")


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bench]:
    """Three stops of placement 0 and one of the bare board, then a pass of placement 0, without any calibration."""
    bench = opened_bench(tmp_path_factory.mktemp("stops"), calibrated=False)
    bench.ready()
    bench.folder.mkdir()
    (bench.folder / "board.toml").write_bytes(board_toml(DEFAULT_BOARD))
    bench.session.post(lambda machine: begin_calibration(machine, bench.folder, INFO)).wait(30)
    for order in (StopsOrder("0", even_stops(3)), StopsOrder("empty", (1.0,))):
        bench.session.post_arm(no_faces_at_beam_height=True).wait(30)
        bench.session.post(lambda machine, order=order: record_stops(machine, order)).wait(120)
    bench.session.post_arm(no_faces_at_beam_height=True).wait(30)
    bench.session.post(lambda machine: record_pass(machine, PassOrder("0", 0.5, 1.5))).wait(120)
    bench.session.post(lambda machine: machine.keeper.end()).wait(30)
    bench.wait_until(lambda: bench.session.settled)
    yield bench
    bench.session.close()


def test_each_stop_has_its_three_lights_and_its_placements_name(recorded: Bench):
    records = [record for record in open_recording(recorded.folder).frames if record.sweep == "static"]
    seen = [(record.setup, record.laser) for record in records]

    assert seen == [("0", "none"), ("0", "right"), ("0", "left")] * 3 + [
        ("empty", "none"),
        ("empty", "right"),
        ("empty", "left"),
    ]


def test_the_light_of_a_stop_is_what_shone_although_the_latency_is_unknown(recorded: Bench):
    latency_s = recorded.world.machine.calibration.latency_s
    records = open_recording(recorded.folder).frames
    shone = [recorded.world.lasers_at(record.time_s - latency_s) for record in records]

    assert latency_s > 0.001
    assert [lasers or ("none",) for lasers in shone] == [(record.laser,) for record in records]


def test_the_head_stands_still_at_stops_and_passes_both_ways(recorded: Bench):
    recording = open_recording(recorded.folder)
    static = [record for record in recording.frames if record.sweep == "static"]
    speed = [
        np.ptp(np.interp([record.time_s - 0.05, record.time_s], recording.encoder.time_s, recording.encoder.count))
        for record in static
    ]

    assert max(speed) <= 1
    for sweep in ("ccw", "cw"):
        passing = [record for record in recording.frames if record.sweep == sweep]
        assert len(passing) > 20
        assert {(record.setup, record.laser) for record in passing} == {("0", "none")}


def test_after_each_placement_the_machine_is_dark_and_must_be_armed_anew(recorded: Bench):
    with pytest.raises(InterlockError, match="armed"):
        recorded.session.post(lambda machine: record_stops(machine, StopsOrder("1", (2.0,)))).wait(30)

    assert recorded.world.off_since_s is not None
    assert recorded.session.snapshot().state is State.STOPPED


def test_a_placement_without_a_board_says_why_it_was_not_found(open_bench: Callable[..., Bench]) -> None:
    bench: Bench = open_bench(calibrated=False)
    assert bench.opened.put_calibration_board is not None
    bench.opened.put_calibration_board(None)
    guided = GuidedCalibration(bench.session, bench.folder, DEFAULT_BOARD, stops=8)
    bench.session.post_arm(no_faces_at_beam_height=True).wait(30)
    guided.begin("test")
    bench.session.post_arm(no_faces_at_beam_height=True).wait(30)
    report = guided.record_placement()
    missing = guided.expected_error_mm()
    guided.finish()

    assert report.angles_rad == ()
    assert len(report.why) > 20
    assert missing[0] is None
    assert "at least 4" in missing[1]
    assert guided.left_out == {"1"}
    assert len(list((bench.folder / "frames").glob("*.png"))) == 24  # left out of the table, not lost
    with pytest.raises(RecordingError, match="no rows"):
        open_recording(bench.folder)
