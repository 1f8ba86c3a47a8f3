"""A shoelast: upper, bottom and cone top as NURBS that share their edges, with its named lines and points."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import trimesh

from footscan.coordinates import Floats, Side
from footscan.foot.nurbs import SplineTube
from footscan.shoelast.patches import ChordDisc


@dataclass(frozen=True)
class Attachment:
    """A separate body that came with a last and is no part of it: `kind` is stub (chuck) or toe_centre."""

    kind: str
    mesh: trimesh.Trimesh


@dataclass(frozen=True)
class Shoelast:
    """One last in its frame (see the package's docstring: y medial for both sides).

    Attributes:
        name: For people.
        side: Of the real last; in memory a left one is mirrored.
        upper: u round from the heel back (0) along the medial side to the toe (1/2) and back along the lateral side;
            v from the feather edge (0) to the cone edge (1).
        bottom: Between the halves of the feather edge.
        cone_top: Between the halves of the cone edge.
        style: men, women, therapeutic or a free word.
        size_eu: Paris points, None when nobody said.
        fitting: Width, as the maker writes it; may be empty.
        lines: Name -> `(n, 3)` polyline, such as feather_edge, cone_edge, back_line, ball_break_line.
        points: Name -> `(3,)`, such as tread_point, toe_point, seat_point, heel_point, ball_medial, ball_lateral,
            waist_point, instep_point, cone_front, cone_back.
        attachments: Stub and toe centre, left out of every dimension.
        remarks: What an import found and changed.
    """

    name: str
    side: Side
    upper: SplineTube
    bottom: ChordDisc
    cone_top: ChordDisc
    style: str = ""
    size_eu: float | None = None
    fitting: str = ""
    lines: Mapping[str, Floats] = field(default_factory=dict[str, Floats])
    points: Mapping[str, Floats] = field(default_factory=dict[str, Floats])
    attachments: tuple[Attachment, ...] = ()
    remarks: tuple[str, ...] = ()
