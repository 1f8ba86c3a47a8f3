"""`footscan process`: a recording in, a cloud (and with it a foot) out. Nothing here draws on a screen."""

import sys
import time
from collections import Counter
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, replace
from typing import Any, Literal

import numpy as np

import footscan
from footscan.config.recording_file import Load, Subject
from footscan.config.recording_file import Surface as CoverKind
from footscan.coordinates import LASER_NAMES, Floats, LaserName, Side
from footscan.errors import EmptyScanError, InputError, MachineMismatchError, RecordingError
from footscan.foot.standing import absent_parts, front_of
from footscan.foot.wedge import set_flat, set_on_wedge
from footscan.optics.calibration import Calibration, fingerprint
from footscan.optics.tables import build_tables
from footscan.scanning.agreement import ZoneAgreement, agreement_by_zone, find_overlap, merge_lasers
from footscan.scanning.cleaning import foot_body, smooth_skin
from footscan.scanning.cloud import Cloud, cloud_from_matrix
from footscan.scanning.footboard import BoardCheck, bare_board, check_board
from footscan.scanning.motion import MotionResult, frame_table, judge_motion
from footscan.scanning.recording import Recording
from footscan.scanning.sweep import Progress, SweepResult, SweepSettings, sweep_frames
from footscan.scanning.verify import against_manifest
from footscan.workflow.blocked_sectors import usual_step_rad
from footscan.workflow.foot import FootSettings, MeasuredFoot
from footscan.workflow.on_wedge import WedgeFinding, find_ground, wedge_report
from footscan.workflow.verdict import Evidence, Verdict, judge_scan, motion_report, verdict_report

ObjectKind = Literal["foot", "last"]
FEWEST_POINTS = 2000
_LEAST_OF_OTHER = 0.05  # a laser with fewer points than this share of the other's saw nothing of use
_MOST_REJECTED = 0.05


@dataclass(frozen=True)
class ProcessSettings:
    """What may be chosen: how frames become points, what the object is, and what the operator says of it.

    None takes the recording's word. Landmarks by hand are in mm in the coordinates of the recording.
    """

    sweep: SweepSettings = field(default_factory=SweepSettings)
    kind: ObjectKind = "foot"
    side: Side | None = None
    one_laser: bool = False
    load: Load | None = None
    surface: CoverKind | None = None
    foot: FootSettings = field(default_factory=FootSettings)
    absent: tuple[str, ...] | None = None
    wedge_mm: float | None = None
    landmarks: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)


@dataclass(frozen=True)
class ScanResult:
    """A processed scan: the cleaned, merged cloud and everything scan.json reports.

    `xy_board` `(n, 2)` are the places where the bare footboard was seen, world. Under a foot on a wedge (`ground`) they
    are places of board and wedge with the rearfoot turned back.
    """

    recording: Recording
    calibration: Calibration
    sweep: SweepResult
    cloud: Cloud
    xy_board: Floats
    removed: Counter[str]
    agreement: list[ZoneAgreement]
    board: BoardCheck
    motion: MotionResult
    remarks: list[str]
    seconds: dict[str, float]
    ground: WedgeFinding = field(default_factory=WedgeFinding)


class Stages:
    """Seconds per stage."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    @contextmanager
    def stage(self, name: str) -> Generator[None]:
        """Time what happens inside."""
        begin = time.perf_counter()
        yield
        self.seconds[name] = round(time.perf_counter() - begin, 4)


def check_machine(recording: Recording, calibration: Calibration) -> None:
    """Refuse a calibration that cannot be of the machine that made the recording.

    Raises:
        MachineMismatchError: Both name a machine and the names differ.
        InputError: The picture sizes differ.
    """
    machine, calibrated = recording.scanner.machine_id, calibration.machine_id
    if machine is not None and calibrated is not None and machine != calibrated:
        raise MachineMismatchError(
            f"the recording comes from machine {machine!r}, the calibration is of machine {calibrated!r}; "
            "use the calibration of the machine that made the recording."
        )
    own, other = recording.scanner.camera, calibration.camera
    if (own.width_px, own.height_px) != (other.width_px, other.height_px):
        raise InputError(
            f"the recording's pictures are {own.width_px} x {own.height_px}, the calibration is for "
            f"{other.width_px} x {other.height_px}; use the calibration of this camera setting."
        )
    _check_encoder(recording, calibration)


def _check_encoder(recording: Recording, calibration: Calibration) -> None:
    own, other = recording.scanner.encoder, calibration.encoder
    if (own.steps_per_rev, own.direction) != (other.steps_per_rev, other.direction):
        raise InputError(
            f"the recording's encoder has {own.steps_per_rev} steps per turn and direction {own.direction}, the "
            f"calibration says {other.steps_per_rev} and {other.direction}; use the calibration of this machine."
        )


def process_recording(
    recording: Recording,
    calibration: Calibration,
    settings: ProcessSettings,
    progress: Progress = lambda done, total: None,
) -> ScanResult:
    """Turn a scan recording into a cleaned cloud.

    Raises:
        InputError: The recording or the calibration does not fit (exit status 2).
        EmptyScanError: No stripe, or too little of one (exit status 4).
    """
    if recording.info.kind != "scan":
        raise RecordingError(
            f"{recording.folder} is a {recording.info.kind} recording; process needs a scan, "
            "a calibration recording goes to footscan calibrate."
        )
    check_machine(recording, calibration)
    stages = Stages()
    with stages.stage("tables"):
        tables = build_tables(calibration)
    with stages.stage("frames"):
        sweep = sweep_frames(recording, calibration, tables, settings.sweep, progress)
    remarks = _both_lasers(recording, sweep, settings.one_laser) + _doubts(recording, sweep)
    with stages.stage("world"):
        whole = cloud_from_matrix(sweep.matrix, tables)
    with stages.stage("board"):
        board = check_board(whole, calibration.floor)
    with stages.stage("wedge"):
        ground = _ground(recording, whole, calibration, settings)
        remarks += ground.remarks
        whole = whole.at(set_flat(whole.xyz_world, ground.wedge))
    with stages.stage("clean"):
        visible = () if board.plane is None else (board.plane,)
        body, removed = foot_body(whole, calibration.floor, *visible)
        cloud, off = smooth_skin(body)
    if len(cloud) < FEWEST_POINTS:
        raise EmptyScanError(
            f"{len(cloud)} points are left of {len(whole)} stripe points, at least {FEWEST_POINTS} make an object; "
            "check that something stands on the board, the threshold and the exposure, and scan again."
        )
    with stages.stage("motion"):
        motion = judge_motion(body, frame_table(recording.frames, sweep.matrix))
    with stages.stage("agreement"):
        agreement = agreement_by_zone(cloud, find_overlap(cloud))
        cloud = merge_lasers(cloud)
        cloud = cloud.at(set_on_wedge(cloud.xyz_world, ground.wedge))
    remarks += [board.remark] if board.remark else []
    bare = bare_board(whole, board.plane or calibration.floor)
    parts = (cloud, bare, removed + off, agreement, board, motion, remarks, stages.seconds)
    return ScanResult(recording, calibration, sweep, *parts, ground)


def _ground(recording: Recording, whole: Cloud, calibration: Calibration, settings: ProcessSettings) -> WedgeFinding:
    """What the foot stood on; a last stands on the board."""
    if settings.kind == "last":
        return WedgeFinding()
    subject = _known(recording.info.subject, settings)
    side: Side | None = settings.side or (None if recording.info.side == "none" else recording.info.side)
    front = front_of(absent_parts(subject.absent))
    return find_ground(whole.xyz_world, calibration.floor, subject.wedge_mm, side, front)


def _both_lasers(recording: Recording, sweep: SweepResult, one_laser: bool) -> list[str]:
    """Refuse a scan in which a laser is missing, unless that was allowed; then it is a remark.

    Raises:
        EmptyScanError: No stripe of either laser, or of one and that was not allowed.
        RecordingError: Only one laser has frames and that was not allowed.
    """
    points = points_per_laser(sweep)
    frames = Counter(record.laser for record in recording.frames)
    if sweep.accounting.used == 0:
        raise RecordingError(
            f"none of {sweep.accounting.seen} frames can be used{_why(sweep)}; copy or record it again."
        )
    if sum(points.values()) == 0:
        raise EmptyScanError(
            f"no stripe was found in {sweep.accounting.used} frames at threshold {sweep.threshold} "
            f"({sum(sweep.accounting.rejected.values())} frames rejected{_why(sweep)}); "
            "check lasers, exposure and threshold."
        )
    remarks: list[str] = []
    for name in LASER_NAMES:
        if points[name] > _LEAST_OF_OTHER * max(points.values()):
            continue
        few = f"only {points[name]} stripe points" if points[name] else "no stripe"
        what = f"{few} of the {name} laser in {frames[name]} frames{_why(sweep)}"
        if not frames[name]:
            what = f"no frame of the {name} laser"
        if not one_laser:
            kind = EmptyScanError if frames[name] else RecordingError
            raise kind(f"{what}: half of the foot was not seen. Scan again, or allow one laser with --one-laser.")
        remarks.append(f"{what}; the result rests on one laser")
    return remarks


def _doubts(recording: Recording, sweep: SweepResult) -> list[str]:
    """What a person should know about the frames themselves."""
    lost = sweep.accounting.rejected.total() - sweep.accounting.rejected["unlit"]
    doubts = (
        [f"{lost} of {sweep.accounting.seen} frames were rejected{_why(sweep)}"]
        if (lost > _MOST_REJECTED * sweep.accounting.seen)
        else []
    )
    changed = against_manifest(recording)
    if changed:
        more = f" and {len(changed) - 3} more" if len(changed) > 3 else ""
        doubts.append(f"the recording is not as it was finished: {'; '.join(changed[:3])}{more}")
    return doubts


def _why(sweep: SweepResult) -> str:
    reasons = ", ".join(f"{count} x {reason}" for reason, count in sweep.accounting.rejected.most_common(3))
    return f": {reasons}" if reasons else ""


def points_per_laser(sweep: SweepResult) -> dict[LaserName, int]:
    """Stripe points inside the working volume, per laser."""
    matrix = sweep.matrix
    return {name: int(matrix.points_per_frame[matrix.laser == code].sum()) for code, name in enumerate(LASER_NAMES)}


def scan_verdict(result: ScanResult, foot: MeasuredFoot | None = None) -> Verdict:
    """The verdict on a processed scan; with the foot it can name the measurements that a blocked sector spoils."""
    evidence = Evidence(
        calibration=result.calibration,
        machine_id=result.recording.scanner.machine_id,
        scanned=result.recording.info.created,
        board=result.board,
        motion=result.motion,
        brightest=dict(result.sweep.brightest),
        threshold=result.sweep.threshold,
        xyz_world=result.cloud.xyz_world,
        step_rad=usual_step_rad(result.sweep.matrix),
        foot=foot,
    )
    return judge_scan(evidence)


def known_subject(result: ScanResult, settings: ProcessSettings) -> Subject:
    """What is known of the person: the recording's word, overruled by what was given with the command."""
    return _known(result.recording.info.subject, settings)


def _known(stored: Subject, settings: ProcessSettings) -> Subject:
    return replace(
        stored,
        load=settings.load or stored.load,
        surface=settings.surface or stored.surface,
        absent=stored.absent if settings.absent is None else settings.absent,
        wedge_mm=stored.wedge_mm if settings.wedge_mm is None else settings.wedge_mm,
    )


def scan_report(result: ScanResult, settings: ProcessSettings) -> dict[str, Any]:
    """The content of scan.json (`footscan-scan/1`)."""
    accounting, board = result.sweep.accounting, result.board
    report: dict[str, Any] = {
        "format": "footscan-scan/1",
        "recording": str(result.recording.folder),
        "side": settings.side or result.recording.info.side,
        "subject": asdict(known_subject(result, settings)),
        "object": settings.kind,
        "wedge": wedge_report(result.ground.wedge),
        "frames": {"seen": accounting.seen, "used": accounting.used, "rejected": dict(accounting.rejected)},
        "rejected_frames": accounting.details,
        "points": {
            **points_per_laser(result.sweep),
            "outside_working_volume": accounting.points_outside_volume,
            "removed": dict(result.removed),
            "kept": len(result.cloud),
            "kept_right": int((result.cloud.laser == 0).sum()),
            "kept_left": int((result.cloud.laser == 1).sum()),
        },
        "threshold": result.sweep.threshold,
        "threshold_source": "automatic" if settings.sweep.threshold is None else "given",
        "filter": asdict(settings.sweep.picture_filter),
        "stripe": asdict(settings.sweep.stripe),
        "one_laser": settings.one_laser,
        "foot_settings": asdict(settings.foot),
        "agreement": [asdict(zone) for zone in result.agreement],
        "floor_check": asdict(board),
        "motion": motion_report(result.motion),
        "verdict": verdict_report(scan_verdict(result)),
        "remarks": result.remarks,
        "seconds": result.seconds,
        "calibration": {
            "sha256": fingerprint(result.calibration),
            "created": result.calibration.created,
            "machine_id": result.calibration.machine_id,
        },
        "versions": {"footscan": footscan.__version__, "python": sys.version.split()[0], "numpy": np.__version__},
    }
    return report
