"""calibration.toml (`footscan-calibration/1`): a machine as measured."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, model_validator

from footscan.config.machine_models import (
    CalibrationEncoderModel,
    CameraModel,
    LengthTriple,
    Triple,
    both_lasers_once,
    camera_table,
)
from footscan.config.toml_file import Strict, Table, load_file, toml_bytes, tuple_from_list, write_whole
from footscan.geometry.plane import Plane
from footscan.optics.calibration import Calibration, Pose
from footscan.optics.sheet import LightPlane

_UNIT_TOLERANCE = 1e-6


def _unit(normal: tuple[float, float, float]) -> tuple[float, float, float]:
    length = math.sqrt(sum(x * x for x in normal))
    if abs(length - 1.0) > _UNIT_TOLERANCE:
        raise ValueError(f"a normal must have length 1 (to 1e-6), found {length:.8g}")
    if abs(length - 1.0) < 1e-12:
        return normal
    x, y, z = normal
    return (x / length, y / length, z / length)


class PoseModel(Strict):
    """`[pose]`: phi, sigma and T_WC."""

    phi_deg: float = Field(gt=1, lt=89)
    sigma_deg: float = Field(gt=-45, lt=45)
    translation_mm: LengthTriple

    def pose(self) -> Pose:
        """The dataclass of `optics`."""
        return Pose(math.radians(self.phi_deg), math.radians(self.sigma_deg), self.translation_mm)


class SheetModel(Strict):
    """`[[laser]]` of a calibration: the sheet normal.x = offset in W at theta = 0."""

    name: Literal["right", "left"]
    normal: Triple
    offset_mm: float = Field(gt=-500, lt=500)

    @model_validator(mode="after")
    def _upright(self) -> "SheetModel":
        if abs(_unit(self.normal)[2]) > 0.7:
            raise ValueError(f"a light plane stands upright, this one leans more than 45 degrees: {self.normal}")
        return self

    def sheet(self) -> LightPlane:
        """The dataclass of `optics`."""
        return LightPlane(self.name, _unit(self.normal), self.offset_mm)


class FloorModel(Strict):
    """`[floor]`: the footboard in W."""

    normal: Triple
    offset_mm: float = Field(gt=-500, lt=500)

    @model_validator(mode="after")
    def _level(self) -> "FloorModel":
        if _unit(self.normal)[2] < 0.9:
            raise ValueError(f"the footboard is level, its normal points up; found {self.normal}")
        return self

    def plane(self) -> Plane:
        """The dataclass of `geometry`."""
        return Plane(_unit(self.normal), self.offset_mm)


class TimingModel(Strict):
    """`[timing]`."""

    latency_s: float = Field(gt=-1, lt=1)


class CalibrationModel(Strict):
    """The whole file. `quality` and `history` say where the numbers come from; the mathematics does not use them."""

    scanner: str
    machine_id: str | None = None
    created: str
    camera: CameraModel
    pose: PoseModel
    laser: Annotated[tuple[SheetModel, SheetModel], BeforeValidator(tuple_from_list)]
    floor: FloorModel
    encoder: CalibrationEncoderModel
    timing: TimingModel
    quality: dict[str, Any] | None = None
    history: dict[str, Any] | None = None

    @model_validator(mode="after")
    def _lasers(self) -> "CalibrationModel":
        both_lasers_once([laser.name for laser in self.laser])
        return self

    def calibration(self) -> Calibration:
        """The dataclass of `optics`, right laser first."""
        right, left = sorted(self.laser, key=lambda laser: laser.name, reverse=True)
        return Calibration(
            scanner=self.scanner,
            machine_id=self.machine_id,
            camera=self.camera.camera(),
            pose=self.pose.pose(),
            lasers=(right.sheet(), left.sheet()),
            floor=self.floor.plane(),
            encoder=self.encoder.scale(),
            latency_s=self.timing.latency_s,
            created=self.created,
        )


@dataclass(frozen=True)
class CalibrationRecord:
    """A calibration file with what it says of itself: figures of quality, and where it comes from."""

    calibration: Calibration
    quality: Table
    history: Table


def load_calibration_record(path: Path | str) -> CalibrationRecord:
    """Read and validate calibration.toml with its `[quality]` and `[history]`; missing ones are empty.

    Raises:
        ConfigError: As `load_calibration`.
    """
    model = load_file(Path(path), "calibration", CalibrationModel)
    return CalibrationRecord(model.calibration(), model.quality or {}, model.history or {})


def load_calibration(path: Path | str) -> Calibration:
    """Read and validate calibration.toml.

    Raises:
        ConfigError: Missing file or key, unknown key, wrong type or range, NaN; the message names all of it.
    """
    return load_file(Path(path), "calibration", CalibrationModel).calibration()


def calibration_toml(calibration: Calibration, quality: Table | None = None, history: Table | None = None) -> bytes:
    """calibration.toml of a calibration, with optional `[quality]` and `[history]` tables of plain values."""
    table: Table = {"format": "footscan-calibration/1", "scanner": calibration.scanner}
    if calibration.machine_id is not None:
        table["machine_id"] = calibration.machine_id
    pose, encoder = calibration.pose, calibration.encoder
    scale: Table = {key: getattr(encoder, key) for key in ("steps_per_rev", "zero_count", "direction")}
    if encoder.eccentricity_rad:
        phase_deg = math.degrees(encoder.eccentricity_phase_rad)
        scale |= {"eccentricity_rad": encoder.eccentricity_rad, "eccentricity_phase_deg": phase_deg}
    angles = {"phi_deg": math.degrees(pose.phi_rad), "sigma_deg": math.degrees(pose.sigma_rad)}
    table |= {
        "created": calibration.created,
        "camera": camera_table(calibration.camera),
        "pose": angles | {"translation_mm": list(pose.translation_mm)},
        "floor": {"normal": list(calibration.floor.normal), "offset_mm": calibration.floor.offset_mm},
        "encoder": scale,
        "timing": {"latency_s": calibration.latency_s},
        "laser": [
            {"name": sheet.name, "normal": list(sheet.normal), "offset_mm": sheet.offset_mm}
            for sheet in calibration.lasers
        ],
    }
    more = {"quality": quality, "history": history}
    return toml_bytes(table | {key: value for key, value in more.items() if value})


def save_calibration(
    calibration: Calibration, path: Path, quality: Table | None = None, history: Table | None = None
) -> None:
    """Write calibration.toml, whole or not at all.

    Raises:
        StorageError: The place cannot be written.
    """
    write_whole(path, calibration_toml(calibration, quality, history))
