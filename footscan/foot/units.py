"""Units of a mesh file, and whether the size of what it holds can be a foot."""

from typing import Literal, get_args

from footscan.errors import MeshError

Unit = Literal["mm", "cm", "m", "in"]
UNITS: tuple[Unit, ...] = get_args(Unit)

_MM_PER_UNIT: dict[Unit, float] = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4}
_WORDS: dict[Unit, str] = {"mm": "millimetres", "cm": "centimetres", "m": "metres", "in": "inches"}

FOOT_LENGTH_MM = (80.0, 400.0)
"""What is accepted as the length of a foot, a toddler's as well as the largest known."""

_LIKELY_LENGTH_MM = (105.0, 345.0)
_USUAL_LENGTH_MM = 255.0


def mm_from_unit(unit: str) -> float:
    """Millimetres in one `unit` (mm, cm, m or in).

    Raises:
        MeshError: An unknown unit.
    """
    if unit not in UNITS:
        raise MeshError(f"unit {unit!r}: not known; allowed are {', '.join(UNITS)}")
    return _MM_PER_UNIT[unit]


def likely_units(length: float) -> tuple[Unit, ...]:
    """The units in which a number would be a foot's length, the one nearest to a usual length first; may be none."""
    lengths_mm: dict[Unit, float] = {unit: length * _MM_PER_UNIT[unit] for unit in UNITS}
    fitting: list[Unit] = [unit for unit in UNITS if _LIKELY_LENGTH_MM[0] <= lengths_mm[unit] <= _LIKELY_LENGTH_MM[1]]
    fitting.sort(key=lambda unit: abs(lengths_mm[unit] - _USUAL_LENGTH_MM))
    return tuple(fitting)


def check_foot_length(length_mm: float, unit: str = "mm") -> None:
    """Refuse a foot that is too long or too short, naming the unit it probably is in.

    Args:
        length_mm: Length (mm) after conversion from `unit`.
        unit: The unit the input was read in.

    Raises:
        MeshError: Outside `FOOT_LENGTH_MM`.
    """
    shortest, longest = FOOT_LENGTH_MM
    if shortest <= length_mm <= longest:
        return
    length = length_mm / mm_from_unit(unit)
    advice = " or ".join(
        f"in {_WORDS[guess]} ({length * _MM_PER_UNIT[guess]:.0f} mm)? pass --unit {guess}"
        for guess in likely_units(length)
    )
    advice = advice or "check the unit, or that the file holds one foot"
    raise MeshError(f"{length:.3g} {unit} long, a foot is {shortest:.0f} to {longest:.0f} mm: {advice}")
