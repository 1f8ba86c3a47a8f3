"""What frames taken before a scan say about lasers, exposure and where the foot stands; named causes, no guesses."""

from dataclasses import dataclass

import numpy as np

from footscan.coordinates import WORKING_RADIUS_MM, Floats, Frame, LaserName
from footscan.geometry.rigid import turn_z
from footscan.optics.tables import LightTable
from footscan.scanning.session.states import Finding
from footscan.scanning.stripe import automatic_threshold, find_stripe

FEWEST_STRIPE_POINTS = 40
_SATURATED_GREY = 250
_SATURATED_SHARE = 0.5
_DARK_GREY = 45
_AMBIENT_GREY = 110
_BORDER_PX = 3
_SKIN_FROM_MM = 8.0  # above the board
_FEWEST_SKIN_POINTS = 15
_OFF_CENTRE_MM = 35.0


@dataclass(frozen=True)
class TestFrames:
    """Frames taken with the head at rest at one angle: without light, and with each laser."""

    theta_rad: float
    unlit: Frame
    lit: dict[LaserName, Frame]

    __test__ = False  # no test case of pytest


def judge_light(frames: TestFrames) -> list[Finding]:
    """Whether each laser draws a stripe that can be measured, and whether the room is dark enough."""
    findings = _ambient(frames.unlit)
    for laser, frame in frames.lit.items():
        findings += _stripe(laser, frame, frames.unlit)
    return findings


def _ambient(unlit: Frame) -> list[Finding]:
    bright = float(np.percentile(unlit, 99.0))
    if bright <= _AMBIENT_GREY:
        return []
    return [
        Finding(
            "ambient light",
            f"without laser the picture is already up to {bright:.0f} of 255 bright, at most {_AMBIENT_GREY} is "
            "allowed; switch lamps off, shade the window, or shorten the exposure.",
        )
    ]


def _stripe(laser: LaserName, frame: Frame, unlit: Frame) -> list[Finding]:
    added = frame.astype(np.int16) - unlit
    brightest = float(np.percentile(added, 99.8))
    stripe = find_stripe(frame, None)
    if len(stripe) < FEWEST_STRIPE_POINTS or brightest < 0.3 * _DARK_GREY:
        return [
            Finding(
                f"no stripe of the {laser} laser",
                f"the {laser} laser was switched on but draws no stripe ({len(stripe)} points, at least "
                f"{FEWEST_STRIPE_POINTS}); check its supply and cable, and that nothing stands in front of it.",
            )
        ]
    columns, rows = np.rint(stripe.uv).astype(np.int64).T
    peak = frame[np.clip(rows, 0, frame.shape[0] - 1), np.clip(columns, 0, frame.shape[1] - 1)]
    saturated = float(np.mean(peak >= _SATURATED_GREY))
    if saturated > _SATURATED_SHARE:
        return [
            Finding(
                "exposure saturated",
                f"{100 * saturated:.0f} % of the {laser} stripe is saturated, at most {100 * _SATURATED_SHARE:.0f} % "
                "may be; shorten the exposure or lower the gain.",
            )
        ]
    if float(np.median(peak)) < _DARK_GREY:
        return [
            Finding(
                "exposure too dark",
                f"the {laser} stripe is only {np.median(peak):.0f} of 255 bright, at least {_DARK_GREY} is needed; "
                "lengthen the exposure or raise the gain.",
                blocking=False,
            )
        ]
    return []


def judge_place(frames: TestFrames, tables: dict[LaserName, LightTable]) -> list[Finding]:
    """Whether something stands on the board, within view and near the middle, as far as one head angle shows."""
    skin = [_skin_world(frame, tables[laser], frames.theta_rad) for laser, frame in frames.lit.items()]
    xyz_world = np.concatenate(skin)
    if len(xyz_world) < _FEWEST_SKIN_POINTS:
        return [
            Finding(
                "no foot",
                "the stripes show the bare footboard, no foot; put the foot on the board, toes towards the camera.",
            )
        ]
    findings: list[Finding] = []
    reach_mm = float(np.hypot(xyz_world[:, 0], xyz_world[:, 1]).max())
    if reach_mm > WORKING_RADIUS_MM - 15.0:
        findings.append(
            Finding(
                "foot partly out of view",
                f"skin was seen {reach_mm:.0f} mm from the middle of the board, measured is up to "
                f"{WORKING_RADIUS_MM:.0f} mm; move the foot towards the middle.",
            )
        )
    aside_mm = _aside(skin, frames.theta_rad)
    if abs(aside_mm) > _OFF_CENTRE_MM:
        side = "right" if aside_mm > 0 else "left"
        findings.append(
            Finding(
                "foot off centre",
                f"the foot stands about {abs(aside_mm):.0f} mm to the {side} of the middle as the camera sees it, at "
                f"most {_OFF_CENTRE_MM:.0f} mm is wanted; move it towards the axis mark.",
                blocking=False,
            )
        )
    return findings


def _skin_world(frame: Frame, table: LightTable, theta_rad: float) -> Floats:
    stripe = find_stripe(frame, automatic_threshold(frame))
    xy_light = table.lookup(stripe.uv)
    xy_light = xy_light[np.isfinite(xy_light[:, 0])]
    world_from_light = turn_z(theta_rad) @ table.world_from_light
    xyz = xy_light @ world_from_light[:3, :2].T + world_from_light[:3, 3]
    return xyz[xyz[:, 2] > _SKIN_FROM_MM]


def _aside(skin: list[Floats], theta_rad: float) -> float:
    """Middle of the skin across the camera's line of sight, each laser counting the same (mm, right positive)."""
    across = np.array([-np.sin(theta_rad), np.cos(theta_rad)])
    seen = [part[:, :2] @ across for part in skin if len(part) >= _FEWEST_SKIN_POINTS]
    return float(np.mean([np.median(part_mm) for part_mm in seen])) if seen else 0.0
