"""The tables, for SQLAlchemy. Migrations make them; a test holds that both agree."""

from datetime import UTC, date, datetime
from typing import Any

from sqlalchemy import JSON, CheckConstraint, Dialect, Float, ForeignKey, Index, MetaData, UniqueConstraint, text
from sqlalchemy.orm import DeclarativeBase, Mapped, mapped_column
from sqlalchemy.types import String, TypeDecorator

SCHEMA = "0001"
"""The newest migration this program knows."""
APPLICATION_ID = 0x46534341  # "FSCA", written into the header of the database file
NAMING = {
    "ix": "ix_%(column_0_label)s",
    "uq": "uq_%(table_name)s_%(column_0_name)s",
    "ck": "ck_%(table_name)s_%(constraint_name)s",
    "fk": "fk_%(table_name)s_%(column_0_name)s",
    "pk": "pk_%(table_name)s",
}
NEVER_REUSED = {"sqlite_autoincrement": True}  # the log speaks of rows by number, long after they are gone
SIDES = "side IN ('left', 'right')"
LOADS = "load IN ('unknown', 'unloaded', 'seated', 'bipedal', 'single_leg')"
SURFACES = "surface IN ('unknown', 'bare', 'sock', 'bandage', 'dressing')"
VERDICTS = "verdict IN ('undecided', 'accepted', 'with_remark', 'repeat')"


class Moment(TypeDecorator[datetime]):
    """A moment in UTC as text that sorts by time: 2026-11-23T22:57:00.123456+00:00."""

    impl = String
    cache_ok = True

    def process_bind_param(self, value: datetime | None, dialect: Dialect) -> str | None:
        """Text of a moment with a time zone."""
        return None if value is None else value.astimezone(UTC).isoformat(timespec="microseconds")

    def process_result_value(self, value: str | None, dialect: Dialect) -> datetime | None:
        """The moment of a text."""
        return None if value is None else datetime.fromisoformat(value)


class Row(DeclarativeBase):
    """All tables."""

    metadata = MetaData(naming_convention=NAMING)
    type_annotation_map = {datetime: Moment, float: Float, dict[str, Any]: JSON, list[str]: JSON}  # noqa: RUF012  as SQLAlchemy reads it


class PatientRow(Row):
    """`name_key` finds duplicates, `search_key` is what is searched."""

    __tablename__ = "patients"
    __table_args__ = (Index("ix_patients_name_key", "name_key", "born"), NEVER_REUSED)

    id: Mapped[int] = mapped_column(primary_key=True)
    name: Mapped[str]
    name_key: Mapped[str]
    search_key: Mapped[str]
    born: Mapped[date | None]
    number: Mapped[str | None] = mapped_column(unique=True)
    notes: Mapped[str]
    created: Mapped[datetime]


class VisitRow(Row):
    """`day` is the local calendar day."""

    __tablename__ = "visits"
    __table_args__ = (NEVER_REUSED,)

    id: Mapped[int] = mapped_column(primary_key=True)
    patient_id: Mapped[int] = mapped_column(ForeignKey("patients.id", ondelete="CASCADE"), index=True)
    day: Mapped[date]
    opened: Mapped[datetime]
    operator: Mapped[str]
    notes: Mapped[str]


class FootRow(Row):
    """One foot on one visit, with what a person declared of it."""

    __tablename__ = "feet"
    __table_args__ = (UniqueConstraint("visit_id", "side"), CheckConstraint(SIDES, "side"), NEVER_REUSED)

    id: Mapped[int] = mapped_column(primary_key=True)
    visit_id: Mapped[int] = mapped_column(ForeignKey("visits.id", ondelete="CASCADE"))
    side: Mapped[str]
    missing: Mapped[list[str]]
    dressings: Mapped[str]
    deformity: Mapped[str]
    not_scanned: Mapped[str]


class StoredRow(Row):
    """A folder kept by content hash; `discarded` ones are being removed on a person's word."""

    __tablename__ = "stored"

    sha256: Mapped[str] = mapped_column(primary_key=True)
    kind: Mapped[str]
    size_bytes: Mapped[int]
    stored: Mapped[datetime]
    discarded: Mapped[bool]


class TakeRow(Row):
    """A filed recording. At most one take per foot and load is in use."""

    __tablename__ = "takes"
    __table_args__ = (
        UniqueConstraint("foot_id", "number"),
        CheckConstraint(LOADS, "load"),
        CheckConstraint(SURFACES, "surface"),
        CheckConstraint(VERDICTS, "verdict"),
        Index("ix_takes_in_use", "foot_id", "load", unique=True, sqlite_where=text("in_use")),
        NEVER_REUSED,
    )

    id: Mapped[int] = mapped_column(primary_key=True)
    foot_id: Mapped[int] = mapped_column(ForeignKey("feet.id", ondelete="CASCADE"), index=True)
    number: Mapped[int]
    load: Mapped[str]
    load_kg: Mapped[float | None]
    surface: Mapped[str]
    surface_mm: Mapped[float | None]
    wedge_mm: Mapped[float | None]
    operator: Mapped[str]
    machine: Mapped[str | None]
    recorded: Mapped[datetime]
    filed: Mapped[datetime]
    finished: Mapped[bool]
    verdict: Mapped[str]
    verdict_by: Mapped[str]
    verdict_remark: Mapped[str]
    in_use: Mapped[bool]
    source: Mapped[str | None]
    recording_sha256: Mapped[str] = mapped_column(ForeignKey("stored.sha256"), unique=True)
    calibration_files: Mapped[str | None] = mapped_column(ForeignKey("stored.sha256"), index=True)


class ResultRow(Row):
    """One processing of a take; the latest counts, the earlier ones stay."""

    __tablename__ = "results"
    __table_args__ = (CheckConstraint(SIDES, "side"), CheckConstraint(LOADS, "load"), NEVER_REUSED)

    id: Mapped[int] = mapped_column(primary_key=True)
    take_id: Mapped[int] = mapped_column(ForeignKey("takes.id", ondelete="CASCADE"), index=True)
    computed: Mapped[datetime]
    side: Mapped[str]
    load: Mapped[str]
    missing: Mapped[list[str]]
    calibration_sha256: Mapped[str]
    settings: Mapped[dict[str, Any]]
    versions: Mapped[dict[str, Any]]
    refused: Mapped[str]
    files_sha256: Mapped[str] = mapped_column(ForeignKey("stored.sha256"), index=True)
    calibration_files: Mapped[str | None] = mapped_column(ForeignKey("stored.sha256"), index=True)


class DefinitionRow(Row):
    """What a measurement's name meant; a changed text is a new version."""

    __tablename__ = "definitions"
    __table_args__ = (UniqueConstraint("name", "version"),)

    id: Mapped[int] = mapped_column(primary_key=True)
    name: Mapped[str]
    version: Mapped[str]
    definition: Mapped[str]


class MeasurementRow(Row):
    """One value of one result."""

    __tablename__ = "measurements"
    __table_args__ = (UniqueConstraint("result_id", "definition_id"),)

    id: Mapped[int] = mapped_column(primary_key=True)
    result_id: Mapped[int] = mapped_column(ForeignKey("results.id", ondelete="CASCADE"))
    definition_id: Mapped[int] = mapped_column(ForeignKey("definitions.id"), index=True)
    value: Mapped[float | None]
    unit: Mapped[str]
    reliable: Mapped[bool]
    reason: Mapped[str]
    low: Mapped[float | None]
    high: Mapped[float | None]
    unusual: Mapped[str | None]


class LandmarkRow(Row):
    """A landmark by hand, mm in the recording's world coordinates."""

    __tablename__ = "landmarks"
    __table_args__ = (UniqueConstraint("take_id", "name"),)

    id: Mapped[int] = mapped_column(primary_key=True)
    take_id: Mapped[int] = mapped_column(ForeignKey("takes.id", ondelete="CASCADE"))
    name: Mapped[str]
    x_world_mm: Mapped[float]
    y_world_mm: Mapped[float]
    z_world_mm: Mapped[float]
    placed_by: Mapped[str]
    placed: Mapped[datetime]


class AuditRow(Row):
    """Triggers of the database forbid changing or deleting its rows. `patient_id` may outlive the patient."""

    __tablename__ = "audit"
    __table_args__ = (NEVER_REUSED,)

    id: Mapped[int] = mapped_column(primary_key=True)
    at: Mapped[datetime]
    by: Mapped[str]
    action: Mapped[str]
    patient_id: Mapped[int | None] = mapped_column(index=True)
    subject: Mapped[str]
    reason: Mapped[str]
    detail: Mapped[dict[str, Any]]
