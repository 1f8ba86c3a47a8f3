"""Write family_index.json: `python -m footscan.shoelast.make_family_index`.

Everything about a row of sizes (one style, width, heel and toe) is smooth in the size, so a row is solved at a few
sizes and interpolated; `tests/shoelast/test_library.py` compares members between them with lasts that are measured.
"""

import json
from collections.abc import Mapping

import numpy as np
from scipy.interpolate import BarycentricInterpolator

from footscan.config.toml_file import write_whole
from footscan.coordinates import Floats
from footscan.shoelast.dimensions import DEFINITIONS, dimensions
from footscan.shoelast.family import solve_member
from footscan.shoelast.family_data import FamilyMember, family_members
from footscan.shoelast.family_index import index_content, index_path

_KNOTS = 5
Row = tuple[str, str, float, str]


def make_family_index() -> None:
    """Solve every row of sizes at Chebyshev places, interpolate all members, write the index."""
    rows: dict[Row, list[FamilyMember]] = {}
    for member in family_members():
        rows.setdefault((member.style, member.fitting, member.pitch_mm, member.toe), []).append(member)
    found: dict[FamilyMember, tuple[tuple[float, ...], Mapping[str, float]]] = {}
    for row, members in rows.items():
        sizes, values = _solved_row(row, members)
        table = BarycentricInterpolator(sizes, values)(np.array([member.size_eu for member in members]))
        for member, line in zip(members, table, strict=True):
            numbers = [float(value) for value in line]
            found[member] = (tuple(numbers[:3]), dict(zip(DEFINITIONS, numbers[3:], strict=True)))
    ordered = {member: found[member] for member in family_members()}
    write_whole(index_path(), (json.dumps(index_content(ordered), indent=0) + "\n").encode())


def _solved_row(row: Row, members: list[FamilyMember]) -> tuple[Floats, Floats]:
    """Sizes `(k,)`, and factors and dimensions `(k, 3 + d)` at them."""
    low, high = members[0].size_eu, members[-1].size_eu
    places = 0.5 - 0.5 * np.cos(np.pi * (np.arange(_KNOTS) + 0.5) / _KNOTS)
    lines: list[Floats] = []
    style, fitting, pitch, toe = row
    start: Floats = np.ones(3)
    for size in low + (high - low) * places:
        shoelast, start = solve_member(FamilyMember(style, float(size), fitting, pitch, toe), start)
        lines.append(np.concatenate([start, [value.value for value in dimensions(shoelast).values()]]))
    return low + (high - low) * places, np.array(lines)


if __name__ == "__main__":
    make_family_index()
