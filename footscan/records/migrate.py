"""From any shipped version of the tables to the newest, inside one transaction.

Alembic is loaded when it has work to do, which is once per version: every command would wait for it otherwise.
"""

from pathlib import Path
from typing import TYPE_CHECKING

from sqlalchemy import Connection

if TYPE_CHECKING:
    from alembic.config import Config

MIGRATIONS = Path(__file__).parent / "migrations"
KNOWN = ("0001",)
"""Every version that was ever shipped, oldest first."""


def alembic_config(folder: Path = MIGRATIONS) -> "Config":
    """Alembic's settings for a folder of migrations; there is no ini file."""
    from alembic.config import Config  # noqa: PLC0415

    config = Config()
    config.set_main_option("script_location", str(folder).replace("%", "%%"))
    config.set_main_option("path_separator", "os")
    return config


def bring_up_to_date(connection: Connection, folder: Path = MIGRATIONS) -> None:
    """Run what is missing; all of it takes effect with the commit of the connection's transaction, or nothing."""
    from alembic import command  # noqa: PLC0415

    config = alembic_config(folder)
    config.attributes["connection"] = connection
    command.upgrade(config, "head")


def shipped_versions(folder: Path = MIGRATIONS) -> tuple[str, ...]:
    """The versions of a folder of migrations, oldest first."""
    from alembic.script import ScriptDirectory  # noqa: PLC0415

    walk = ScriptDirectory.from_config(alembic_config(folder)).walk_revisions()
    return tuple(reversed([script.revision for script in walk]))
