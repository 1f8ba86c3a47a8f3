"""scanner.toml (`footscan-scanner/1`): the design of a machine."""

import math
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BeforeValidator, Field, model_validator

from footscan.config.machine_models import CameraModel, ScannerEncoderModel, both_lasers_once, camera_table
from footscan.config.toml_file import Strict, load_file, toml_bytes, tuple_from_list
from footscan.optics.head import Head
from footscan.optics.scanner import LaserDesign, Scanner


class HeadModel(Strict):
    """`[head]`, Table I of the paper."""

    h_mm: float = Field(gt=0, lt=5000)
    g_mm: float = Field(gt=0, lt=5000)
    p_mm: float = Field(ge=-1000, lt=1000)
    cc_mm: float = Field(ge=-1000, lt=1000)
    phi_deg: float = Field(gt=1, lt=89)
    sigma_deg: float = Field(gt=-45, lt=45)

    def head(self) -> Head:
        """The dataclass of `optics`."""
        phi, sigma = math.radians(self.phi_deg), math.radians(self.sigma_deg)
        return Head(self.h_mm, self.g_mm, self.p_mm, self.cc_mm, phi, sigma)


class LaserModel(Strict):
    """`[[laser]]` of a design."""

    name: Literal["right", "left"]
    alpha_deg: float = Field(gt=-90, lt=90)
    sweep: Literal["ccw", "cw"]


class ScannerModel(Strict):
    """The whole file."""

    name: str = Field(min_length=1)
    machine_id: str | None = None
    camera: CameraModel
    head: HeadModel
    laser: Annotated[tuple[LaserModel, LaserModel], BeforeValidator(tuple_from_list)]
    encoder: ScannerEncoderModel

    @model_validator(mode="after")
    def _lasers(self) -> "ScannerModel":
        both_lasers_once([laser.name for laser in self.laser])
        return self

    def scanner(self) -> Scanner:
        """The dataclass of `optics`, right laser first."""
        ordered = sorted(self.laser, key=lambda laser: laser.name, reverse=True)
        right, left = (LaserDesign(x.name, math.radians(x.alpha_deg), x.sweep) for x in ordered)
        camera, head, encoder = self.camera.camera(), self.head.head(), self.encoder.scale()
        return Scanner(self.name, self.machine_id, camera, head, (right, left), encoder)


def load_scanner(path: Path | str) -> Scanner:
    """Read and validate scanner.toml.

    Raises:
        ConfigError: Missing file or key, unknown key, wrong type or range; the message names all of it.
    """
    return load_file(Path(path), "scanner", ScannerModel).scanner()


def scanner_toml(scanner: Scanner) -> bytes:
    """scanner.toml of a design."""
    head = scanner.head
    table = {"format": "footscan-scanner/1", "name": scanner.name}
    if scanner.machine_id is not None:
        table["machine_id"] = scanner.machine_id
    lengths = {key: getattr(head, key) for key in ("h_mm", "g_mm", "p_mm", "cc_mm")}
    angles = {"phi_deg": _deg(head.phi_rad), "sigma_deg": _deg(head.sigma_rad)}
    encoder = {key: getattr(scanner.encoder, key) for key in ("steps_per_rev", "zero_count", "direction")}
    lasers = [{"name": x.name, "alpha_deg": _deg(x.alpha_rad), "sweep": x.sweep} for x in scanner.lasers]
    parts = {"camera": camera_table(scanner.camera), "head": lengths | angles, "laser": lasers, "encoder": encoder}
    return toml_bytes(table | parts)


def _deg(angle_rad: float) -> float:
    return round(math.degrees(angle_rad), 12)
