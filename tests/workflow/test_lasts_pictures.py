"""Pictures of lasts show the real side in fixed colours."""

import io
from pathlib import Path

import numpy as np
import pytest
from matplotlib import image

from footscan.foot.nurbs import SplineTube, clamped_knots
from footscan.shoelast.handed import mirrored
from footscan.shoelast.model import Shoelast
from footscan.shoelast.patches import lower_edge, ruled_disc, upper_edge
from footscan.shoelast.skin import Sampling, skin_of
from footscan.workflow.lasts_colours import CHANGED, CLEARANCE_MM, UNSEEN, change_colours, clearance_colours
from footscan.workflow.lasts_pictures import (
    save_changed_picture,
    save_clearance_map,
    save_plan_picture,
    thumbnail_png,
)
from footscan.workflow.lasts_views import silhouette, view_axes


@pytest.fixture
def shoelast() -> Shoelast:
    """A left tub, wider at its toe, fuller medially."""
    turn = 2 * np.pi * np.arange(24) / 24
    rows = []
    for height, size in zip(np.linspace(0.0, 70.0, 7), np.linspace(1.0, 0.6, 7), strict=True):
        x = 120.0 * (1.0 - size * np.cos(turn))
        y = (36.0 + 0.04 * x + 8.0 * (np.sin(turn) > 0)) * size * np.sin(turn)
        rows.append(np.column_stack([x, y, np.full(24, height)]))
    upper = SplineTube(np.array(rows), clamped_knots(np.linspace(0.0, 1.0, 5)))
    breaks = np.linspace(0.0, 1.0, 4)
    discs = ruled_disc(lower_edge(upper), breaks), ruled_disc(upper_edge(upper), breaks)
    return Shoelast("tub", "left", upper, *discs)


def test_clearance_is_red_where_tight_white_at_the_target_blue_where_loose_and_grey_where_unseen():
    rgb = clearance_colours(np.array([-20.0, -6.0, -3.0, 1.6, 2.0, 2.4, 6.0, 10.0, 40.0, np.nan]), target_mm=2.0)

    assert np.array_equal(rgb[0], rgb[1]), "beyond the scale the end colour stays"
    assert np.array_equal(rgb[7], rgb[8])
    assert np.all(rgb[3:6] == 255)
    assert np.all(rgb[:3, 0].astype(int) > rgb[:3, 2])
    assert np.all(rgb[6:9, 2].astype(int) > rgb[6:9, 0])
    assert tuple(rgb[9]) == UNSEEN


def test_clearance_colours_change_steadily():
    rgb = clearance_colours(np.linspace(*CLEARANCE_MM, 801)).astype(int)

    step = np.abs(np.diff(rgb, axis=0)).sum(axis=1)
    inside = np.abs(np.linspace(*CLEARANCE_MM, 801)[1:]) > 0.55
    assert step[inside].max() <= 12


def test_what_moved_is_pale_grey_whichever_way():
    rgb = change_colours(np.array([0.0, 0.009, -0.02, 3.0]))

    assert [tuple(row) == CHANGED for row in rgb] == [False, False, True, True]


@pytest.mark.parametrize("side", ["right", "left"])
@pytest.mark.parametrize("view", ["above", "below", "medial", "lateral", "front", "back"])
def test_every_view_is_a_turn_and_no_mirror(view: str, side: str):
    axes = view_axes(view, side)

    assert np.allclose(axes @ axes.T, np.eye(3))
    assert np.linalg.det(axes) == pytest.approx(1.0)


def test_the_medial_view_looks_from_the_medial_side():
    right, left = view_axes("medial", "right"), view_axes("medial", "left")

    assert np.allclose(right[2], [0, 1, 0]), "y to the left is medial of a right foot"
    assert np.allclose(left[2], [0, -1, 0])


def test_a_silhouette_has_the_area_of_the_body(shoelast: Shoelast):
    skin = skin_of(shoelast, Sampling(120, 20, 8))
    inside, extent = silhouette(mirrored(skin.xyz_shoelast, "left"), skin.faces, "above", "left", 0.4)

    pattern = shoelast.upper.grid(np.arange(720) / 720, np.zeros(1))[0, :, :2]
    area = 0.5 * abs(np.sum(pattern[:, 0] * np.roll(pattern[:, 1], -1) - pattern[:, 1] * np.roll(pattern[:, 0], -1)))
    assert inside.sum() * 0.16 == pytest.approx(area, rel=0.01)
    assert extent[1] - extent[0] == pytest.approx(inside.shape[1] * 0.4)


def _share(picture: np.ndarray, colour: tuple[int, int, int], near: float = 0.12) -> float:
    """Share of the picture's pixels of about the hue of a colour, at any brightness above half."""
    wanted = np.array(colour) / np.linalg.norm(colour)
    length = np.linalg.norm(picture, axis=-1)
    return float(
        (
            (np.linalg.norm(picture / np.maximum(length, 1e-6)[..., None] - wanted, axis=-1) < near) & (length < 1.69)
        ).mean()
    )


def test_pictures_of_a_foot_in_a_last_are_written(shoelast: Shoelast, tmp_path: Path):
    skin = skin_of(shoelast, Sampling(80, 20, 8))
    foot, seen = skin.xyz_shoelast * 0.97, skin.xyz_shoelast[:, 2] > 5.0
    clearance = np.where(seen, -5.0, np.nan)

    save_plan_picture(tmp_path / "plan.png", shoelast, foot, skin.faces, "tub")
    save_clearance_map(tmp_path / "clearance.png", foot, skin.faces, clearance, "left", "tub")
    save_changed_picture(tmp_path / "changed.png", skin, np.where(seen, 0.0, 2.0), "left", "tub")

    pictures = {name: image.imread(tmp_path / f"{name}.png")[..., :3] for name in ("plan", "clearance", "changed")}
    red = clearance_colours(np.array([-5.0]))[0]
    assert _share(pictures["clearance"], tuple(red)) > 0.1
    assert _share(pictures["clearance"], UNSEEN) > 0.02
    assert _share(pictures["changed"], CHANGED) > 0.02
    assert pictures["plan"].std() > 0.05


def test_a_thumbnail_is_small_and_full(shoelast: Shoelast):
    picture = image.imread(io.BytesIO(thumbnail_png(shoelast)))[..., :3]

    assert picture.shape == (220, 240, 3)
    assert (picture.mean(axis=-1) < 0.95).mean() > 0.3
