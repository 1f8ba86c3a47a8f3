from dataclasses import replace

import numpy as np
import pytest

from footscan.scanning.footboard import BoardCheck
from footscan.scanning.motion import WHOLE_FOOT, MotionFinding, MotionResult, ZoneMotion
from footscan.scanning.recording import open_recording
from footscan.scanning.zones import ZONES
from footscan.workflow.blocked_sectors import Sector, blocked_sectors, spoiled_measurements
from footscan.workflow.foot import measure_scan
from footscan.workflow.process import ProcessSettings, process_recording, scan_report, scan_verdict
from footscan.workflow.results import save_results
from footscan.workflow.verdict import Evidence, judge_calibration, judge_scan, verdict_lines

STILL = ZoneMotion("", "other laser", "between sweeps 1 and 2", 500, 0.08, 0.15, 0.5, False)
MOVED = replace(STILL, displacement_mm=1.6, moved=True)
UNKNOWN = ZoneMotion("", "none", "", 0, None, None, None, None)
ON_PLACE = BoardCheck(5000, 0.05, 0.01, 0.05, None, "")
SCANNED = "2026-05-01T10:00:00+00:00"


def motion(finding=None, calibration_mm=0.05, **zones):
    return MotionResult(
        tuple(replace(zones.get(zone, STILL), zone=zone) for zone in ZONES), (), finding, calibration_mm
    )


def toes_moved(way_mm):
    finding = MotionFinding("toes", way_mm, 0.2, "between sweeps 1 and 2")
    return motion(finding, toes=replace(MOVED, displacement_mm=way_mm))


@pytest.fixture
def evidence(ideal, rng):
    angle = np.linspace(-np.pi, np.pi, 5000)
    foot = np.column_stack([120.0 * np.cos(angle), 45.0 * np.sin(angle), rng.uniform(5.0, 90.0, 5000)])
    picture = np.where(rng.random((100, 100)) < 0.2, 150, 10).astype(np.uint8)
    calibration = replace(ideal, machine_id="m1", created="2026-04-01T10:00:00+00:00")
    pictures = {"right": picture, "left": picture.copy()}
    return Evidence(calibration, "m1", SCANNED, ON_PLACE, motion(), pictures, 24, foot, 0.026)


def test_a_scan_without_faults_is_good(evidence):
    verdict = judge_scan(evidence)

    assert (verdict.grade, verdict.kind, verdict.spoiled, verdict.also) == ("good", "none", (), ())


@pytest.mark.parametrize(("way_mm", "grade"), [(0.7, "usable with remark"), (1.6, "repeat")])
def test_a_part_that_moved_is_named_with_how_far_and_when(evidence, way_mm, grade):
    verdict = judge_scan(replace(evidence, motion=toes_moved(way_mm)))

    assert (verdict.grade, verdict.kind) == (grade, "moved")
    assert verdict.finding == f"the toes moved {way_mm:.1f} mm (+- 0.2) between sweeps 1 and 2"


def test_a_foot_that_moved_as_a_whole_is_said_so(evidence):
    finding = MotionFinding(WHOLE_FOOT, 2.0, 0.2, "during sweep 2")
    verdict = judge_scan(replace(evidence, motion=motion(finding, **dict.fromkeys(ZONES, MOVED))))

    assert verdict.finding.startswith("the whole foot moved 2.0 mm")
    assert "keep the whole foot still" in verdict.action


def test_what_could_not_be_judged_is_never_called_still(evidence):
    one = judge_scan(replace(evidence, motion=motion(toes=UNKNOWN)))
    none = judge_scan(replace(evidence, motion=motion(**dict.fromkeys(ZONES, UNKNOWN))))

    assert one.grade == none.grade == "usable with remark"
    assert "whether the toes moved could not be judged" in one.finding
    assert "whether the foot moved could not be judged" in none.finding
    assert "toes not judged" in verdict_lines(one, motion(toes=UNKNOWN))[-1]


@pytest.mark.parametrize(("offset_mm", "grade"), [(0.2, "good"), (-0.6, "usable with remark"), (1.5, "repeat")])
def test_a_board_off_its_place_is_the_machine(evidence, offset_mm, grade):
    verdict = judge_scan(replace(evidence, board=replace(ON_PLACE, offset_mm=offset_mm)))

    assert verdict.grade == grade
    assert verdict.kind == ("none" if grade == "good" else "machine")


def test_lasers_that_disagree_all_the_way_round_are_the_calibration(evidence):
    verdict = judge_scan(replace(evidence, motion=motion(calibration_mm=0.4)))

    assert (verdict.grade, verdict.kind) == ("usable with remark", "calibration")


def test_calibration_missing_old_or_of_another_machine(ideal):
    known = replace(ideal, machine_id="m1", created="2025-01-01T00:00:00+00:00")
    missing, other = (list(judge_calibration(c, m, SCANNED)) for c, m in ((None, "m1"), (known, "m2")))
    old = list(judge_calibration(known, "m1", SCANNED))
    undated = list(judge_calibration(replace(known, created=""), "m1", SCANNED))

    assert [f.grade for f in missing] == ["repeat"]
    assert "machine m1, the scan of machine m2" in other[0].sentence
    assert [(f.grade, "485 days old" in f.sentence) for f in old] == [("usable with remark", True)]
    assert undated == []


@pytest.mark.parametrize(
    ("grey", "kind", "grade"),
    [(255, "saturated", "repeat"), (50, "too dark", "usable with remark"), (28, "too dark", "repeat")],
)
def test_light_that_is_too_strong_or_too_weak(evidence, grey, kind, grade):
    picture = np.where(evidence.brightest["left"] > 100, grey, 10).astype(np.uint8)
    verdict = judge_scan(replace(evidence, brightest={**evidence.brightest, "left": picture}))

    assert (verdict.kind, verdict.grade) == (kind, grade)
    assert "the left laser's light" in verdict.finding


def test_a_foot_beside_the_middle_and_one_out_of_view(evidence):
    aside = judge_scan(replace(evidence, xyz_world=evidence.xyz_world + np.array([35.0, 0.0, 0.0])))
    out = judge_scan(replace(evidence, xyz_world=evidence.xyz_world + np.array([79.0, 0.0, 0.0])))

    assert (aside.grade, aside.kind) == ("usable with remark", "off centre")
    assert (out.grade, out.kind) == ("repeat", "off centre")
    assert "partly out of view" in out.finding


def test_the_graver_finding_is_said_and_the_lesser_one_is_not_lost(evidence):
    verdict = judge_scan(
        replace(evidence, motion=toes_moved(2.0), board=replace(ON_PLACE, offset_mm=0.5), machine_id="m2")
    )

    assert (verdict.kind, verdict.also) == ("calibration", ("moved", "machine"))


def test_gaps_between_stripes_are_no_blocked_sector(evidence):
    azimuth = np.arctan2(evidence.xyz_world[:, 1], evidence.xyz_world[:, 0])
    blocked = evidence.xyz_world[(azimuth < 1.0) | (azimuth > 1.4)]

    assert blocked_sectors(evidence.xyz_world, 0.026, 0.14) == []
    assert blocked_sectors(blocked, 0.2, 0.14) == []
    (sector,) = blocked_sectors(blocked, 0.026, 0.14)
    assert (sector.begin_rad, sector.end_rad) == (pytest.approx(1.0, abs=0.01), pytest.approx(1.4, abs=0.01))


def test_a_sector_may_pass_the_half_turn():
    sector = Sector(3.0, 3.5)
    places = np.array([[-1.0, 0.0, 0.0], [-1.0, -0.3, 0.0], [1.0, 0.0, 0.0], [-1.0, 0.2, 0.0]])

    assert sector.holds(places).tolist() == [True, True, False, False]


@pytest.fixture(scope="module")
def scanned(small_scan, workshop):
    return process_recording(open_recording(small_scan), workshop, ProcessSettings())


def test_a_blocked_sector_names_the_measurements_it_spoils(scanned):
    azimuth = np.arctan2(scanned.cloud.xyz_world[:, 1], scanned.cloud.xyz_world[:, 0])
    foot = measure_scan(scanned.cloud, "left", scanned.recording.info.subject)
    heel, toes = (spoiled_measurements(foot, [Sector(a - 0.3, a + 0.3)]) for a in (np.pi, 0.0))
    hidden = replace(scanned, cloud=scanned.cloud.where(np.abs(azimuth - np.radians(85.0)) > np.radians(15.0)))
    verdict = scan_verdict(hidden, foot)

    assert {"foot_length", "ball_length", "heel_breadth"} <= set(heel)
    assert {"foot_length", "toe_height"} <= set(toes)
    assert "ball_length" not in toes
    assert "heel_breadth" not in toes
    assert (verdict.grade, verdict.kind) == ("usable with remark", "blocked")
    assert "instep_girth" in verdict.spoiled
    assert "foot_length" not in verdict.spoiled


def test_the_report_holds_the_motion_of_every_zone_and_the_verdict(scanned):
    report = scan_report(scanned, ProcessSettings())

    assert [zone["zone"] for zone in report["motion"]["zones"]] == list(ZONES)
    assert report["motion"]["finding"] is None
    assert set(report["verdict"]) == {"grade", "kind", "finding", "action", "spoiled", "also"}
    assert report["verdict"]["kind"] in ("none", "moved")


def test_results_keep_the_verdict(scanned, tmp_path):
    report = save_results(scanned, ProcessSettings(), tmp_path)

    assert report["verdict"]["grade"] in ("good", "usable with remark")
