"""What a file of somebody else's last holds: a mesh and named curves, in mm, as they lie in the file."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import trimesh

from footscan.coordinates import Floats
from footscan.shoelast.nurbs_out import NurbsPatch

LINE_WORDS = {
    "feather_edge": ("feather", "bottom edge", "sole edge"),
    "cone_edge": ("cone", "collar", "top edge"),
    "back_line": ("back", "heel curve", "heel line"),
    "ball_break_line": ("ball", "joint", "break"),
}
"""Words in the name of a curve or of its layer that say which line of a last it is; the first that fits counts."""

_TAPE = "tape"
_JOIN_MM = 0.5


@dataclass(frozen=True)
class LastSource:
    """A last as it lies in a file.

    Attributes:
        mesh: In mm, in the file's own heading; fragments, stub and all.
        lines: `feather_edge`, `cone_edge`, `back_line`, `ball_break_line` where the file names them, and other curves
            by their own names: `(n, 3)` mm polylines; a closed one ends where it begins.
        unit: Of the file, as it says itself, or as the caller said.
        remarks: What was left out or taken on trust.
        states_unit: The file says its unit itself.
        frame: 4x4 from the file to the frame of the real last (y to the left), where the file brings its datum.
        patches: Name -> untrimmed bicubic surface with unit weights, mm, as it lies in the file.
        bodies: Names and meshes (mm) of the mesh objects.
        said: What the file says of the last: style, size_eu, fitting; only those it says.
    """

    mesh: trimesh.Trimesh
    lines: Mapping[str, Floats] = field(default_factory=dict[str, Floats])
    unit: str = "mm"
    remarks: tuple[str, ...] = ()
    states_unit: bool = False
    frame: Floats | None = None
    patches: Mapping[str, NurbsPatch] = field(default_factory=dict[str, NurbsPatch])
    bodies: tuple[tuple[str, trimesh.Trimesh], ...] = ()
    said: Mapping[str, str] = field(default_factory=dict[str, str])


def line_name(*words: str) -> str | None:
    """The line of a last that some words (names of a curve, its layer) speak of, or None."""
    if words and words[0] in LINE_WORDS:
        return words[0]
    text = " ".join(words).lower().replace("_", " ").replace("-", " ")
    if _TAPE in text.split():
        return None
    return next((name for name, keys in LINE_WORDS.items() if any(key in text for key in keys)), None)


def joined_lines(pieces: Sequence[tuple[str, Floats]]) -> dict[str, Floats]:
    """Curves by name; pieces of one name whose ends meet within 0.5 mm become one line, the longest chain first.

    Args:
        pieces: Names and `(n, 3)` polylines (mm).

    Returns:
        Name -> `(n, 3)`; further chains of a name get `_2`, `_3` behind it.
    """
    names = list(dict.fromkeys(name for name, _ in pieces))
    lines: dict[str, Floats] = {}
    for name in names:
        chains = _chains([xyz for each, xyz in pieces if each == name])
        for number, chain in enumerate(chains, 1):
            lines[name if number == 1 else f"{name}_{number}"] = chain
    return lines


def _chains(pieces: list[Floats]) -> list[Floats]:
    left, chains = list(pieces), []
    while left:
        chain = left.pop(0)
        while (found := _next_piece(chain[-1], left)) is not None:
            chain = np.vstack([chain, found[1:]])
        while (found := _next_piece(chain[0], left)) is not None:
            chain = np.vstack([found[:0:-1], chain])
        chains.append(chain)
    return sorted(chains, key=_length, reverse=True)


def _next_piece(end: Floats, left: list[Floats]) -> Floats | None:
    """Take the piece that begins (perhaps turned round) at `end` out of `left`."""
    for k, piece in enumerate(left):
        for way in (piece, piece[::-1]):
            if np.linalg.norm(way[0] - end) <= _JOIN_MM:
                del left[k]
                return way
    return None


def _length(xyz: Floats) -> float:
    return float(np.linalg.norm(np.diff(xyz, axis=0), axis=1).sum())
