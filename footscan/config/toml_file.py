"""Reading and validating one TOML file, with messages that name file, key, what was found and what is allowed."""

import os
import re
import tempfile
import tomllib
from pathlib import Path
from typing import Any, TypeVar

import tomli_w
from pydantic import BaseModel, ConfigDict, ValidationError

from footscan.errors import ConfigError, StorageError

Table = dict[str, Any]


class Strict(BaseModel):
    """Base of all file models: unknown keys, NaN, infinity and numbers in quotes are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, strict=True)


Model = TypeVar("Model", bound=Strict)


def tuple_from_list(value: Any) -> Any:
    """A TOML array as the tuple that strict models ask for; anything else is left for them to refuse."""
    return tuple(value) if isinstance(value, list) else value


def read_toml(path: Path) -> Table:
    """Read a TOML file into plain values.

    Raises:
        ConfigError: The file is missing, unreadable, not UTF-8 or not TOML.
    """
    try:
        return tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except FileNotFoundError:
        raise ConfigError(f"{path} does not exist; give the path of an existing TOML file.") from None
    except (OSError, UnicodeDecodeError) as err:
        raise ConfigError(f"{path} cannot be read ({err}); give a readable TOML text file.") from err
    except tomllib.TOMLDecodeError as err:
        raise ConfigError(
            f"{path} is not valid TOML: {err}. Correct that line or take the file from a backup."
        ) from err


def file_kind(path: Path) -> str:
    """The kind of a footscan TOML file, "scanner" for `format = "footscan-scanner/1"`.

    Raises:
        ConfigError: The file cannot be read or has no footscan format line.
    """
    found = read_toml(path).get("format")
    match = re.fullmatch(r"footscan-([a-z]+)/\d+", found) if isinstance(found, str) else None
    if match is None:
        raise ConfigError(f'{path}: key "format" is {found!r}, allowed is "footscan-<kind>/<version>".')
    return match.group(1)


def load_file(path: Path, kind: str, model: type[Model]) -> Model:
    """Read and validate a file whose format must be `footscan-<kind>/1`.

    Raises:
        ConfigError: Anything wrong with the file, one sentence per mistake (the first three).
    """
    table = read_toml(path)
    allowed = f"footscan-{kind}/1"
    found = table.pop("format", None)
    if found != allowed:
        newer = isinstance(found, str) and found.startswith(f"footscan-{kind}/")
        advice = "Update footscan or convert the file." if newer else "Give a file of that kind."
        raise ConfigError(f'{path}: key "format" is {found!r}, allowed is "{allowed}". {advice}')
    try:
        return model.model_validate(table)
    except ValidationError as err:
        raise ConfigError(f"{path}: {_sentences(err, table)}") from None


def _sentences(err: ValidationError, table: Table) -> str:
    mistakes = err.errors(include_url=False)
    shown = "; ".join(_sentence(dict(mistake), table) for mistake in mistakes[:3])
    more = f" (and {len(mistakes) - 3} more)" if len(mistakes) > 3 else ""
    return f"{shown}{more}."


def _sentence(mistake: Table, table: Table) -> str:
    kind, found = mistake["type"], mistake.get("input")
    key = _key(mistake["loc"], table, missing=kind == "missing")
    if kind == "union_tag_invalid":
        context = mistake["ctx"]
        kinds = context["expected_tags"].replace("'", '"')
        return f'key "{key}.{context["discriminator"].strip(chr(39))}" is "{context["tag"]}", allowed is {kinds}'
    if kind == "extra_forbidden":
        return f'key "{key}" is unknown, remove it or correct its spelling'
    if kind == "missing":
        return f'key "{key}" is missing, add it'
    message = mistake["msg"].removeprefix("Value error, ").replace("valid tuple", "list")
    what = f" is {found!r}" if not isinstance(found, dict | list | tuple) else ""
    sentence = f"{message[0].lower()}{message[1:]}"
    return f'key "{key}"{what}: {sentence}' if key else sentence


def _key(place: tuple[str | int, ...], table: Table, missing: bool) -> str:
    """A key as the file spells it: without the kinds by which one of several tables was chosen."""
    parts: list[str] = []
    here: Any = table
    for number, part in enumerate(place):
        inside = part in here if isinstance(here, dict) else isinstance(here, list)
        if inside or (missing and number == len(place) - 1):
            parts.append(str(part))
            here = here[part] if inside else None
    return ".".join(parts)


def write_whole(path: Path, content: bytes) -> None:
    """Write a file so that it is there whole or not at all: write beside, fsync, rename.

    Raises:
        StorageError: The disk is full or the place cannot be written; nothing is left behind.
    """
    temporary = None
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=path.parent, prefix=f".{path.name}.", delete=False) as stream:
            temporary = Path(stream.name)
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        temporary.chmod(0o666 & ~_umask())
        temporary.replace(path)
    except BaseException as err:
        if temporary is not None:
            temporary.unlink(missing_ok=True)
        if not isinstance(err, OSError):
            raise
        raise StorageError(
            f"{path} could not be written ({err.strerror}); free space or choose another place."
        ) from err


def _umask() -> int:
    """The permissions this process withholds from new files."""
    mask = os.umask(0o077)
    os.umask(mask)
    return mask


def toml_bytes(table: Table) -> bytes:
    """A TOML table as UTF-8 text."""
    return tomli_w.dumps(table).encode()
