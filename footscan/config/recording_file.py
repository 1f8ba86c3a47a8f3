"""recording.toml (`footscan-recording/1`): what a recording shows and of whom."""

from dataclasses import asdict, dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BeforeValidator, Field, field_validator

from footscan.config.toml_file import Strict, Table, load_file, toml_bytes, tuple_from_list

Kind = Literal["scan", "calibration"]
RecordingSide = Literal["right", "left", "none"]
Load = Literal["unknown", "unloaded", "seated", "bipedal", "single_leg"]
Surface = Literal["unknown", "bare", "sock", "bandage", "dressing"]

MOST_WEDGE_MM = 100.0
"""No heel can be lifted further by a wedge that ends under the ball; 87 mm are the highest lasts known."""


@dataclass(frozen=True)
class Subject:
    """Load on the foot, what covers the skin, what is missing; everything is unknown unless somebody said so."""

    load: Load = "unknown"
    load_kg: float | None = None
    surface: Surface = "unknown"
    surface_mm: float | None = None
    take: int | None = None
    wedge_mm: float | None = None
    absent: tuple[str, ...] = ()


@dataclass(frozen=True)
class RecordingInfo:
    """recording.toml."""

    kind: Kind
    side: RecordingSide
    created: str
    notes: str = ""
    subject: Subject = field(default_factory=Subject)


class SubjectModel(Strict):
    """`[subject]`."""

    load: Load = "unknown"
    load_kg: float | None = Field(default=None, ge=0, le=500)
    surface: Surface = "unknown"
    surface_mm: float | None = Field(default=None, ge=0, le=50)
    take: int | None = Field(default=None, ge=0)
    wedge_mm: float | None = Field(default=None, ge=0, le=150)
    absent: Annotated[tuple[str, ...], BeforeValidator(tuple_from_list)] = ()


class RecordingModel(Strict):
    """The whole file."""

    kind: Kind
    side: RecordingSide
    created: str
    notes: str = ""
    subject: SubjectModel = Field(default_factory=SubjectModel)

    @field_validator("created")
    @classmethod
    def _moment(cls, value: str) -> str:
        try:
            datetime.fromisoformat(value)
        except ValueError:
            raise ValueError("a moment like 2026-11-21T12:00:00+00:00 (RFC 3339) is needed") from None
        return value


def load_recording_info(path: Path | str) -> RecordingInfo:
    """Read and validate recording.toml.

    Raises:
        ConfigError: Anything wrong with the file.
    """
    model = load_file(Path(path), "recording", RecordingModel)
    subject = Subject(**model.subject.model_dump())
    return RecordingInfo(model.kind, model.side, model.created, model.notes, subject)


def recording_toml(info: RecordingInfo) -> bytes:
    """recording.toml of a recording; a subject of whom nothing is known is left out."""
    table: Table = {"format": "footscan-recording/1"}
    table |= {key: getattr(info, key) for key in ("kind", "side", "created", "notes")}
    if info.subject != Subject():
        known = {key: value for key, value in asdict(info.subject).items() if value not in (None, ())}
        table["subject"] = known
    return toml_bytes(table)
