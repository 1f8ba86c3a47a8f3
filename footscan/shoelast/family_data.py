"""The built-in family's numbers: the size and width table, the shapes and the toes, all in family.json."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files
from typing import Any

from footscan.coordinates import Side
from footscan.errors import InputError

GIRTHS = ("ball_girth", "instep_girth")
"""The girths of the size and width table, which every built-in last meets."""


@dataclass(frozen=True)
class FamilyMember:
    """What names one last of the family: style, Paris points, width, heel, toe and side."""

    style: str
    size_eu: float
    fitting: str
    pitch_mm: float
    toe: str
    side: Side = "right"

    @property
    def name(self) -> str:
        """Stable name and id in a library, such as `men-eu42-g-12mm-round`; a left one ends in `-left`."""
        size = f"{self.size_eu:g}".replace(".", "_")
        tail = "" if self.side == "right" else "-left"
        return f"{self.style}-eu{size}-{self.fitting}-{self.pitch_mm:g}mm-{self.toe}{tail}"


@lru_cache(maxsize=1)
def family_data() -> Mapping[str, Any]:
    """The content of family.json."""
    return json.loads(files("footscan.shoelast").joinpath("family.json").read_text(encoding="utf-8"))


def check_member(member: FamilyMember) -> None:
    """Refuse what the family does not have.

    Raises:
        InputError: Naming what was asked for and what is allowed.
    """
    data = family_data()
    _one_of("style", member.style, tuple(data["styles"]))
    style = data["styles"][member.style]
    _one_of("fitting", member.fitting, tuple(style["fittings"]))
    _one_of("toe", member.toe, tuple(data["toes"]))
    _one_of("side", member.side, ("right", "left"))
    _between("size", member.size_eu, data["sizes_eu"], "EU")
    _between("pitch", member.pitch_mm, data["pitches_mm"], "mm")


def family_members() -> Iterator[FamilyMember]:
    """All right lasts of the family, half sizes too, in a fixed order."""
    for name, style in family_data()["styles"].items():
        low, high = style["sizes_eu"]
        sizes = [low + 0.5 * k for k in range(round(2 * (high - low)) + 1)]
        for size in sizes:
            for fitting in style["fittings"]:
                for pitch in style["pitches_mm"]:
                    for toe in style["toes"]:
                        yield FamilyMember(name, size, fitting, pitch, toe)


def nominal_girths_mm(style: str, size_eu: float, fitting: str) -> dict[str, float]:
    """The table: name -> girth (mm) of a style's size and width. Indicative."""
    table = family_data()["styles"][style]
    sizes = size_eu - table["reference_eu"]
    widths = table["fittings"].index(fitting) - table["fittings"].index(table["reference_fitting"])
    return {
        name: table["girths_mm"][name] + sizes * table["per_size_mm"][name] + widths * table["per_fitting_mm"][name]
        for name in GIRTHS
    }


def nominal_stick_mm(member: FamilyMember) -> float:
    """Stick length at the reference pitch: Paris points, and what the toe adds for looks."""
    data = family_data()
    return member.size_eu * data["paris_point_mm"] + data["toes"][member.toe]["extra_mm"]


def _one_of(what: str, value: str, allowed: tuple[str, ...]) -> None:
    if value not in allowed:
        raise InputError(f"{what} {value!r}: the built-in family has {', '.join(allowed)}")


def _between(what: str, value: float, limits: tuple[float, float], unit: str) -> None:
    if not limits[0] <= value <= limits[1]:
        raise InputError(f"{what} {value:g} {unit}: the built-in family has {limits[0]:g} to {limits[1]:g} {unit}")
