"""From any shipped version of the tables to the newest, inside one transaction."""

from pathlib import Path

from alembic import command
from alembic.config import Config
from alembic.script import ScriptDirectory
from sqlalchemy import Connection

MIGRATIONS = Path(__file__).parent / "migrations"
KNOWN = ("0001",)
"""Every version that was ever shipped, oldest first."""


def alembic_config(folder: Path = MIGRATIONS) -> Config:
    """Alembic's settings for a folder of migrations; there is no ini file."""
    config = Config()
    config.set_main_option("script_location", str(folder).replace("%", "%%"))
    config.set_main_option("path_separator", "os")
    return config


def bring_up_to_date(connection: Connection, folder: Path = MIGRATIONS) -> None:
    """Run what is missing; all of it takes effect with the commit of the connection's transaction, or nothing."""
    config = alembic_config(folder)
    config.attributes["connection"] = connection
    command.upgrade(config, "head")


def shipped_versions(folder: Path = MIGRATIONS) -> tuple[str, ...]:
    """The versions of a folder of migrations, oldest first."""
    walk = ScriptDirectory.from_config(alembic_config(folder)).walk_revisions()
    return tuple(reversed([script.revision for script in walk]))
