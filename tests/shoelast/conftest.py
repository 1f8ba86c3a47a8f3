"""A small last that needs no generator."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from footscan.coordinates import Side
from footscan.foot.nurbs import SplineTube, clamped_knots
from footscan.shoelast.model import Attachment, Shoelast
from footscan.shoelast.patches import lower_edge, ruled_disc, upper_edge


def build_tub(side: Side = "right") -> Shoelast:
    """An oval tub, wider at its toe and fuller on its medial side, 250 x 90 x 80 mm, with a stub behind its heel."""
    turn = 2 * np.pi * np.arange(48) / 48
    rows = []
    for height, size in zip(np.linspace(0.0, 80.0, 11), np.linspace(1.0, 0.55, 11), strict=True):
        x = 125.0 * (1.0 - size * np.cos(turn))
        y = (40.0 + 0.04 * x + 4.0 * (np.sin(turn) > 0)) * size * np.sin(turn)
        rows.append(np.column_stack([x, y, np.full(48, height)]))
    upper = SplineTube(np.array(rows), clamped_knots(np.linspace(0.0, 1.0, 9)))
    breaks = np.linspace(0.0, 1.0, 5)
    bottom, top = ruled_disc(lower_edge(upper), breaks), ruled_disc(upper_edge(upper), breaks)
    u = np.linspace(0.0, 1.0, 241)
    lines = {
        "feather_edge": upper.grid(u, np.array([0.0]))[0],
        "cone_edge": upper.grid(u, np.array([1.0]))[0],
        "back_line": upper.grid(np.array([0.0]), np.linspace(0.0, 1.0, 61))[:, 0],
    }
    points = {"heel_point": lines["back_line"][0], "toe_point": lines["feather_edge"][120]}
    stub = trimesh.creation.box(extents=(20.0, 14.0, 14.0))
    stub.apply_translation([18.0, 0.0, 30.0])
    return Shoelast(
        "tub", side, upper, bottom, top, "men", 38.0, "G", lines, points, (Attachment("stub", stub),), ("a tub",)
    )


@pytest.fixture
def tub() -> Callable[[Side], Shoelast]:
    """The tub of either side."""
    return build_tub


@pytest.fixture
def bare_tub() -> Shoelast:
    """The right tub without its stub."""
    return replace(build_tub(), attachments=())
