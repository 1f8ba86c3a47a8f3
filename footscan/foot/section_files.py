"""A stack of sections along the foot axis, and the texts that leave: CSV of its numbers, DXF of its outlines."""

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footscan.coordinates import Floats
from footscan.errors import MeshError
from footscan.foot.measurements import Measurements
from footscan.foot.sections import Section, measure_cut
from footscan.foot.shell import Shell


@dataclass(frozen=True)
class NamedSection:
    """One cut of a stack: its place as a share of the foot length from the heel, and what was measured there."""

    share: float
    section: Section


def plane_at_share(result: Measurements, share: float) -> tuple[Floats, Floats]:
    """Origin and unit normal `(3,)`, in the input's coordinates, of the plane across foot axis and sole.

    Args:
        result: A measured foot.
        share: 0 at the pternion, 1 at the longest toe.

    Raises:
        MeshError: Not between 0 and 1.
    """
    if not 0.0 <= share <= 1.0:
        raise MeshError(f"a section at {share:.0%} of the foot: allowed is 0 to 100 %, heel to toe")
    length = result["foot_length"].value or 0.0
    return result.frame.plane_to_input(np.array([share * length, 0.0, 0.0]), np.array([1.0, 0.0, 0.0]))


def cut_stack(shell: Shell, result: Measurements, shares: Sequence[float]) -> list[NamedSection]:
    """Cut a foot across its axis at some shares of its length; places where there is no skin are left out.

    Args:
        shell: The foot in the input's coordinates.
        result: Its measurements, which hold the axis.
        shares: From 0 (pternion) to 1 (longest toe).
    """
    stack: list[NamedSection] = []
    for share in shares:
        origin, normal = plane_at_share(result, share)
        distance = shell.xyz @ normal - float(origin @ normal)
        if distance.min() < 0.0 <= distance.max():
            stack.append(NamedSection(share, measure_cut(shell, origin, normal)))
    return stack


_COLUMNS = (
    "share_percent",
    "area_mm2",
    "perimeter_mm",
    "hull_perimeter_mm",
    "width_mm",
    "height_mm",
    "centroid_x_mm",
    "centroid_y_mm",
    "centroid_z_mm",
    "unseen_share",
    "hull_unseen_share",
)


def stack_csv(stack: Sequence[NamedSection]) -> str:
    """One row per section; the unseen shares are empty when the origin of the skin is unknown."""
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(_COLUMNS)
    for named in stack:
        cut = named.section
        numbers = [
            100.0 * named.share,
            cut.area_mm2,
            cut.perimeter_mm,
            cut.hull_perimeter_mm,
            cut.width_mm,
            cut.height_mm,
        ]
        shares = [cut.unseen_share, cut.hull_unseen_share]
        rows.writerow(
            [f"{x:.4f}" for x in (*numbers, *cut.centroid)]
            + ["" if share is None else f"{share:.4f}" for share in shares]
        )
    return text.getvalue()


def sections_dxf(stack: Sequence[NamedSection]) -> str:
    """The outlines as 3-D polylines of a DXF R12 drawing in mm, each section on a layer of its own
    (`SECTION_050_0`)."""
    lines = [
        "0",
        "SECTION",
        "2",
        "HEADER",
        "9",
        "$ACADVER",
        "1",
        "AC1009",
        "0",
        "ENDSEC",
        "0",
        "SECTION",
        "2",
        "ENTITIES",
    ]
    for named in stack:
        layer = f"SECTION_{100.0 * named.share:05.1f}".replace(".", "_")
        for polyline in named.section.polylines:
            lines += _dxf_polyline(polyline, layer)
    return "\n".join([*lines, "0", "ENDSEC", "0", "EOF", ""])


def _dxf_polyline(xyz: Floats, layer: str) -> list[str]:
    """A POLYLINE with flag 8 (3-D), and 1 (closed) when it ends where it begins; then the end is not repeated."""
    closed = len(xyz) > 2 and bool(np.allclose(xyz[0], xyz[-1], atol=1e-9))
    lines = ["0", "POLYLINE", "8", layer, "66", "1", "70", str(8 + closed), "10", "0.0", "20", "0.0", "30", "0.0"]
    for x, y, z in xyz[:-1] if closed else xyz:
        lines += ["0", "VERTEX", "8", layer, "10", f"{x:.6f}", "20", f"{y:.6f}", "30", f"{z:.6f}", "70", "32"]
    return [*lines, "0", "SEQEND", "8", layer]
