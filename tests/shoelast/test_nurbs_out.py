"""Patches leave as clamped NURBS of the real last, the same surface to rounding, and come back."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from geomdl import exchange

from footscan.coordinates import Side
from footscan.errors import MeshError
from footscan.shoelast.handed import mirrored
from footscan.shoelast.model import Shoelast
from footscan.shoelast.nurbs_out import clamped_patches, load_last_json, save_last_json

Tub = Callable[[Side], Shoelast]
SIDES: tuple[Side, Side] = ("right", "left")


@pytest.mark.parametrize("side", SIDES)
def test_the_clamped_upper_is_the_periodic_one(tub: Tub, side: Side):
    shoelast, u, v = tub(side), np.linspace(0.0, 1.0, 257), np.linspace(0.0, 1.0, 33)

    upper = clamped_patches(shoelast)[0]

    around = 1.0 - u if side == "right" else u
    wanted = mirrored(shoelast.upper.grid(around, v), side)
    assert np.abs(upper.grid(u, v).transpose(1, 0, 2) - wanted).max() < 1e-11


@pytest.mark.parametrize("side", SIDES)
def test_every_normal_of_every_patch_looks_outward(tub: Tub, side: Side):
    centre = np.array([125.0, 0.0, 40.0])

    for patch in clamped_patches(tub(side)):
        step = np.linspace(0.05, 0.95, 23)
        xyz = patch.grid(step, step)
        normal = np.cross(np.gradient(xyz, axis=0), np.gradient(xyz, axis=1))

        assert np.all(((xyz - centre) * normal).sum(axis=-1) > 0)


@pytest.mark.parametrize("side", SIDES)
def test_json_comes_back_as_the_same_last(tub: Tub, side: Side, tmp_path: Path):
    shoelast = tub(side)

    save_last_json(shoelast, tmp_path / "custom.json")
    back = load_last_json(tmp_path / "custom.json")

    assert np.abs(back.upper.net_mm - shoelast.upper.net_mm).max() < 1e-10
    assert np.abs(back.bottom.net_mm - shoelast.bottom.net_mm).max() < 1e-12
    assert np.abs(back.cone_top.net_mm - shoelast.cone_top.net_mm).max() < 1e-12
    assert np.allclose(back.bottom.knots_t, shoelast.bottom.knots_t, atol=1e-15)
    assert (back.name, back.side, back.style, back.size_eu, back.fitting) == ("tub", side, "men", 38.0, "G")
    assert back.remarks == shoelast.remarks
    assert [part.kind for part in back.attachments] == ["stub"]
    assert np.allclose(back.attachments[0].mesh.vertices, shoelast.attachments[0].mesh.vertices)
    assert back.attachments[0].mesh.volume == pytest.approx(3920.0)
    for name, line in shoelast.lines.items():
        assert np.array_equal(back.lines[name], line)
    assert np.array_equal(back.points["toe_point"], shoelast.points["toe_point"])


def test_geomdl_reads_three_surfaces_of_the_left_last_where_they_are(tub: Tub, tmp_path: Path):
    shoelast = tub("left")

    save_last_json(shoelast, tmp_path / "custom.json")
    surfaces = exchange.import_json(str(tmp_path / "custom.json"))

    assert [surface.name for surface in surfaces] == ["upper", "bottom", "cone_top"]
    for surface, patch in zip(surfaces, clamped_patches(shoelast), strict=True):
        for u, v in ((0.0, 0.0), (0.31, 0.77), (0.5, 1.0), (1.0, 0.2)):
            assert np.allclose(
                surface.evaluate_single((u, v)), patch.grid(np.array([u]), np.array([v]))[0, 0], atol=1e-9
            )


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda d: d.update(format="footscan-measurements/1"), "allowed is 'footscan-last-surfaces/1'"),
        (lambda d: d.update(side="both"), "damaged"),
        (lambda d: d["shape"]["data"].pop(), "damaged"),
        (lambda d: d["shape"]["data"][0]["knotvector_u"].pop(), "do not fit"),
        (lambda d: d["lines"].update(feather_edge=[[0.0, float("nan"), 1.0]]), "finite"),
    ],
)
def test_a_damaged_file_is_refused_by_name(
    bare_tub: Shoelast, tmp_path: Path, change: Callable[[dict[str, object]], object], said: str
):
    path = tmp_path / "custom.json"
    save_last_json(bare_tub, path)
    document = json.loads(path.read_bytes())
    change(document)
    path.write_text(json.dumps(document))

    with pytest.raises(MeshError, match=said):
        load_last_json(path)


def test_a_missing_file_is_refused(tmp_path: Path):
    with pytest.raises(MeshError, match="cannot be read"):
        load_last_json(tmp_path / "custom.json")
