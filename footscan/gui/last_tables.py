"""Tables of the Last tab: ranking, room by region, girths, proof, dimensions before and after."""

from __future__ import annotations

import html
from collections.abc import Sequence
from typing import TYPE_CHECKING

from footscan.gui import texts

if TYPE_CHECKING:
    from footscan.shoelast.compare import Comparison
    from footscan.shoelast.custom_last import CustomLast
    from footscan.shoelast.rank import Ranked

_SHOWN_DIMENSIONS = (
    "stick_length", "ball_girth", "waist_girth", "instep_girth", "short_heel_girth", "ball_width", "heel_width",
    "pitch", "toe_spring", "toe_box_height",
)  # fmt: skip
_STYLE = 'style="width:100%;text-align:left;font-size:12.5px"'


def _table(head: str, rows: Sequence[Sequence[str]]) -> str:
    body = "".join("<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table {_STYLE}>{head}{body}</table>"


def ranking_table(ranking: Sequence[Ranked], chosen: str) -> str:
    """The best lasts, with what differs from the foot."""
    rows = [
        (
            "▸" if one.entry.id == chosen else "",
            one.entry.name,
            f"{one.score:.1f}",
            *(_signed(one.differences_mm.get(part)) for part in ("ball_length", "ball_girth", "length_room")),
        )
        for one in ranking
    ]
    return _table(texts.LAST_RANKING_HEAD, rows) + f"<div>{texts.LAST_RANKING_NOTE}</div>" if rows else ""


def _signed(value: float | None) -> str:
    return "-" if value is None else f"{value:+.1f}"


def room_tables(found: Comparison, name_of_last: str) -> str:
    """Room by region and girths in the same planes."""
    regions = [
        (
            name,
            *(f"{value:.1f}" for value in (room.min_mm, room.p5_mm, room.mean_mm, room.p95_mm)),
            f"{room.tight_share:.0%}",
            f"{room.loose_share:.0%}",
        )
        for name, room in found.regions.items()
    ]
    girths = [
        (name.removesuffix("_girth").replace("_", " "), f"{one.foot_mm:.1f}", f"{one.last_mm:.1f}",
         f"{one.last_mm - one.foot_mm:+.1f}")
        for name, one in found.girths.items()
    ]  # fmt: skip
    remarks = "".join(f"<div>{html.escape(remark)}</div>" for remark in found.remarks)
    return (
        texts.LAST_ROOM.format(name=html.escape(name_of_last))
        + _table(texts.LAST_REGION_HEAD, regions)
        + f"<div>{texts.LAST_REGION_NOTE}</div>"
        + _table(texts.LAST_GIRTH_HEAD, girths)
        + remarks
    )


def proof_words(custom: CustomLast) -> str:
    """Whether the last holds the foot, what was not met, dimensions before and after."""
    proof = custom.proof
    verdict = texts.LAST_HOLDS if proof.holds else texts.LAST_HOLDS_NOT
    words = texts.LAST_PROOF.format(samples=f"{proof.samples:,}", worst=max(proof.worst_violation_mm, 0.0))
    unmet = "".join(f"<div>{html.escape(texts.LAST_UNMET.format(what=what))}</div>" for what in custom.unmet)
    rows = [
        (name.replace("_", " "), f"{before:.1f} {unit}", f"{after:.1f} {unit}")
        for name, (before, after, unit) in custom.dimensions.items()
        if name in _SHOWN_DIMENSIONS
    ]
    return f"{verdict}<div>{words}</div>{unmet}" + _table(texts.LAST_DIMENSION_HEAD, rows)
