"""The built-in family's dimensions and solved factors, computed once and shipped with the package.

`python -m footscan.shoelast.make_family_index` writes family_index.json again; it must be run after every change of the
design, and `tests/shoelast/test_library.py` builds some members to see that it was.
"""

import ast
import hashlib
import json
import re
from collections.abc import Mapping
from functools import lru_cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from footscan.coordinates import Side
from footscan.errors import InputError
from footscan.shoelast.family_data import FamilyMember, check_member, family_data, family_members

FORMAT = "footscan-last-family-index/1"
_NAME = re.compile(r"([a-z]+)-eu(\d+(?:_\d+)?)-([a-z]+)-(\d+(?:\.\d+)?)mm-([a-z]+)(-left)?")


@lru_cache(maxsize=1)
def _stored() -> Mapping[str, Any]:
    place = files("footscan.shoelast").joinpath("family_index.json")
    return json.loads(place.read_text(encoding="utf-8")) if place.is_file() else {}


@lru_cache(maxsize=1)
def design_digest() -> str:
    """Of everything that a built-in last's shape and dimensions come from; comments and layout do not count."""
    here = files("footscan.shoelast")
    names = ("family", "family_data", "design", "levels", "net", "landmarks", "pose", "dimensions")
    code = [ast.dump(ast.parse(here.joinpath(f"{name}.py").read_text(encoding="utf-8"))) for name in names]
    data = json.dumps(family_data(), sort_keys=True)
    return hashlib.sha256("\0".join([data, *code]).encode()).hexdigest()


def is_current() -> bool:
    """Whether the shipped index was made from the design as it is."""
    return _stored().get("digest") == design_digest()


@lru_cache(maxsize=1)
def family_index() -> tuple[tuple[FamilyMember, Mapping[str, float]], ...]:
    """Every right last of the family with its dimensions, name -> mm (cm3)."""
    stored = _stored()
    if stored.get("format") != FORMAT:
        raise InputError("the built-in lasts' index is missing; install footscan again.")
    names, rows = stored["dimensions"], stored["values"]
    return tuple((m, dict(zip(names, rows[m.name], strict=True))) for m in family_members() if m.name in rows)


def stored_factors(member: FamilyMember) -> tuple[float, ...] | None:
    """The solved factors of a member of the index made from this very design; None for others."""
    found = _stored().get("factors", {}).get(member.name.removesuffix("-left"))
    return tuple(found) if found is not None else None


def member_of_id(last_id: str) -> FamilyMember | None:
    """The member of the family that an id names (any size, also one that is not listed), or None."""
    match = _NAME.fullmatch(last_id)
    if match is None:
        return None
    style, size, fitting, pitch, toe, left = match.groups()
    side: Side = "left" if left else "right"
    member = FamilyMember(style, float(size.replace("_", ".")), fitting, float(pitch), toe, side)
    try:
        check_member(member)
    except InputError:
        return None
    return member if member.name == last_id else None


def index_content(members: Mapping[FamilyMember, tuple[tuple[float, ...], Mapping[str, float]]]) -> dict[str, Any]:
    """The file's content from factors and dimensions of every member."""
    names = list(next(iter(members.values()))[1])
    return {
        "format": FORMAT,
        "digest": design_digest(),
        "dimensions": names,
        "values": {m.name: [round(found[name], 2) for name in names] for m, (_, found) in members.items()},
        "factors": {m.name: [round(value, 7) for value in factors] for m, (factors, _) in members.items()},
    }


def index_path() -> Path:
    """Where the index is written."""
    return Path(__file__).with_name("family_index.json")
