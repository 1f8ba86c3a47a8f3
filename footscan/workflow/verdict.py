"""The verdict on a scan: good, usable with a remark, or repeat; one finding, one action, in a person's words."""

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from datetime import datetime
from typing import Any, Literal

import numpy as np

from footscan.coordinates import WORKING_RADIUS_MM, Floats, Frame
from footscan.optics.calibration import Calibration
from footscan.scanning.footboard import LARGEST_OFFSET_MM, LARGEST_TILT_DEG, BoardCheck
from footscan.scanning.motion import WHOLE_FOOT, MotionFinding, MotionResult
from footscan.workflow.blocked_sectors import Sector, blocked_sectors, spoiled_measurements
from footscan.workflow.foot import MeasuredFoot

Grade = Literal["good", "usable with remark", "repeat"]
Kind = Literal["none", "calibration", "machine", "too dark", "saturated", "off centre", "blocked", "moved"]
_ORDER: tuple[Kind, ...] = ("calibration", "machine", "too dark", "saturated", "off centre", "blocked", "moved")
"""Which of two findings of one grade is said: the one that could be the cause of the other."""
_ZONE_WORDS = {
    "heel": "the heel",
    "midfoot": "the midfoot",
    "ball": "the ball of the foot",
    "toes": "the toes",
    "ankle": "the ankle and the leg",
    WHOLE_FOOT: "the whole foot",
}


@dataclass(frozen=True)
class VerdictLimits:
    """Where a remark begins and where a repetition.

    Attributes:
        moved_mm: A zone that moved this far is scanned again: 1 mm at either end of a girth or length changes it by up
            to 2 mm, which is all that ISO 20685 allows. Less, once detected (0.5 mm), is a remark.
        disagreement_mm: Distance of the two lasers' skins that is the same all the way round: a good calibration leaves
            below 0.1 mm, and a typical error of it 0.15 mm.
        oldest_days: A calibration is asked for twice a year; heads are bumped and screws settle.
        board: Multiples of the limits of the footboard check (0.3 mm, 0.1 degree) from which a scan is of no use.
        saturated_share: Of the lit pixels. Flat-topped stripes are still found well at 0.6 (simulated); beyond, light
            spreads under the skin.
        dark_grey: The brightest tenth of the lit pixels is darker: at 60 stripes lose a quarter of their points, at 30
            half of them and what is left is rough.
        off_centre_mm: Middle of the foot from the axis: from 30 mm on a long foot comes near the end of the sharp and
            calibrated volume.
        reach_mm: Skin this near to the end of the working volume (200 mm from the axis) is probably cut off.
        sector_rad: A sector without any skin is a remark from 8 degrees (a stripe or two may be missing), and with 60
            degrees a sixth of the foot is missing.
    """

    moved_mm: float = 1.0
    disagreement_mm: tuple[float, float] = (0.25, 0.6)
    oldest_days: int = 183
    board: float = 3.0
    saturated_share: tuple[float, float] = (0.3, 0.7)
    dark_grey: tuple[float, float] = (60.0, 30.0)
    off_centre_mm: float = 30.0
    reach_mm: float = WORKING_RADIUS_MM - 2.0
    sector_rad: tuple[float, float] = (float(np.deg2rad(8.0)), float(np.deg2rad(60.0)))


LIMITS = VerdictLimits()


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong, and what to do about it."""

    kind: Kind
    grade: Grade
    sentence: str
    action: str
    spoiled: tuple[str, ...] = ()


@dataclass(frozen=True)
class Verdict:
    """What a person is told.

    Attributes:
        grade: good, usable with remark, repeat.
        kind: Of the finding; none when all is well.
        finding: One sentence.
        action: One thing to do.
        spoiled: Measurements that should not be used.
        also: Kinds of further findings of lesser weight.
    """

    grade: Grade
    kind: Kind
    finding: str
    action: str
    spoiled: tuple[str, ...] = ()
    also: tuple[str, ...] = ()


@dataclass(frozen=True)
class Evidence:
    """What a verdict rests on.

    Attributes:
        calibration: In use.
        machine_id: Of the machine that made the recording.
        scanned: RFC 3339 moment of the recording.
        board: The footboard check.
        motion: The motion judgement.
        brightest: Per laser the brightest value of every pixel.
        threshold: In use.
        xyz_world: `(n, 3)` the cloud.
        step_rad: Usual angle between two stripes of one laser.
        foot: When there is one.
    """

    calibration: Calibration
    machine_id: str | None
    scanned: str
    board: BoardCheck
    motion: MotionResult
    brightest: dict[Any, Frame]
    threshold: int
    xyz_world: Floats
    step_rad: float
    foot: MeasuredFoot | None = None


def judge_scan(evidence: Evidence, limits: VerdictLimits = LIMITS) -> Verdict:
    """The verdict with its one finding: the gravest, and of equals the one that may be the cause of the others."""
    found = sorted(_findings(evidence, limits), key=lambda f: (f.grade != "repeat", _ORDER.index(f.kind)))
    if not found:
        return Verdict("good", "none", "nothing is wrong with this scan", "none: use it")
    first = found[0]
    also = tuple(dict.fromkeys(f.kind for f in found[1:] if f.kind != first.kind))
    return Verdict(first.grade, first.kind, first.sentence, first.action, first.spoiled, also)


def verdict_report(verdict: Verdict) -> dict[str, Any]:
    """For scan.json."""
    return asdict(verdict)


def motion_report(motion: MotionResult) -> dict[str, Any]:
    """For scan.json: the table of the zones, every comparison behind it, the finding, and who could not be judged."""
    return asdict(motion) | {"not_judged": list(motion.not_judged)}


def verdict_lines(verdict: Verdict, motion: MotionResult) -> list[str]:
    """What the report page and the command line say: verdict, action, and the way of each zone."""
    also = f" (also: {', '.join(verdict.also)})" if verdict.also else ""
    lines = [f"Verdict: {verdict.grade} - {verdict.finding}{also}"]
    if verdict.kind != "none":
        lines.append(f"Do: {verdict.action}")
    if verdict.spoiled:
        lines.append(f"Do not use: {', '.join(name.replace('_', ' ') for name in verdict.spoiled)}")
    zones = ", ".join(_zone_words(zone.zone, zone.displacement_mm, zone.moved) for zone in motion.zones)
    return [*lines, f"Motion: {zones}"]


def _zone_words(zone: str, size_mm: float | None, moved: bool | None) -> str:
    if moved is None or size_mm is None:
        return f"{zone} not judged"
    return f"{zone} {size_mm:.1f} mm{' MOVED' if moved else ''}"


def _findings(evidence: Evidence, limits: VerdictLimits) -> Iterator[Finding]:
    yield from judge_calibration(evidence.calibration, evidence.machine_id, evidence.scanned, limits)
    yield from _disagreement(evidence.motion, limits)
    yield from _machine(evidence.board, limits)
    yield from _light(evidence, limits)
    off = list(_off_centre(evidence.xyz_world, limits))
    yield from off
    if not off:  # beside the axis the foot has no skin all the way round
        yield from _blocked(evidence, limits)
    yield from _moved(evidence.motion, limits)


def judge_calibration(
    calibration: Calibration | None, machine_id: str | None, scanned: str, limits: VerdictLimits = LIMITS
) -> Iterator[Finding]:
    """Missing, of another machine, or old; also for use before a scan.

    Args:
        calibration: None when there is none.
        machine_id: Of the machine; None when it has no name.
        scanned: RFC 3339 moment of the scan.
        limits: Where remarks begin.
    """
    repeat: Grade = "repeat"
    do = "Recalibrate this machine, then process the recording again."
    if calibration is None:
        yield Finding("calibration", repeat, "there is no calibration of this machine", do)
        return
    own = calibration.machine_id
    if machine_id is not None and own is not None and own != machine_id:
        sentence = f"the calibration is of machine {own}, the scan of machine {machine_id}"
        yield Finding("calibration", repeat, sentence, "Process the recording again with this machine's calibration.")
    days = _days_between(calibration.created, scanned)
    if days is not None and days > limits.oldest_days:
        sentence = f"the calibration was {days} days old, at most {limits.oldest_days} are usual"
        yield Finding("calibration", "usable with remark", sentence, "Recalibrate before the next scan.")


def _days_between(earlier: str, later: str) -> int | None:
    try:
        return (datetime.fromisoformat(later) - datetime.fromisoformat(earlier)).days
    except (ValueError, TypeError):
        return None  # no date, or one without a time zone: an age that is not known is no finding


def _disagreement(motion: MotionResult, limits: VerdictLimits) -> Iterator[Finding]:
    found_mm = motion.calibration_mm
    if found_mm is not None and found_mm > limits.disagreement_mm[0]:
        grade: Grade = "repeat" if found_mm > limits.disagreement_mm[1] else "usable with remark"
        sentence = f"the two lasers disagree by {found_mm:.2f} mm all the way round: the calibration does not fit"
        yield Finding("calibration", grade, sentence, "Recalibrate, then process the recording again.")


def _machine(board: BoardCheck, limits: VerdictLimits) -> Iterator[Finding]:
    if board.offset_mm is None or board.tilt_deg is None:
        return
    times = max(abs(board.offset_mm) / LARGEST_OFFSET_MM, board.tilt_deg / LARGEST_TILT_DEG)
    if times <= 1.0:
        return
    sentence = (
        f"the footboard lies {board.offset_mm:+.1f} mm and {board.tilt_deg:.2f} degrees off its place at calibration"
    )
    grade: Grade = "repeat" if times > limits.board else "usable with remark"
    yield Finding("machine", grade, sentence, "Clean under the footboard and seat it again; if it stays, recalibrate.")


def _light(evidence: Evidence, limits: VerdictLimits) -> Iterator[Finding]:
    for name, picture in evidence.brightest.items():
        lit = picture[picture > evidence.threshold]
        if not len(lit):
            continue
        saturated, bright = float(np.mean(lit == 255)), float(np.percentile(lit, 90))
        if saturated > limits.saturated_share[0]:
            grade: Grade = "repeat" if saturated > limits.saturated_share[1] else "usable with remark"
            sentence = f"{saturated:.0%} of the {name} laser's light is saturated"
            yield Finding("saturated", grade, sentence, "Shorten the exposure or lower the gain, then scan again.")
        if bright < limits.dark_grey[0]:
            grade = "repeat" if bright < limits.dark_grey[1] else "usable with remark"
            sentence = f"the {name} laser's light is weak: grey value {bright:.0f} of 255"
            yield Finding("too dark", grade, sentence, "Clean the windows and lengthen the exposure, then scan again.")


def _off_centre(xyz_world: Floats, limits: VerdictLimits) -> Iterator[Finding]:
    xy = xyz_world[:, :2]
    off_mm = float(np.linalg.norm(0.5 * (xy.min(axis=0) + xy.max(axis=0))))
    reach_mm = float(np.hypot(xy[:, 0], xy[:, 1]).max())
    do = "Ask the person to stand with the middle of the foot on the middle of the board, then scan again."
    if reach_mm > limits.reach_mm:
        yield Finding(
            "off centre", "repeat", f"the foot stands {off_mm:.0f} mm off centre and is partly out of view", do
        )
    elif off_mm > limits.off_centre_mm:
        yield Finding("off centre", "usable with remark", f"the foot stands {off_mm:.0f} mm off centre", do)


def _blocked(evidence: Evidence, limits: VerdictLimits) -> Iterator[Finding]:
    sectors = blocked_sectors(evidence.xyz_world, evidence.step_rad, limits.sector_rad[0])
    if not sectors:
        return
    spoiled = spoiled_measurements(evidence.foot, sectors) if evidence.foot is not None else ()
    widest = max(sector.width_rad for sector in sectors)
    grade: Grade = "repeat" if widest > limits.sector_rad[1] else "usable with remark"
    where = " and ".join(_sector_words(sector) for sector in sectors[:2])
    do = "Take away what stands there (hem, cable, other leg), then scan again."
    yield Finding("blocked", grade, f"no skin was seen {where}", do, spoiled)


def _sector_words(sector: Sector) -> str:
    return f"from {np.degrees(sector.begin_rad):.0f} to {np.degrees(sector.end_rad):.0f} degrees around the axis"


def _moved(motion: MotionResult, limits: VerdictLimits) -> Iterator[Finding]:
    if motion.finding is not None:
        yield _moved_finding(motion.finding, limits)
    elif motion.not_judged:
        all_of_it = len(motion.not_judged) == len(motion.zones)
        what = "the foot" if all_of_it else " and ".join(_ZONE_WORDS[zone] for zone in motion.not_judged)
        sentence = f"whether {what} moved could not be judged: no second look at that skin"
        yield Finding("moved", "usable with remark", sentence, "Compare the measurements with a second scan.")


def _moved_finding(finding: MotionFinding, limits: VerdictLimits) -> Finding:
    what = _ZONE_WORDS[finding.zone]
    sentence = f"{what} moved {finding.displacement_mm:.1f} mm (+- {finding.sigma_mm:.1f}) {finding.when}"
    if finding.displacement_mm >= limits.moved_mm:
        return Finding(
            "moved", "repeat", sentence, f"Ask the person to hold on and keep {what} still, then scan again."
        )
    return Finding("moved", "usable with remark", sentence, "Use it where a millimetre does not matter, or scan again.")
