import json
from collections import Counter
from dataclasses import replace

import cv2
import numpy as np
import pytest
import trimesh

from footscan.config import load_calibration
from footscan.errors import (
    EmptyScanError,
    FootscanError,
    InputError,
    MachineMismatchError,
    MeshError,
    QualityError,
    RecordingError,
)
from footscan.scanning.angles import FrameAngles
from footscan.scanning.filters import FilterSettings
from footscan.scanning.footboard import height_above
from footscan.scanning.matrix import load_scan_matrix
from footscan.scanning.point_file import load_points
from footscan.scanning.recording import FrameRecord, open_recording
from footscan.scanning.sweep import SweepSettings, silent_frames
from footscan.sim.foot import FootShape, build_foot
from footscan.sim.machine import ideal_machine
from footscan.sim.motion import SweepPlan
from footscan.sim.objects import build_sphere
from footscan.sim.record import prepare_scan, simulate_recording
from footscan.workflow.foot import FootSettings
from footscan.workflow.process import ProcessSettings, process_recording, scan_report
from footscan.workflow.results import check_alone, save_results
from footscan.workflow.simulate import run_demo
from footscan.workflow.truth import distance_to_surface_mm


def processed(folder, calibration, **settings):
    return process_recording(open_recording(folder), calibration, ProcessSettings(**settings))


@pytest.fixture(scope="module")
def result(small_scan, workshop):
    return processed(small_scan, workshop)


def off_truth_mm(folder, cloud):
    truth = trimesh.load(folder / "truth.stl", force="mesh")
    return distance_to_surface_mm(cloud.xyz_world, np.asarray(truth.vertices, float), np.asarray(truth.faces))


def test_a_simulated_workshop_machine_gives_the_true_foot(result, small_scan):
    off_mm = off_truth_mm(small_scan, result.cloud)

    assert np.sqrt(np.mean(off_mm**2)) < 0.08
    assert (off_mm > 1.0).mean() < 0.001
    assert len(result.cloud) > 10000


def test_every_frame_and_every_point_is_accounted_for(result, small_scan):
    report = scan_report(result, ProcessSettings())
    points = report["points"]

    assert report["frames"]["seen"] == 96
    assert report["frames"]["used"] + sum(report["frames"]["rejected"].values()) == 96
    assert points["right"] + points["left"] == points["kept"] + sum(points["removed"].values())
    assert points["kept"] == points["kept_right"] + points["kept_left"] == len(result.cloud)


def test_one_threshold_is_used_and_recorded(result, small_scan, workshop):
    given = processed(small_scan, workshop, sweep=SweepSettings(threshold=80))

    assert scan_report(result, ProcessSettings())["threshold_source"] == "automatic"
    assert 20 <= result.sweep.threshold <= 60
    assert given.sweep.threshold == 80
    assert len(given.cloud) < len(result.cloud)


def test_the_lasers_agree_on_a_foot_that_stood_still(result):
    known = [zone for zone in result.agreement if zone.median_mm is not None]

    assert {zone.zone for zone in known} >= {"midfoot", "ball"}  # 48 frames a turn leave wide gaps at heel and toes
    assert all(abs(zone.median_mm) < 0.05 for zone in known)
    assert all(zone.overlap_area_mm2 > 100 for zone in known)
    assert result.board.remark == ""


def test_what_is_saved_can_be_read_again(result, tmp_path):
    report = save_results(result, ProcessSettings(), tmp_path / "out")
    points = load_points(tmp_path / "out/points.ply")
    matrix = load_scan_matrix(tmp_path / "out/matrix.npz", report["calibration"]["sha256"])

    assert json.loads((tmp_path / "out/scan.json").read_text()) == json.loads(json.dumps(report))
    assert len(points) == report["points"]["kept"]
    assert matrix.points_per_frame.sum() == report["points"]["right"] + report["points"]["left"]
    assert cv2.imread(str(tmp_path / "out/preview.png")).shape[0] > 300


def test_one_thread_and_two_give_the_same_points(small_scan, workshop, result):
    single = processed(small_scan, workshop, sweep=SweepSettings(threads=1))

    np.testing.assert_array_equal(single.cloud.xyz_world, result.cloud.xyz_world)


@pytest.mark.parametrize("kind", ["median", "gaussian"])
def test_a_picture_filter_changes_points_little_and_is_recorded(small_scan, workshop, kind):
    settings = ProcessSettings(SweepSettings(picture_filter=FilterSettings(kind)))
    calm = process_recording(open_recording(small_scan), workshop, settings)

    assert np.median(off_truth_mm(small_scan, calm.cloud)) < 0.1
    assert scan_report(calm, settings)["filter"]["kind"] == kind


def test_the_unlit_filter_uses_the_unlit_frames_and_they_are_rejects(scan_copy, workshop, edit_csv):
    cv2.imwrite(str(scan_copy / "frames/dark.png"), np.full((500, 582), 4, np.uint8))
    edit_csv(scan_copy / "frames.csv", lambda rows: ["900,frames/dark.png,0.0,none,static,", *rows])
    dark = processed(scan_copy, workshop, sweep=SweepSettings(picture_filter=FilterSettings("unlit")))

    assert dark.sweep.accounting.rejected == {"unlit": 1}
    assert dark.sweep.accounting.used == 96


@pytest.mark.parametrize(
    ("damage", "reason"),
    [
        (lambda p: p.unlink(), "missing"),
        (lambda p: p.write_bytes(b""), "empty file"),
        (lambda p: p.write_bytes(p.read_bytes()[:400]), "cut file"),
        (lambda p: cv2.imwrite(str(p), np.zeros((4000, 4000), np.uint8)), "wrong size"),
    ],
)
def test_a_bad_picture_costs_one_frame_and_is_named(scan_copy, workshop, damage, reason):
    damage(scan_copy / "frames/000010.png")
    result = processed(scan_copy, workshop)

    assert result.sweep.accounting.rejected == {reason: 1}
    assert result.sweep.accounting.used == 95
    assert "000010.png" in result.sweep.accounting.details[0]


def test_frames_without_encoder_samples_are_named_rejects(scan_copy, workshop, edit_csv):
    def without_a_second(rows):
        return [row for row in rows if not 0.5 <= float(row.split(",")[0]) < 1.0]

    edit_csv(scan_copy / "encoder.csv", without_a_second)
    accounting = processed(scan_copy, workshop).sweep.accounting

    assert 7 <= accounting.rejected["no encoder sample near"] <= 10
    assert accounting.used + accounting.rejected.total() == 96


def test_a_frame_whose_time_goes_back_is_a_named_reject(scan_copy, workshop, edit_csv):
    def swapped(rows):
        first, second = rows[20].split(","), rows[21].split(",")
        first[2], second[2] = second[2], first[2]
        return [*rows[:20], ",".join(first), ",".join(second), *rows[22:]]

    edit_csv(scan_copy / "frames.csv", swapped)

    assert processed(scan_copy, workshop).sweep.accounting.rejected == {"time goes back": 1}


def test_a_silent_encoder_is_refused(scan_copy, workshop, edit_csv):
    edit_csv(scan_copy / "encoder.csv", lambda rows: [row.split(",")[0] + ",1234" for row in rows])

    with pytest.raises(RecordingError, match="encoder is silent"):
        processed(scan_copy, workshop)


def test_frames_at_which_the_angle_stands_still_inside_a_sweep_are_found():
    theta = np.concatenate(
        [np.zeros(3), np.arange(1, 11) * 0.02, np.full(4, 0.2), 0.2 + np.arange(1, 11) * 0.02, [0.4] * 2]
    )
    records = [FrameRecord(i, str(i), float(i), "right", "ccw", "") for i in range(len(theta))]
    silent = silent_frames(records, np.arange(len(theta), dtype=float), FrameAngles(theta, np.ones(len(theta), bool)))

    assert np.flatnonzero(silent).tolist() == [12, 13, 14, 15, 16]


def test_one_wild_time_stamp_costs_one_frame(scan_copy, workshop, edit_csv):
    def wild(rows):
        row = rows[20].split(",")
        row[2] = "99999.0"
        return [*rows[:20], ",".join(row), *rows[21:]]

    edit_csv(scan_copy / "frames.csv", wild)

    assert processed(scan_copy, workshop).sweep.accounting.rejected == {"no encoder sample near": 1}


def test_a_damaged_unlit_frame_is_passed_over(scan_copy, workshop, edit_csv):
    cv2.imwrite(str(scan_copy / "frames/dark.png"), np.full((500, 582), 4, np.uint8))
    (scan_copy / "frames/bad.png").write_bytes(b"nothing")
    rows = ["900,frames/bad.png,1.0,none,static,", "901,frames/dark.png,0.0,none,static,"]
    edit_csv(scan_copy / "frames.csv", lambda old: [*rows, *old])
    dark = processed(scan_copy, workshop, sweep=SweepSettings(picture_filter=FilterSettings("unlit")))

    assert dark.sweep.accounting.used == 96


def test_filtering_and_smoothing_state_their_price_and_leave_the_original(result, tmp_path):
    points = result.cloud.xyz_world.copy()
    report = save_results(result, ProcessSettings(foot=FootSettings(0.5, 12.0)), tmp_path / "smooth")
    plain = save_results(result, ProcessSettings(), tmp_path / "plain")
    price = report["foot"]["filtering_and_smoothing"]

    np.testing.assert_array_equal(result.cloud.xyz_world, points)
    assert price["before"]["mesh_volume_cm3"] == pytest.approx(plain["foot"]["volume_cm3"], abs=0.01)
    assert price["after"]["mesh_volume_cm3"] == pytest.approx(report["foot"]["volume_cm3"], abs=0.01)
    assert price["after"] != price["before"]
    assert plain["foot"]["filtering_and_smoothing"] == {}
    assert (tmp_path / "plain/points.ply").read_bytes() == (tmp_path / "smooth/points.ply").read_bytes()


@pytest.mark.parametrize("wrong", [{"filter_strength": 2.0}, {"smooth_mm": -1.0}])
def test_impossible_smoothing_is_refused(wrong):
    with pytest.raises(InputError, match="allowed are 0"):
        FootSettings(**wrong)


def test_results_of_an_earlier_scan_never_stay_beside_new_ones(result, tmp_path):
    save_results(result, ProcessSettings(), tmp_path / "out")
    save_results(result, ProcessSettings(kind="last"), tmp_path / "out")

    assert not (tmp_path / "out/measurements.json").exists()
    assert not (tmp_path / "out/report.png").exists()
    assert (tmp_path / "out/points.ply").is_file()


def test_of_a_last_the_skin_is_closed_and_what_is_not_seen_is_said(result, tmp_path):
    report = save_results(result, ProcessSettings(kind="last"), tmp_path / "out")
    mesh = trimesh.load(tmp_path / "out/surface.stl")

    assert mesh.is_watertight
    assert "foot" not in report
    assert 0.0 < report["last"]["skin"]["seen"] < 1.0
    assert any("bottom is not seen" in remark for remark in report["remarks"])
    assert (tmp_path / "out/surface.ply").is_file()


def test_a_board_that_sank_or_rose_is_said_and_still_taken_out(small_scan, workshop):
    for offset_mm in (-4.0, 4.0):
        elsewhere = replace(workshop, floor=replace(workshop.floor, offset_mm=workshop.floor.offset_mm + offset_mm))
        moved = processed(small_scan, elsewhere)
        assert moved.board.offset_mm == pytest.approx(-offset_mm, abs=0.1)
        assert "recalibrate" in moved.remarks[-1]
        assert height_above(workshop.floor, moved.cloud.xyz_world).min() > 1.5


def test_a_scan_of_one_laser_is_refused_unless_that_was_allowed(scan_copy, workshop, edit_csv):
    edit_csv(scan_copy / "frames.csv", lambda rows: [row for row in rows if "right" in row])

    with pytest.raises(RecordingError, match="no frame of the left laser"):
        processed(scan_copy, workshop)
    allowed = processed(scan_copy, workshop, one_laser=True)
    assert "the result rests on one laser" in allowed.remarks[0]
    assert set(allowed.cloud.laser) == {0}


def test_a_laser_of_which_hardly_anything_came_is_as_good_as_dark(scan_copy, workshop):
    for path in sorted((scan_copy / "frames").glob("*.png"))[49:]:
        cv2.imwrite(str(path), np.zeros((500, 582), np.uint8))

    with pytest.raises(EmptyScanError, match=r"only \d+ stripe points of the left laser"):
        processed(scan_copy, workshop)


def test_when_no_picture_can_be_read_nobody_is_sent_to_the_lasers(scan_copy, workshop):
    for path in (scan_copy / "frames").glob("*.png"):
        path.unlink()

    with pytest.raises(RecordingError, match="none of 96 frames can be used: 96 x missing"):
        processed(scan_copy, workshop)


def test_many_rejected_frames_and_changed_files_are_remarked(scan_copy, workshop):
    for number in range(10):
        (scan_copy / f"frames/{number:06d}.png").write_bytes(b"")
    remarks = " ".join(processed(scan_copy, workshop).remarks)

    assert "10 of 96 frames were rejected: 10 x empty file" in remarks
    assert "the recording is not as it was finished: frames/000000.png was changed" in remarks
    assert remarks.endswith("and 7 more")


def test_a_foot_hardly_seen_is_refused_and_its_points_stay(scan_copy, workshop, tmp_path):
    for number in range(96):
        if number % 4:
            (scan_copy / f"frames/{number:06d}.png").write_bytes(b"")
    sparse = processed(scan_copy, workshop)

    with pytest.raises((QualityError, MeshError)):
        save_results(sparse, ProcessSettings(), tmp_path / "out")
    assert (tmp_path / "out/points.ply").is_file()
    assert not (tmp_path / "out/measurements.json").exists()


@pytest.mark.parametrize("change", [{"steps_per_rev": 4000}, {"direction": -1}])
def test_a_calibration_with_another_encoder_is_refused(small_scan, workshop, change):
    with pytest.raises(InputError, match="steps per turn"):
        processed(small_scan, replace(workshop, encoder=replace(workshop.encoder, **change)))


def test_a_laser_that_stayed_dark_is_named(scan_copy, workshop):
    for path in sorted((scan_copy / "frames").glob("*.png"))[48:]:
        cv2.imwrite(str(path), np.zeros((500, 582), np.uint8))

    with pytest.raises(EmptyScanError, match="no stripe of the left laser in 48 frames"):
        processed(scan_copy, workshop)


def test_no_stripe_at_all_is_refused_with_exit_status_4(scan_copy, workshop, rng):
    for path in (scan_copy / "frames").glob("*.png"):
        cv2.imwrite(str(path), rng.integers(0, 12, (500, 582), dtype=np.uint8))

    with pytest.raises(EmptyScanError, match="no stripe was found in 96 frames") as caught:
        processed(scan_copy, workshop)
    assert caught.value.exit_status == 4


def test_an_empty_board_is_no_foot(tmp_path, prototype):
    machine = ideal_machine(prototype)
    crumb = build_sphere(1.5, np.array([20.0, 0.0, 1.5]), subdivisions=2)
    scan = prepare_scan(machine, crumb, SweepPlan(frames_per_sweep=16))
    simulate_recording(tmp_path / "r", scan)

    with pytest.raises(EmptyScanError, match="points are left"):
        processed(tmp_path / "r", machine.calibration)


def test_a_calibration_of_another_machine_is_refused(small_scan, workshop):
    with pytest.raises(MachineMismatchError, match="someone else"):
        processed(small_scan, replace(workshop, machine_id="someone else"))
    unnamed = processed(small_scan, replace(workshop, machine_id=None))
    assert len(unnamed.cloud) > 10000


def test_a_calibration_of_another_picture_size_is_refused(small_scan, workshop):
    with pytest.raises(InputError, match="582 x 500"):
        processed(small_scan, replace(workshop, camera=replace(workshop.camera, width_px=640)))


def test_a_calibration_recording_is_no_scan(shared_dir):
    folder = shared_dir / "data/recordings/calibration-workshop"

    with pytest.raises(RecordingError, match="footscan calibrate"):
        processed(folder, load_calibration(folder / "truth-calibration.toml"))


@pytest.mark.parametrize("name", ["foot-left-ideal", "foot-right-workshop"])
def test_the_shared_recordings_give_the_true_foot(shared_dir, name):
    folder = shared_dir / "data/recordings" / name
    result = processed(folder, load_calibration(folder / "truth-calibration.toml"))
    height = result.cloud.xyz_world[:, 2]
    off_mm = off_truth_mm(folder, result.cloud.where((height > 3) & (height < 95)))

    assert np.sqrt(np.mean(off_mm**2)) <= 0.06
    assert (off_mm > 1.0).mean() <= 0.0004


def test_the_demo_compares_with_the_truth_and_can_be_repeated(tmp_path, prototype):
    def quiet(done, total):
        return None

    first = run_demo(prototype, 5, tmp_path / "demo", quiet, frames_per_sweep=48)
    again = run_demo(prototype, 5, tmp_path / "demo", quiet, frames_per_sweep=48)

    assert first.rms_mm == pytest.approx(again.rms_mm)
    assert first.rms_mm < 0.1
    assert (tmp_path / "demo/results/preview.png").is_file()


def test_the_demo_never_replaces_a_recording_that_is_not_its_own(scan_copy, prototype):
    scan_copy.rename(scan_copy.parent / "recording")

    with pytest.raises(FootscanError, match="nothing is overwritten"):
        run_demo(prototype, 5, scan_copy.parent, lambda done, total: None, frames_per_sweep=8)


def test_distance_to_a_surface_is_exact_on_faces_edges_and_corners(rng):
    foot = build_foot(FootShape("right", 0.5))
    corners = foot.xyz_world[foot.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    picked = rng.choice(len(corners), 500, replace=False)
    points = corners[picked].mean(axis=1) + 0.05 * normals[picked]
    off_mm = distance_to_surface_mm(points, foot.xyz_world, foot.faces)

    np.testing.assert_allclose(off_mm, 0.05, atol=0.005)
    np.testing.assert_allclose(distance_to_surface_mm(foot.xyz_world[:50], foot.xyz_world, foot.faces), 0.0, atol=1e-7)


def test_a_second_body_of_some_size_is_refused_and_specks_are_not(result, tmp_path):
    two = replace(result, removed=result.removed + Counter({"other body": len(result.cloud) // 2}))

    with pytest.raises(MeshError, match="second body stands apart"):
        save_results(two, ProcessSettings(), tmp_path)
    assert "second body" in json.loads((tmp_path / "scan.json").read_text())["foot"]["refused"]
    check_alone(replace(result, removed=Counter({"other body": len(result.cloud) // 50})))
