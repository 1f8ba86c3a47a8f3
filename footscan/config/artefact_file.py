"""artefact.toml (`footscan-artefact/1`): a test body of known size, for acceptance."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BeforeValidator, Field, model_validator

from footscan.config.toml_file import Strict, Table, load_file, toml_bytes, tuple_from_list

ArtefactKind = Literal["sphere", "ball-bar", "plane"]
_SPHERES = {"sphere": 1, "ball-bar": 2, "plane": 0}


@dataclass(frozen=True)
class Artefact:
    """A test body.

    Attributes:
        kind: Sphere, ball bar or plane.
        diameters_mm: Calibrated diameters of its spheres.
        spacing_mm: Calibrated distance of the centres of a ball bar.
        name: What it is called; empty where nobody said.
    """

    kind: ArtefactKind
    diameters_mm: tuple[float, ...] = ()
    spacing_mm: float | None = None
    name: str = ""


class ArtefactModel(Strict):
    """The whole file."""

    kind: ArtefactKind
    diameters_mm: Annotated[tuple[Annotated[float, Field(gt=1, lt=400)], ...], BeforeValidator(tuple_from_list)] = ()
    spacing_mm: float | None = Field(default=None, gt=1, lt=1000)
    name: str = ""

    @model_validator(mode="after")
    def _complete(self) -> "ArtefactModel":
        wanted = _SPHERES[self.kind]
        if len(self.diameters_mm) != wanted:
            raise ValueError(f"a {self.kind} has {wanted} calibrated diameters, found {len(self.diameters_mm)}")
        if (self.kind == "ball-bar") != (self.spacing_mm is not None):
            raise ValueError("spacing_mm belongs to a ball-bar, and to nothing else")
        return self


def load_artefact(path: Path | str) -> Artefact:
    """Read and validate artefact.toml.

    Raises:
        ConfigError: Anything wrong with the file.
    """
    return Artefact(**load_file(Path(path), "artefact", ArtefactModel).model_dump())


def artefact_toml(artefact: Artefact) -> bytes:
    """artefact.toml of a test body."""
    table: Table = {"format": "footscan-artefact/1", "kind": artefact.kind}
    table |= {"diameters_mm": list(artefact.diameters_mm)} if artefact.diameters_mm else {}
    table |= {"spacing_mm": artefact.spacing_mm} if artefact.spacing_mm is not None else {}
    return toml_bytes(table | ({"name": artefact.name} if artefact.name else {}))
