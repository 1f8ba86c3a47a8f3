"""What the records hold, as plain values: nothing here knows of a database."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import date, datetime
from typing import Any, Literal

from footscan.config.recording_file import Load, Surface
from footscan.coordinates import Side

Verdict = Literal["undecided", "accepted", "with_remark", "repeat"]
"""A person's word on a take; `with_remark` and `repeat` say why."""


@dataclass(frozen=True)
class NewPatient:
    """A patient as entered: name in any script, date of birth, the clinic's own number, notes."""

    name: str
    born: date | None = None
    number: str | None = None
    notes: str = ""


@dataclass(frozen=True)
class Patient(NewPatient):
    """A patient as kept."""

    id: int = 0
    created: datetime = datetime.min


@dataclass(frozen=True)
class Visit:
    """One visit of a patient; `day` is the calendar day where the scanner stands."""

    id: int
    patient_id: int
    day: date
    opened: datetime
    operator: str
    notes: str


@dataclass(frozen=True)
class FootFacts:
    """What a person declares of one foot on one visit.

    Attributes:
        missing: Missing parts, as in `footscan.foot.standing.PARTS`.
        dressings: What covers it and where.
        deformity: Declared deformity, in words.
        not_scanned: Why this foot was not scanned; empty when it was or will be.
    """

    missing: tuple[str, ...] = ()
    dressings: str = ""
    deformity: str = ""
    not_scanned: str = ""


@dataclass(frozen=True)
class Foot:
    """One foot on one visit."""

    id: int
    visit_id: int
    side: Side
    facts: FootFacts


@dataclass(frozen=True)
class NewTake:
    """What is said of a recording when it is filed; `recorded` has a time zone."""

    side: Side
    operator: str
    recorded: datetime
    load: Load = "unknown"
    surface: Surface = "unknown"
    load_kg: float | None = None
    surface_mm: float | None = None
    wedge_mm: float | None = None
    machine: str | None = None


@dataclass(frozen=True)
class Measured:
    """One measurement with the text of its definition; `version` is the fingerprint of that text."""

    name: str
    value: float | None
    unit: str
    reliable: bool
    reason: str
    interval: tuple[float, float] | None
    unusual: str | None
    definition: str
    version: str


@dataclass(frozen=True)
class NewResult:
    """What one processing of a take gave.

    Attributes:
        side: As used; differs from the take's after a correction until the take is processed again.
        load: As used.
        missing: Missing parts, as used.
        calibration_sha256: Fingerprint of the calibration's numbers.
        settings: Everything needed to process in the same way again.
        versions: Of footscan and what it stands on.
        refused: Why there is no foot; empty when there is one.
        measurements: Empty when refused.
    """

    side: Side
    load: Load
    missing: tuple[str, ...]
    calibration_sha256: str
    settings: Mapping[str, Any]
    versions: Mapping[str, Any]
    refused: str = ""
    measurements: tuple[Measured, ...] = ()


@dataclass(frozen=True)
class Result(NewResult):
    """A processing as kept; its files are found by `RecordStore.results_folder`."""

    id: int = 0
    computed: datetime = datetime.min
    files_sha256: str = ""
    calibration_files: str | None = None


@dataclass(frozen=True)
class Landmark:
    """A landmark placed by hand, `xyz_world` in mm in the coordinates of its take's recording."""

    name: str
    xyz_world: tuple[float, float, float]
    placed_by: str
    placed: datetime


@dataclass(frozen=True)
class Take:
    """A filed recording with its latest result."""

    id: int
    patient_id: int
    visit_id: int
    foot_id: int
    number: int
    said: NewTake
    missing: tuple[str, ...]
    filed: datetime
    finished: bool
    verdict: Verdict
    verdict_by: str
    verdict_remark: str
    in_use: bool
    recording_sha256: str
    calibration_files: str | None = None
    result: Result | None = None
    landmarks: tuple[Landmark, ...] = ()

    @property
    def stale(self) -> bool:
        """Whether the result was made with another side, load or missing parts than are known now."""
        if self.result is None:
            return False
        used = (self.result.side, self.result.load, self.result.missing)
        return used != (self.said.side, self.said.load, self.missing)


@dataclass(frozen=True)
class Correction:
    """What was wrong with a take; None leaves a thing as it is."""

    patient_id: int | None = None
    side: Side | None = None
    load: Load | None = None
    surface: Surface | None = None


@dataclass(frozen=True)
class AuditEntry:
    """One line of the log that nobody can change.

    `detail` never holds a name, birth date, number or note of a patient, so that it may outlive a deleted patient.
    """

    id: int
    at: datetime
    by: str
    action: str
    patient_id: int | None
    subject: str
    reason: str
    detail: Mapping[str, Any] = field(default_factory=dict)
