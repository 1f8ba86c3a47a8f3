"""The tables that scanner.toml and calibration.toml share, as pydantic models with their dataclasses."""

import math
from typing import Annotated, Literal

from pydantic import BeforeValidator, Field

from footscan.config.toml_file import Strict, Table, tuple_from_list
from footscan.optics.calibration import EncoderScale
from footscan.optics.camera import Camera

PixelPlace = Annotated[float, Field(gt=-20000, lt=40000)]
Length = Annotated[float, Field(gt=-5000, lt=5000)]


PixelPair = Annotated[tuple[PixelPlace, PixelPlace], BeforeValidator(tuple_from_list)]
Triple = Annotated[tuple[float, float, float], BeforeValidator(tuple_from_list)]
LengthTriple = Annotated[tuple[Length, Length, Length], BeforeValidator(tuple_from_list)]


class CameraModel(Strict):
    """`[camera]`."""

    width_px: int = Field(ge=16, le=20000)
    height_px: int = Field(ge=16, le=20000)
    pixel_pitch_y_mm: float = Field(gt=1e-4, lt=0.1)
    pixel_pitch_z_mm: float = Field(gt=1e-4, lt=0.1)
    focal_length_mm: float = Field(gt=0.5, lt=500)
    horizontal_scale: float = Field(gt=0.5, lt=2)
    principal_point_px: PixelPair
    k1_per_mm2: float = Field(gt=-1, lt=1)
    k2_per_mm4: float = Field(gt=-1, lt=1)
    image_rotation_deg: Literal[0, 180] = 0

    def camera(self) -> Camera:
        """The dataclass of `optics`."""
        return Camera(**self.model_dump())


class ScannerEncoderModel(Strict):
    """`[encoder]` of a scanner."""

    steps_per_rev: int = Field(ge=8, le=10_000_000)
    zero_count: int = Field(ge=-1_000_000_000, le=1_000_000_000)
    direction: Literal[1, -1]

    def scale(self) -> EncoderScale:
        """The dataclass of `optics`."""
        return EncoderScale(self.steps_per_rev, self.zero_count, self.direction)


class CalibrationEncoderModel(ScannerEncoderModel):
    """`[encoder]` of a calibration: a disc may sit off its centre."""

    eccentricity_rad: float = Field(default=0.0, ge=0, lt=0.1)
    eccentricity_phase_deg: float = Field(default=0.0, ge=-360, le=360)

    def scale(self) -> EncoderScale:
        """The dataclass of `optics`."""
        phase = math.radians(self.eccentricity_phase_deg)
        return EncoderScale(self.steps_per_rev, self.zero_count, self.direction, self.eccentricity_rad, phase)


def camera_table(camera: Camera) -> Table:
    """`[camera]` as plain values."""
    return CameraModel(**{key: getattr(camera, key) for key in CameraModel.model_fields}).model_dump(mode="json")


def both_lasers_once(names: list[str]) -> None:
    """Refuse anything but one right and one left laser.

    Raises:
        ValueError: Another set of names.
    """
    if sorted(names) != ["left", "right"]:
        raise ValueError(f'one laser "right" and one laser "left" are needed, found {names}')
