from pathlib import Path

import cv2
import numpy as np
import pytest
import trimesh

from footscan.config import load_calibration
from footscan.errors import InputError, RecordingError
from footscan.optics.calibration import theta_from_encoder
from footscan.scanning.recording import open_recording
from footscan.sim.machine import TrueMachine
from footscan.sim.motion import SweepPlan
from footscan.sim.objects import build_sphere
from footscan.sim.obstacles import Part
from footscan.sim.record import SimulatedScan, prepare_scan, simulate_recording


@pytest.fixture
def scan(machine: TrueMachine) -> SimulatedScan:
    plan = SweepPlan(frames_per_sweep=8, frames_per_s=20.0)
    return prepare_scan(machine, build_sphere(40.0, np.array([0.0, 0.0, 50.0]), subdivisions=3), plan, seed=9)


def test_recording_holds_both_sweeps_with_their_own_lasers(tmp_path: Path, scan: SimulatedScan):
    simulate_recording(tmp_path / "new" / "scan", scan, "left")
    recording = open_recording(tmp_path / "new" / "scan")

    assert [(record.laser, record.sweep) for record in recording.frames] == [("right", "ccw")] * 8 + [
        ("left", "cw")
    ] * 8
    assert recording.info.side == "left"
    assert recording.scanner == scan.machine.scanner


def test_truth_beside_the_recording_is_the_machine_and_the_surface(tmp_path: Path, scan: SimulatedScan):
    simulate_recording(tmp_path, scan)
    truth = load_calibration(tmp_path / "truth-calibration.toml")
    mesh = trimesh.load(tmp_path / "truth.stl")

    assert truth.camera == scan.machine.calibration.camera
    assert truth.latency_s == scan.machine.calibration.latency_s
    assert np.allclose(truth.lasers[0].normal, scan.machine.calibration.lasers[0].normal, atol=1e-15)
    assert np.allclose(mesh.bounds[1] - mesh.bounds[0], 80.0, atol=0.2)


def test_count_at_the_stamp_less_the_latency_is_the_angle_of_the_exposure(scan: SimulatedScan):
    calibration = scan.machine.calibration
    time_s, count = scan.counts()
    taken = list(scan.frames())
    at_exposure = np.interp([frame.time_s - calibration.latency_s for frame in taken], time_s, count)
    late = np.interp([frame.time_s for frame in taken], time_s, count)
    theta = np.array([frame.theta_rad for frame in taken])

    assert np.max(np.abs(theta_from_encoder(at_exposure, calibration.encoder) - theta)) < np.pi / 8000
    assert np.max(np.abs(theta_from_encoder(late, calibration.encoder) - theta)) > 4.0 * np.pi / 8000


def test_two_recordings_of_one_seed_are_the_same_to_the_byte(tmp_path: Path, scan: SimulatedScan):
    for name in ("one", "two"):
        simulate_recording(tmp_path / name, scan, created="2026-01-01T00:00:00+00:00")
    files = sorted(path.relative_to(tmp_path / "one") for path in (tmp_path / "one").rglob("*") if path.is_file())

    assert len(files) >= 16 + 6
    assert all((tmp_path / "one" / file).read_bytes() == (tmp_path / "two" / file).read_bytes() for file in files)


def test_frames_on_disk_are_the_frames_taken(tmp_path: Path, scan: SimulatedScan):
    simulate_recording(tmp_path, scan)
    taken = next(scan.frames())

    assert np.array_equal(cv2.imread(str(tmp_path / "frames" / "000000.png"), cv2.IMREAD_UNCHANGED), taken.frame)


def test_a_recording_is_never_overwritten(tmp_path: Path, scan: SimulatedScan):
    simulate_recording(tmp_path, scan)
    with pytest.raises(RecordingError, match="already holds"):
        simulate_recording(tmp_path, scan)


def ball_scan(machine: TrueMachine, plan: SweepPlan) -> SimulatedScan:
    return prepare_scan(machine, build_sphere(40.0, np.array([0.0, 0.0, 50.0]), subdivisions=3), plan, seed=9)


def test_every_third_frame_is_unlit_and_holds_no_laser_light(machine: TrueMachine):
    frames = list(ball_scan(machine, SweepPlan(frames_per_sweep=6, unlit_every=3)).frames())

    assert [frame.laser for frame in frames] == ["right", "right", "none"] * 2 + ["left", "left", "none"] * 2
    assert all((frame.frame.max() > 80) == (frame.laser != "none") for frame in frames)


def test_alternating_lasers_share_one_sweep_and_unlit_frames_do_not_break_their_turn(machine: TrueMachine):
    frames = list(ball_scan(machine, SweepPlan(frames_per_sweep=6, unlit_every=3, alternating=True)).frames())

    assert [frame.laser for frame in frames] == ["right", "left", "none", "right", "left", "none"]
    assert {frame.sweep for frame in frames} == {"ccw"}


def test_a_plan_without_lit_frames_is_refused(machine: TrueMachine):
    with pytest.raises(InputError, match="1 would leave no lit frame"):
        ball_scan(machine, SweepPlan(unlit_every=1))


def test_obstacles_are_painted_and_no_part_of_the_truth(tmp_path: Path, machine: TrueMachine):
    ball = build_sphere(40.0, np.array([0.0, 0.0, 50.0]), subdivisions=3)
    post = Part(build_sphere(30.0, np.array([60.0, -60.0, 60.0]), subdivisions=3), 0.5)
    plan = SweepPlan(frames_per_sweep=2)
    free = next(prepare_scan(machine, ball, plan).frames()).frame
    scan = prepare_scan(machine, ball, plan, obstacles=(post,))
    simulate_recording(tmp_path, scan)

    assert not np.array_equal(next(scan.frames()).frame, free)
    assert len(trimesh.load(tmp_path / "truth.stl").faces) == len(ball.faces)
