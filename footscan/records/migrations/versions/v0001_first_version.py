"""The first version of the tables."""

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None

_APPEND_ONLY = "the log of the records can only be added to"


def upgrade() -> None:
    """From nothing to 0001."""
    op.execute("PRAGMA application_id = 1179861825")  # "FSCA": this file is ours
    _patients()
    _visits()
    _feet()
    _stored()
    _takes()
    _results()
    _definitions()
    _measurements()
    _landmarks()
    _audit()
    _audit_stays()


def _patients() -> None:
    op.create_table(
        "patients",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("name", sa.String(), nullable=False),
        sa.Column("name_key", sa.String(), nullable=False),
        sa.Column("search_key", sa.String(), nullable=False),
        sa.Column("born", sa.Date(), nullable=True),
        sa.Column("number", sa.String(), nullable=True),
        sa.Column("notes", sa.String(), nullable=False),
        sa.Column("created", sa.String(), nullable=False),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_patients")),
        sa.UniqueConstraint("number", name=op.f("uq_patients_number")),
        sqlite_autoincrement=True,
    )
    op.create_index("ix_patients_name_key", "patients", ["name_key", "born"], unique=False)


def _visits() -> None:
    op.create_table(
        "visits",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("patient_id", sa.Integer(), nullable=False),
        sa.Column("day", sa.Date(), nullable=False),
        sa.Column("opened", sa.String(), nullable=False),
        sa.Column("operator", sa.String(), nullable=False),
        sa.Column("notes", sa.String(), nullable=False),
        sa.ForeignKeyConstraint(["patient_id"], ["patients.id"], name=op.f("fk_visits_patient_id"), ondelete="CASCADE"),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_visits")),
        sqlite_autoincrement=True,
    )
    op.create_index(op.f("ix_visits_patient_id"), "visits", ["patient_id"], unique=False)


def _feet() -> None:
    op.create_table(
        "feet",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("visit_id", sa.Integer(), nullable=False),
        sa.Column("side", sa.String(), nullable=False),
        sa.Column("missing", sa.JSON(), nullable=False),
        sa.Column("dressings", sa.String(), nullable=False),
        sa.Column("deformity", sa.String(), nullable=False),
        sa.Column("not_scanned", sa.String(), nullable=False),
        sa.CheckConstraint("side IN ('left', 'right')", name=op.f("ck_feet_side")),
        sa.ForeignKeyConstraint(["visit_id"], ["visits.id"], name=op.f("fk_feet_visit_id"), ondelete="CASCADE"),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_feet")),
        sa.UniqueConstraint("visit_id", "side", name=op.f("uq_feet_visit_id")),
        sqlite_autoincrement=True,
    )


def _stored() -> None:
    op.create_table(
        "stored",
        sa.Column("sha256", sa.String(), nullable=False),
        sa.Column("kind", sa.String(), nullable=False),
        sa.Column("size_bytes", sa.Integer(), nullable=False),
        sa.Column("stored", sa.String(), nullable=False),
        sa.Column("discarded", sa.Boolean(), nullable=False),
        sa.PrimaryKeyConstraint("sha256", name=op.f("pk_stored")),
    )


def _takes() -> None:
    op.create_table(
        "takes",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("foot_id", sa.Integer(), nullable=False),
        sa.Column("number", sa.Integer(), nullable=False),
        sa.Column("load", sa.String(), nullable=False),
        sa.Column("load_kg", sa.Float(), nullable=True),
        sa.Column("surface", sa.String(), nullable=False),
        sa.Column("surface_mm", sa.Float(), nullable=True),
        sa.Column("wedge_mm", sa.Float(), nullable=True),
        sa.Column("operator", sa.String(), nullable=False),
        sa.Column("machine", sa.String(), nullable=True),
        sa.Column("recorded", sa.String(), nullable=False),
        sa.Column("filed", sa.String(), nullable=False),
        sa.Column("finished", sa.Boolean(), nullable=False),
        sa.Column("verdict", sa.String(), nullable=False),
        sa.Column("verdict_by", sa.String(), nullable=False),
        sa.Column("verdict_remark", sa.String(), nullable=False),
        sa.Column("in_use", sa.Boolean(), nullable=False),
        sa.Column("source", sa.String(), nullable=True),
        sa.Column("recording_sha256", sa.String(), nullable=False),
        sa.Column("calibration_files", sa.String(), nullable=True),
        sa.CheckConstraint(
            "load IN ('unknown', 'unloaded', 'seated', 'bipedal', 'single_leg')", name=op.f("ck_takes_load")
        ),
        sa.CheckConstraint(
            "surface IN ('unknown', 'bare', 'sock', 'bandage', 'dressing')", name=op.f("ck_takes_surface")
        ),
        sa.CheckConstraint(
            "verdict IN ('undecided', 'accepted', 'with_remark', 'repeat')", name=op.f("ck_takes_verdict")
        ),
        sa.ForeignKeyConstraint(["calibration_files"], ["stored.sha256"], name=op.f("fk_takes_calibration_files")),
        sa.ForeignKeyConstraint(["foot_id"], ["feet.id"], name=op.f("fk_takes_foot_id"), ondelete="CASCADE"),
        sa.ForeignKeyConstraint(["recording_sha256"], ["stored.sha256"], name=op.f("fk_takes_recording_sha256")),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_takes")),
        sa.UniqueConstraint("foot_id", "number", name=op.f("uq_takes_foot_id")),
        sa.UniqueConstraint("recording_sha256", name=op.f("uq_takes_recording_sha256")),
        sqlite_autoincrement=True,
    )
    op.create_index(op.f("ix_takes_calibration_files"), "takes", ["calibration_files"], unique=False)
    op.create_index(op.f("ix_takes_foot_id"), "takes", ["foot_id"], unique=False)
    op.create_index("ix_takes_in_use", "takes", ["foot_id", "load"], unique=True, sqlite_where=sa.text("in_use"))


def _results() -> None:
    op.create_table(
        "results",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("take_id", sa.Integer(), nullable=False),
        sa.Column("computed", sa.String(), nullable=False),
        sa.Column("side", sa.String(), nullable=False),
        sa.Column("load", sa.String(), nullable=False),
        sa.Column("missing", sa.JSON(), nullable=False),
        sa.Column("calibration_sha256", sa.String(), nullable=False),
        sa.Column("settings", sa.JSON(), nullable=False),
        sa.Column("versions", sa.JSON(), nullable=False),
        sa.Column("refused", sa.String(), nullable=False),
        sa.Column("files_sha256", sa.String(), nullable=False),
        sa.Column("calibration_files", sa.String(), nullable=True),
        sa.CheckConstraint(
            "load IN ('unknown', 'unloaded', 'seated', 'bipedal', 'single_leg')", name=op.f("ck_results_load")
        ),
        sa.CheckConstraint("side IN ('left', 'right')", name=op.f("ck_results_side")),
        sa.ForeignKeyConstraint(["calibration_files"], ["stored.sha256"], name=op.f("fk_results_calibration_files")),
        sa.ForeignKeyConstraint(["files_sha256"], ["stored.sha256"], name=op.f("fk_results_files_sha256")),
        sa.ForeignKeyConstraint(["take_id"], ["takes.id"], name=op.f("fk_results_take_id"), ondelete="CASCADE"),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_results")),
        sqlite_autoincrement=True,
    )
    op.create_index(op.f("ix_results_calibration_files"), "results", ["calibration_files"], unique=False)
    op.create_index(op.f("ix_results_files_sha256"), "results", ["files_sha256"], unique=False)
    op.create_index(op.f("ix_results_take_id"), "results", ["take_id"], unique=False)


def _definitions() -> None:
    op.create_table(
        "definitions",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("name", sa.String(), nullable=False),
        sa.Column("version", sa.String(), nullable=False),
        sa.Column("definition", sa.String(), nullable=False),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_definitions")),
        sa.UniqueConstraint("name", "version", name=op.f("uq_definitions_name")),
    )


def _measurements() -> None:
    op.create_table(
        "measurements",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("result_id", sa.Integer(), nullable=False),
        sa.Column("definition_id", sa.Integer(), nullable=False),
        sa.Column("value", sa.Float(), nullable=True),
        sa.Column("unit", sa.String(), nullable=False),
        sa.Column("reliable", sa.Boolean(), nullable=False),
        sa.Column("reason", sa.String(), nullable=False),
        sa.Column("low", sa.Float(), nullable=True),
        sa.Column("high", sa.Float(), nullable=True),
        sa.Column("unusual", sa.String(), nullable=True),
        sa.ForeignKeyConstraint(["definition_id"], ["definitions.id"], name=op.f("fk_measurements_definition_id")),
        sa.ForeignKeyConstraint(
            ["result_id"], ["results.id"], name=op.f("fk_measurements_result_id"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_measurements")),
        sa.UniqueConstraint("result_id", "definition_id", name=op.f("uq_measurements_result_id")),
    )
    op.create_index(op.f("ix_measurements_definition_id"), "measurements", ["definition_id"], unique=False)


def _landmarks() -> None:
    op.create_table(
        "landmarks",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("take_id", sa.Integer(), nullable=False),
        sa.Column("name", sa.String(), nullable=False),
        sa.Column("x_world_mm", sa.Float(), nullable=False),
        sa.Column("y_world_mm", sa.Float(), nullable=False),
        sa.Column("z_world_mm", sa.Float(), nullable=False),
        sa.Column("placed_by", sa.String(), nullable=False),
        sa.Column("placed", sa.String(), nullable=False),
        sa.ForeignKeyConstraint(["take_id"], ["takes.id"], name=op.f("fk_landmarks_take_id"), ondelete="CASCADE"),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_landmarks")),
        sa.UniqueConstraint("take_id", "name", name=op.f("uq_landmarks_take_id")),
    )


def _audit() -> None:
    op.create_table(
        "audit",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("at", sa.String(), nullable=False),
        sa.Column("by", sa.String(), nullable=False),
        sa.Column("action", sa.String(), nullable=False),
        sa.Column("patient_id", sa.Integer(), nullable=True),
        sa.Column("subject", sa.String(), nullable=False),
        sa.Column("reason", sa.String(), nullable=False),
        sa.Column("detail", sa.JSON(), nullable=False),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_audit")),
        sqlite_autoincrement=True,
    )
    op.create_index(op.f("ix_audit_patient_id"), "audit", ["patient_id"], unique=False)


def _audit_stays() -> None:
    """Whatever changes, deletes or replaces a line of the log is refused by the database itself."""
    for what in ("UPDATE", "DELETE"):
        op.execute(
            f"CREATE TRIGGER audit_no_{what.lower()} BEFORE {what} ON audit "
            f"BEGIN SELECT RAISE(ABORT, '{_APPEND_ONLY}'); END"
        )
    op.execute(
        "CREATE TRIGGER audit_no_replace BEFORE INSERT ON audit WHEN EXISTS (SELECT 1 FROM audit WHERE id = NEW.id) "
        f"BEGIN SELECT RAISE(ABORT, '{_APPEND_ONLY}'); END"
    )
