"""A rig file (`footscan-rig/1`): the design of a machine, how its head turns, and which devices it is made of."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, model_validator

from footscan.config.device_models import DevicesModel, V4l2CameraModel
from footscan.config.io_models import AdamModel
from footscan.config.scanner_file import ScannerModel
from footscan.config.toml_file import Strict, load_file, tuple_from_list
from footscan.optics.scanner import Scanner

TOE_RADIUS_MM = 140.0
"""Where stripe spacing is stated: the tip of a long foot that stands with its middle on the axis."""

MOST_BLOCKED_DEG = 120.0
"""From 60 degrees without skin on a scan is refused; one laser's sector is made good by the other's."""

REACTION_S = 0.1
"""A busy computer may be this late in switching the motor off."""

Degrees = Annotated[float, Field(ge=-720, le=720)]
Range = Annotated[tuple[Degrees, Degrees], BeforeValidator(tuple_from_list)]


class ProfileModel(Strict):
    """`[[motion.profile]]`: how densely a foot is scanned."""

    name: str = Field(min_length=1)
    angle_step_deg: float = Field(gt=0.05, le=15)
    unlit_every: int = Field(default=0, ge=0, le=1000)
    lasers: str = Field(default="auto", pattern="^(auto|alternating|one-after-the-other)$")
    at_requested_angles: bool = False


class MotionModel(Strict):
    """`[motion]`."""

    frames_per_s: float = Field(gt=0.5, le=1000)
    travel_deg: Range
    sweep_deg: Range
    home_deg: Degrees
    speeds_deg_per_s: Annotated[tuple[float, ...], BeforeValidator(tuple_from_list), Field(min_length=1, max_length=4)]
    acceleration_deg_per_s2: float = Field(gt=1, le=5000)
    blocked_deg: Annotated[tuple[Range, ...], BeforeValidator(tuple_from_list)] = ()
    switching_s: float = Field(default=0.004, gt=0, le=0.2)
    watchdog_s: float = Field(default=0.2, ge=0.1, le=5)
    max_on_s: float = Field(default=60.0, gt=1, le=600)
    profile: Annotated[tuple[ProfileModel, ...], BeforeValidator(tuple_from_list), Field(min_length=1)]

    def stopping_deg(self, speed_deg_per_s: float) -> float:
        """How far the head may turn on once it is to stop, a late computer included."""
        return speed_deg_per_s**2 / (2.0 * self.acceleration_deg_per_s2) + REACTION_S * speed_deg_per_s

    @model_validator(mode="before")
    @classmethod
    def _pairs(cls, table: Any) -> Any:
        blocked = table.get("blocked_deg") if isinstance(table, dict) else None
        return {**table, "blocked_deg": [tuple_from_list(pair) for pair in blocked]} if blocked else table

    @model_validator(mode="after")
    def _consistent(self) -> "MotionModel":
        for mistake in self._mistakes():
            raise ValueError(mistake)
        return self

    def _mistakes(self) -> Iterator[str]:
        low, high = self.travel_deg
        begin, end = self.sweep_deg
        if not low < begin < end < high:
            yield (
                f"sweep_deg {list(self.sweep_deg)} must lie inside travel_deg {list(self.travel_deg)}, "
                "both from low to high"
            )
        if end - begin < 360.0:
            yield f"sweep_deg spans {end - begin:g} degrees, at least 360 see the whole foot"
        if not low <= self.home_deg < begin:
            yield f"home_deg {self.home_deg:g} must lie between the lower travel limit {low:g} and the sweep {begin:g}"
        if sorted(set(self.speeds_deg_per_s)) != list(self.speeds_deg_per_s) or self.speeds_deg_per_s[0] <= 0:
            yield f"speeds_deg_per_s {list(self.speeds_deg_per_s)} must be positive and rise"
        slowest, stopping = self.speeds_deg_per_s[0], self.stopping_deg(self.speeds_deg_per_s[-1])
        if self.stopping_deg(slowest) > self.home_deg - low:
            yield (
                f"at {slowest:g} degrees/s, the slowest, the head stops in {self.stopping_deg(slowest):.1f} degrees, "
                f"but only {self.home_deg - low:.1f} lie between travel_deg and home_deg"
            )
        if slowest > 0 and (end - begin) / slowest > self.max_on_s:
            yield (
                f"a sweep of {end - begin:g} degrees at {slowest:g} degrees/s takes {(end - begin) / slowest:.0f} s, "
                f"longer than max_on_s {self.max_on_s:g} allows"
            )
        if stopping > min(begin - low, high - end):
            yield (
                f"at {self.speeds_deg_per_s[-1]:g} degrees/s the head stops within {stopping:.1f} degrees, "
                f"but only {min(begin - low, high - end):.1f} lie between sweep_deg and travel_deg"
            )
        if any(not first < second for first, second in self.blocked_deg):
            yield f"each of blocked_deg goes from low to high, found {[list(pair) for pair in self.blocked_deg]}"
        dark = sum(min(second - first, 360.0) for first, second in self.blocked_deg)
        if dark > MOST_BLOCKED_DEG:
            yield f"blocked_deg covers {dark:g} degrees, at most {MOST_BLOCKED_DEG:g} leave a foot to be seen"
        park = 0.5 * (self.home_deg + begin)
        if any((park - first) % 360.0 <= second - first for first, second in self.blocked_deg):
            yield f"the head parks at {park:g} degrees, inside blocked_deg; the lasers are tried there before each scan"
        names = [profile.name for profile in self.profile]
        if len(set(names)) < len(names):
            yield f"profile names must differ, found {names}"


class RigModel(ScannerModel):
    """The whole file."""

    motion: MotionModel
    devices: DevicesModel

    @model_validator(mode="after")
    def _fitting(self) -> "RigModel":
        for mistake in self._misfits():
            raise ValueError(mistake)
        return self

    def _misfits(self) -> Iterator[str]:
        camera, io, motion = self.devices.camera, self.devices.io, self.motion
        if camera.exposure_s * motion.frames_per_s > 1.0:
            yield f"an exposure of {camera.exposure_s:g} s is longer than a frame at {motion.frames_per_s:g} frames/s"
        if isinstance(camera, V4l2CameraModel) and motion.frames_per_s != round(motion.frames_per_s):
            yield f"frames_per_s {motion.frames_per_s:g} must be a whole number for a V4L2 camera"
        speeds = len(motion.speeds_deg_per_s)
        if isinstance(io, AdamModel) and speeds > 1 << len(io.outputs.speed):
            yield (
                f"{speeds} speeds_deg_per_s need {(speeds - 1).bit_length()} speed outputs, "
                f"{len(io.outputs.speed)} are wired"
            )


@dataclass(frozen=True)
class Rig:
    """A rig as its file describes it.

    Attributes:
        path: The file.
        scanner: The machine's design.
        motion: How its head turns.
        devices: What it is made of.
    """

    path: Path
    scanner: Scanner
    motion: MotionModel
    devices: DevicesModel

    def profile(self, name: str | None) -> ProfileModel:
        """A profile by name; the first of the file's if no name is given.

        Raises:
            ValueError: No such profile.
        """
        for profile in self.motion.profile:
            if name is None or profile.name == name:
                return profile
        raise ValueError(f"profile {name!r} is none of {', '.join(p.name for p in self.motion.profile)}")


def load_rig(path: Path | str) -> Rig:
    """Read and validate a rig file.

    Raises:
        ConfigError: Missing file or key, unknown key, wrong type or range, limits that contradict each other.
    """
    model = load_file(Path(path), "rig", RigModel)
    return Rig(Path(path), model.scanner(), model.motion, model.devices)
