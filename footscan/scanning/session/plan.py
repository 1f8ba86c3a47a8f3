"""What a scan will be before anybody presses Start: sweeps, lasers, speed, duration and stripe spacing."""

from dataclasses import dataclass

import numpy as np

from footscan.config.rig_file import TOE_RADIUS_MM, MotionModel, ProfileModel
from footscan.coordinates import LaserName
from footscan.devices.values import CameraFacts
from footscan.optics.scanner import Scanner

_STEP_TOLERANCE = 1.01
_SWITCHING_SHARE = 0.5  # of the frame's period may pass with exposure and switching of the lasers
_MUCH_QUICKER = 0.75
REST_S = 0.6


@dataclass(frozen=True)
class SweepLeg:
    """One turn of the head; with two lasers these shine in turn, one per frame."""

    ccw: bool
    lasers: tuple[LaserName, ...]


@dataclass(frozen=True)
class ScanPlan:
    """A scan as it will be.

    Attributes:
        profile: Its name.
        legs: The turns, in order.
        speed_step: Of the drive.
        speed_rad_s: At that step.
        frames_per_s: Of the camera.
        angle_step_rad: Between pictures of the same laser.
        asked_step_rad: As asked for by the profile.
        sweep_rad: From where to where pictures are taken.
        blocked_rad: Where beams stay off.
        unlit_every: Each n-th frame is taken without laser; 0 for none.
        at_requested_angles: Only the frames nearest to multiples of `asked_step_rad` are kept.
    """

    profile: str
    legs: tuple[SweepLeg, ...]
    speed_step: int
    speed_rad_s: float
    frames_per_s: float
    angle_step_rad: float
    asked_step_rad: float
    sweep_rad: tuple[float, float]
    blocked_rad: tuple[tuple[float, float], ...]
    unlit_every: int
    at_requested_angles: bool

    @property
    def duration_s(self) -> float:
        """How long the person stands still."""
        return len(self.legs) * (np.ptp(self.sweep_rad) / self.speed_rad_s + REST_S)

    @property
    def spacing_mm(self) -> float:
        """Between stripes of one laser at the toe (140 mm from the axis)."""
        return TOE_RADIUS_MM * self.angle_step_rad

    @property
    def frame_count(self) -> int:
        """Pictures of the whole scan, about."""
        return round(self.duration_s * self.frames_per_s)

    @property
    def alternating(self) -> bool:
        """The lasers shine in turn."""
        return any(len(leg.lasers) > 1 for leg in self.legs)

    def sentence(self) -> str:
        """What the operator reads before Start."""
        way = "one turn, lasers in turn" if self.alternating else f"{len(self.legs)} turns, one laser each"
        slow = self.angle_step_rad > _STEP_TOLERANCE * self.asked_step_rad
        short = f" (wanted {TOE_RADIUS_MM * self.asked_step_rad:.1f} mm; the camera is too slow)" if slow else ""
        return (
            f"{self.profile}: {self.duration_s:.0f} s, {way}, about {self.frame_count} pictures, "
            f"stripes every {self.spacing_mm:.1f} mm at the toe{short}"
        )


def plan_scan(motion: MotionModel, profile: ProfileModel, facts: CameraFacts, scanner: Scanner) -> ScanPlan:
    """Choose speed and way of the lasers: the quickest that keeps the profile's stripe spacing."""
    one_by_one = _planned(motion, profile, facts, _sequential(scanner), frames_per_picture=1)
    together = _planned(motion, profile, facts, (SweepLeg(True, ("right", "left")),), frames_per_picture=2)
    if profile.lasers == "alternating":
        return together
    if profile.lasers == "one-after-the-other" or not fast_enough_to_alternate(motion, facts):
        return one_by_one
    dense = together.angle_step_rad <= max(_STEP_TOLERANCE * together.asked_step_rad, one_by_one.angle_step_rad)
    return together if dense and together.duration_s < _MUCH_QUICKER * one_by_one.duration_s else one_by_one


def fast_enough_to_alternate(motion: MotionModel, facts: CameraFacts) -> bool:
    """Whether the lasers can be switched between two exposures with time to spare."""
    return (facts.exposure_s + motion.switching_s) * facts.frames_per_s <= _SWITCHING_SHARE


def _sequential(scanner: Scanner) -> tuple[SweepLeg, ...]:
    lasers = sorted(scanner.lasers, key=lambda laser: laser.sweep == "cw")
    return tuple(SweepLeg(laser.sweep == "ccw", (laser.name,)) for laser in lasers)


def _planned(
    motion: MotionModel,
    profile: ProfileModel,
    facts: CameraFacts,
    legs: tuple[SweepLeg, ...],
    frames_per_picture: int,
) -> ScanPlan:
    speeds = np.deg2rad(motion.speeds_deg_per_s)
    lit = 1.0 - 1.0 / profile.unlit_every if profile.unlit_every > 1 else 1.0
    step_rad = speeds * frames_per_picture / (facts.frames_per_s * lit)
    asked = float(np.deg2rad(profile.angle_step_deg))
    fits = np.flatnonzero(step_rad <= _STEP_TOLERANCE * asked)
    chosen = int(fits[-1]) if len(fits) else 0
    low, high = (float(angle) for angle in np.deg2rad(motion.sweep_deg))
    return ScanPlan(
        profile.name,
        legs,
        chosen,
        float(speeds[chosen]),
        facts.frames_per_s,
        float(step_rad[chosen]),
        asked,
        (low, high),
        tuple((float(np.deg2rad(first)), float(np.deg2rad(last))) for first, last in motion.blocked_deg),
        profile.unlit_every,
        profile.at_requested_angles,
    )
