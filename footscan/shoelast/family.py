"""The built-in family: lasts of a free parametric design, whose girths meet a size and width table.

Lengths follow the Paris point, cross sections grow with them, and two factors (ball, instep) are then solved so
that these tape girths are the table's. Between them the waist follows smoothly, and so do the heel girths.
"""

from dataclasses import replace
from typing import Any, cast

import numpy as np

from footscan.coordinates import Floats, Side
from footscan.errors import QualityError
from footscan.foot.nurbs import clamped_knots, graded_breaks, greville
from footscan.shoelast.design import Curve, Design, run_of
from footscan.shoelast.dimensions import girths_mm, with_points_and_lines
from footscan.shoelast.family_data import (
    GIRTHS,
    FamilyMember,
    check_member,
    family_data,
    nominal_girths_mm,
    nominal_stick_mm,
)
from footscan.shoelast.family_index import is_current, stored_factors
from footscan.shoelast.landmarks import MARK_SAMPLING, body_of, find_points
from footscan.shoelast.levels import LevelCurves, level_curves, level_heights
from footscan.shoelast.model import Shoelast
from footscan.shoelast.net import bottom_between, interpolate_tube
from footscan.shoelast.patches import ruled_disc, upper_edge
from footscan.shoelast.pose import settled
from footscan.shoelast.skin import Sampling
from footscan.shoelast.stub import chuck_stub

COUNT_U, COUNT_V = 128, 40
TOLERANCE_MM = 0.05
_SOLVING = Sampling(128, 48, 12)
_ROUNDS, _NEAR_MM, _ACCEPTED_MM, _LARGEST_STEP = 16, 0.5, 0.1, 0.06


def build_shoelast(
    style: str,
    size_eu: float,
    fitting: str,
    pitch_mm: float,
    toe: str = "round",
    side: Side = "right",
    *,
    stub: bool = False,
) -> Shoelast:
    """Build one last of the family, with its points and lines.

    Args:
        style: men, women or therapeutic.
        size_eu: Paris points, 35 to 48; any number between.
        fitting: One of the style's widths.
        pitch_mm: Heel height, 5 to 60.
        toe: round, almond or wide.
        side: A left one is the same last in memory (y is medial for both).
        stub: With a chuck stub behind the heel as an attachment.

    Raises:
        InputError: Something the family does not have.
        QualityError: The girths of the table were not reached.
    """
    member = FamilyMember(style, size_eu, fitting, pitch_mm, toe, side)
    check_member(member)
    shoelast = with_points_and_lines(_built(member))
    return replace(shoelast, attachments=(chuck_stub(shoelast),)) if stub else shoelast


def _built(member: FamilyMember) -> Shoelast:
    """From the factors of the shipped index, if it was made from this very design; else solved."""
    stored = stored_factors(member)
    if stored is not None and is_current():
        return shoelast_from_factors(member, np.array(stored))
    return solve_member(member, np.ones(3) if stored is None else np.array(stored))[0]


def solve_member(member: FamilyMember, start: Floats) -> tuple[Shoelast, Floats]:
    """Quasi-Newton steps (Broyden) on both factors and the length.

    They run on a coarse mesh; what a fine one measures beyond it is added once, near the end.

    Returns:
        The last without points and lines, and its `(3,)` factors: ball, instep, length over the nominal stick length.

    Raises:
        QualityError: The girths of the table were not reached.
    """
    target, beyond = _targets(member), None
    slope, unknown = _STEEPNESS * target[:, None], start
    shoelast, miss = _measured(member, unknown, target)
    for _ in range(_ROUNDS):
        if np.abs(miss).max() < _NEAR_MM and beyond is None:
            beyond = _values(shoelast, MARK_SAMPLING) - target - miss
            target, miss = target - beyond, miss + beyond
        if np.abs(miss).max() < TOLERANCE_MM:
            return shoelast, unknown
        step = np.clip(-np.linalg.solve(slope, miss), -_LARGEST_STEP, _LARGEST_STEP)
        unknown = unknown + step
        shoelast, after = _measured(member, unknown, target)
        slope += np.outer(after, step) / float(step @ step)
        miss = after
    if np.abs(miss).max() < _ACCEPTED_MM:
        return shoelast, unknown
    raise QualityError(
        f"{member.name}: its girths miss the table by {np.abs(miss).max():.2f} mm, at most {_ACCEPTED_MM} mm are "
        "allowed: report it, and choose a neighbouring size meanwhile."
    )


_STEEPNESS = np.array([[0.87, 0.1, 0.93], [0.12, 0.85, 0.9], [0.0, 0.0, 1.0]])
"""Relative change of ball girth, instep girth and length (rows) per relative change of factors (columns)."""


def _targets(member: FamilyMember) -> Floats:
    """Girths of the table, and the stick length at this pitch: it shortens as the same bottom is raised."""
    wanted = nominal_girths_mm(member.style, member.size_eu, member.fitting)
    stick = nominal_stick_mm(member)
    here, reference = (float(_forward(_lift(member, pitch), stick)) for pitch in (member.pitch_mm, _reference_mm()))
    return np.array([*(wanted[name] for name in GIRTHS), stick + here - reference])


def _reference_mm() -> float:
    return float(family_data()["reference_pitch_mm"])


def _forward(lift: Curve, length_mm: float) -> float:
    along, forward = run_of(lift, length_mm)
    return float(np.interp(length_mm, along, forward))


def shoelast_from_factors(member: FamilyMember, factors: Floats) -> Shoelast:
    """The last of `(3,)` factors, without points and lines."""
    return shoelast_from_design(member, build_design(member, factors[:2], factors[2] * nominal_stick_mm(member)))


def _measured(member: FamilyMember, unknown: Floats, target: Floats) -> tuple[Shoelast, Floats]:
    shoelast = shoelast_from_factors(member, unknown)
    return shoelast, _values(shoelast, _SOLVING) - target


def _values(shoelast: Shoelast, sampling: Sampling) -> Floats:
    body = body_of(shoelast, sampling)
    found = girths_mm(body, find_points(body))
    return np.array([*(found[name] for name in GIRTHS), body.stick_mm])


def build_design(member: FamilyMember, factors: Floats, length_mm: float) -> Design:
    """The flat design of a member of the family.

    Args:
        member: Which.
        factors: `(2,)` by how much the cross sections at ball and instep differ from plain scaling.
        length_mm: Along the bottom, toe included.
    """
    data = family_data()
    shape = data["shapes"][data["styles"][member.style]["shape"]]
    toe = data["toes"][member.toe]
    plain_mm = length_mm - toe["extra_mm"]
    scale = plain_mm / shape["length_mm"]
    across = _factor_curve(data["adjust_shares"], factors).times(scale)
    taper = _curve(toe["taper"])
    inflare = Curve(np.array([0.0, 0.6, 0.8, 1.0]), toe["inflare_mm"] * np.array([0.0, 0.0, 0.6, 1.0]))
    shares, ridge_y = np.asarray(shape["shares"], dtype=np.float64), _curve(shape["ridge_y"])
    widths = {name: Curve(shares, np.asarray(shape[name], dtype=np.float64)) for name in ("medial", "lateral")}
    edges = ("inset_medial", "inset_lateral", "rise_medial", "rise_lateral")
    return Design(
        length_mm=plain_mm,
        end_mm=length_mm,
        medial=widths["medial"].times(across).times(taper),
        lateral=widths["lateral"].times(across).times(taper),
        ridge=_curve(shape["ridge"]).times(across),
        ridge_y=Curve(ridge_y.shares, ridge_y.values * scale + inflare.at(ridge_y.shares)),
        fullness=_curve(shape["fullness"]),
        toe_length_mm=toe["length_mm"] * scale,
        toe_depth_mm=toe["depth_mm"] * scale,
        heel_length_mm=shape["heel_length_mm"] * scale,
        cone_height_mm=shape["cone_height_mm"] * scale * float(factors[1]),
        back_lean_mm=shape["back_lean_mm"] * scale,
        **cast("Any", {name: _curve(shape[name]).times(scale) for name in edges}),
        lift=_lift(member, member.pitch_mm),
        cone_tilt=shape["cone_tilt"] + data["lift"]["cone_tilt_per_mm"] * member.pitch_mm,
    )


def _curve(pair: list[list[float]]) -> Curve:
    return Curve(np.asarray(pair[0], dtype=np.float64), np.asarray(pair[1], dtype=np.float64))


def _factor_curve(places: Any, factors: Floats) -> Curve:
    ball, instep = (float(value) for value in factors)
    rear, front = (
        1.0 + places[name] * (value - 1.0) for name, value in (("heel_follows", instep), ("toe_follows", ball))
    )
    shares = np.array([0.0, 0.16, places["instep"], *places["ball"], 1.0])
    return Curve(shares, np.array([rear, rear, instep, ball, ball, front]))


def _lift(member: FamilyMember, pitch_mm: float) -> Curve:
    """Height of the bottom's middle: the toe end of the feather edge ends at the toe spring."""
    data = family_data()
    rows, toe = data["lift"], data["toes"][member.toe]
    shape = data["shapes"][data["styles"][member.style]["shape"]]
    spring = toe["spring_mm"] + rows["spring_per_pitch"] * pitch_mm - shape["rise_medial"][1][-1]
    pitch, shank, up = (np.asarray(rows[name], dtype=np.float64) for name in ("pitch", "shank", "spring"))
    shares = np.asarray(rows["shares"], dtype=np.float64)
    return Curve(shares, pitch_mm * pitch + shape["shank_mm"] * shank + spring * up)


def shoelast_from_design(member: FamilyMember, design: Design) -> Shoelast:
    """Patches through the level curves of a design, laid into the frame."""
    knots_v = clamped_knots(graded_breaks(_density(), COUNT_V - 3))
    heights = level_heights(design, greville(knots_v))
    curves = level_curves(design, np.arange(COUNT_U) / COUNT_U, heights)
    shoelast = _patched(member, curves, knots_v)
    return settled(shoelast)


def _patched(member: FamilyMember, curves: LevelCurves, knots_v: Floats) -> Shoelast:
    upper = interpolate_tube(curves.xyz_shoelast, knots_v)
    return Shoelast(
        name=member.name,
        side=member.side,
        upper=upper,
        bottom=bottom_between(upper.net_mm[0], curves.depth_mm),
        cone_top=ruled_disc(upper_edge(upper), np.linspace(0.0, 1.0, 5)),
        style=member.style,
        size_eu=member.size_eu,
        fitting=member.fitting,
    )


def _density() -> Floats:
    """More knots near the feather edge, where the walls are drawn in, and some more at the cone edge."""
    v = np.linspace(0.0, 1.0, 200)
    return 1.0 + 2.5 * np.exp(-v / 0.06) + 1.0 * np.exp(-(1.0 - v) / 0.05)
