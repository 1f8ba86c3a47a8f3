"""The motion study: seeded scans of people who stood still or moved between the sweeps, and what was said of them.

Half of the people stand still, as well as people can (`CALM`: breathing and pulse, 0.1 mm). The others move one part by
1 to 3 mm, or the whole foot about its heel or the leg about its ankle by 1 degree, in the pause between the sweeps.
Every scan is on a workshop machine of its own and judged twice: with the true calibration, and with one that is off by
0.05 to 0.1 mm.
"""

from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from footscan.coordinates import Floats
from footscan.optics.scanner import Scanner
from footscan.scanning.motion import WHOLE_FOOT, MotionResult
from footscan.sim.motion import SweepPlan
from footscan.sim.person import Move
from footscan.sim.person_parts import PARTS, Part
from footscan.workflow.imperfect_calibration import imperfect_calibration
from footscan.workflow.motion_scans import ScanPlan, Visitor, judge_seen, see_scan

TURN_RAD = np.deg2rad(1.0)
SHIFTS_MM = (1.0, 3.0)
CALIBRATION_ERRORS_MM = (0.05, 0.1)
CALIBRATIONS = ("true", "off")
SIZES = (0.65, 1.1)
_TURNING: tuple[Part, ...] = ("foot", "ankle")
_STEEPEST: dict[Part, tuple[float, float]] = {
    "heel": (0.0, 1.0),
    "midfoot": (-0.5, 0.5),
    "ball": (0.0, 1.0),
    "toes": (0.0, 1.0),
}
"""Lowest and highest direction of a shift (rad over the board): heel and toes rise, an arch can sink, others slide."""


@dataclass(frozen=True)
class Case:
    """One scan of the study: who, on which machine, and the zone to be found (None: still)."""

    seed: int
    visitor: Visitor
    zone: str | None


@dataclass(frozen=True)
class Outcome:
    """What was said of a case with one calibration.

    Attributes:
        case: Which.
        calibration: true, or off.
        calibration_error_mm: RMS over the working volume.
        result: The judgement.
    """

    case: Case
    calibration: str
    calibration_error_mm: float
    result: MotionResult

    @property
    def said(self) -> str | None:
        """The zone of the finding."""
        return None if self.result.finding is None else self.result.finding.zone

    @property
    def right(self) -> bool:
        """Moved with the right zone, or still."""
        return self.said == self.case.zone


@dataclass(frozen=True)
class Tally:
    """Of one calibration: how many moved scans were called so with the right zone, and how many still ones were."""

    calibration: str
    moved: int
    moved_found: int
    still: int
    still_called_moved: int


def study_cases(scans: int, seed: int, meshes: tuple[Path, ...] = ()) -> list[Case]:
    """The scans of a study; the same seed gives the same. Every fifth visitor has one of the mesh files (in metres)."""
    return [_case(1000 * seed + k, k, meshes) for k in range(scans)]


def _case(seed: int, number: int, meshes: tuple[Path, ...]) -> Case:
    random = np.random.default_rng([seed, 0x5701])
    size, side = float(random.uniform(*SIZES)), ("left", "right")[int(random.integers(2))]
    visitor = Visitor(side="left" if side == "left" else "right", size=size)
    if meshes and number % 5 == 4:
        visitor = Visitor(str(meshes[(number // 5) % len(meshes)]), unit="m")
    if number % 2 == 0:
        return Case(seed, visitor, None)
    part = PARTS[(number // 2) % len(PARTS)]
    move = _move(part, random)
    return Case(seed, replace(visitor, moves=(move,)), WHOLE_FOOT if part == "foot" else part)


def _move(part: Part, random: np.random.Generator) -> Move:
    """One move of a part; when it happens is set with the plan of the scan."""
    if part in _TURNING and random.random() < 0.5:
        return Move(part, turn_rad=float(random.choice([-TURN_RAD, TURN_RAD])))
    heading, rise = float(random.uniform(0.0, 2.0 * np.pi)), float(random.uniform(*_STEEPEST.get(part, (0.0, 0.0))))
    level = np.cos(rise)
    way: Floats = float(random.uniform(*SHIFTS_MM)) * np.array(
        [level * np.cos(heading), level * np.sin(heading), np.sin(rise)]
    )
    return Move(part, (float(way[0]), float(way[1]), float(way[2])))


def run_case(scanner: Scanner, case: Case, frames_per_sweep: int) -> Iterator[Outcome]:
    """Scan once, judge with the true calibration and with an imperfect one."""
    plan = ScanPlan(SweepPlan(frames_per_sweep=frames_per_sweep))
    moves = tuple(replace(move, at_s=plan.pause_s) for move in case.visitor.moves)
    seen = see_scan(scanner, replace(case.visitor, moves=moves), plan, case.seed)
    yield Outcome(case, "true", 0.0, judge_seen(seen, seen.truth))
    error_mm = float(np.random.default_rng([case.seed, 0xE44]).uniform(*CALIBRATION_ERRORS_MM))
    yield Outcome(case, "off", error_mm, judge_seen(seen, imperfect_calibration(seen.truth, error_mm, case.seed)))


def run_study(
    scanner: Scanner,
    cases: list[Case],
    frames_per_sweep: int = 240,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> list[Outcome]:
    """All outcomes of some cases, two per case."""
    outcomes: list[Outcome] = []
    for done, case in enumerate(cases, start=1):
        outcomes.extend(run_case(scanner, case, frames_per_sweep))
        progress(done, len(cases))
    return outcomes


def outcome_report(outcome: Outcome) -> dict[str, Any]:
    """One row of the study's table."""
    visitor, finding = outcome.case.visitor, outcome.result.finding
    foot = f"{visitor.side} {visitor.size:.2f}" if visitor.thing == "foot" else Path(visitor.thing).stem
    return {
        "seed": outcome.case.seed,
        "foot": foot,
        "move": "still" if not visitor.moves else _words(visitor.moves[0]),
        "zone": outcome.case.zone,
        "calibration": outcome.calibration,
        "calibration_error_mm": outcome.calibration_error_mm,
        "said": outcome.said or "still",
        "right": outcome.right,
        "when": None if finding is None else finding.when,
        "displacement_mm": None if finding is None else finding.displacement_mm,
        "zones": {zone.zone: asdict(zone) for zone in outcome.result.zones},
    }


def _words(move: Move) -> str:
    if move.turn_rad:
        return f"{move.part} {np.degrees(move.turn_rad):+.0f} deg"
    return f"{move.part} " + " ".join(f"{way:+.1f}" for way in move.shift_mm)


def tally(outcomes: list[Outcome], calibration: str) -> Tally:
    """Count the outcomes of one calibration."""
    own = [outcome for outcome in outcomes if outcome.calibration == calibration]
    moved, still = ([o for o in own if (o.case.zone is None) == at_rest] for at_rest in (False, True))
    return Tally(
        calibration,
        len(moved),
        sum(outcome.right for outcome in moved),
        len(still),
        sum(outcome.said is not None for outcome in still),
    )
