"""The files of a customised last agree with each other, in real handedness."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from geomdl import exchange

from footscan.errors import InputError
from footscan.shoelast.customise import CustomSettings
from footscan.shoelast.family import build_shoelast
from footscan.shoelast.prepared_foot import prepare_foot
from footscan.sim.foot import FootShape, build_foot
from footscan.sim.surface import trimesh_from_surface
from footscan.workflow.lasts_fit import CUSTOM_FILES, save_custom
from footscan.workflow.lasts_pair import CustomPair, customise_pair, load_pair, save_pair


@pytest.fixture(scope="module")
def pair() -> CustomPair:
    """A left foot, and a right one half a size longer and a width fuller, each with a last of its own."""
    left, right = (
        prepare_foot(trimesh_from_surface(build_foot(shape)), shape.side)
        for shape in (FootShape("left", 1.0), FootShape("right", 1.015))
    )
    lasts = tuple(
        build_shoelast("therapeutic", size, fitting, 15.0, "round") for size, fitting in ((40.0, "h"), (40.5, "k"))
    )
    return customise_pair((lasts[0], lasts[1]), (left, right), "therapeutic", CustomSettings(transition_mm=20.0))


@pytest.fixture(scope="module")
def folders(pair: CustomPair, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    place = tmp_path_factory.mktemp("pair")
    save_pair(pair, place)
    return place / "left", place / "right"


def test_unlike_lasts_of_a_pair_keep_pitch_toe_and_cone_height_and_hold_both_feet(
    pair: CustomPair, folders: tuple[Path, Path]
):
    written = json.loads((folders[0].parent / "pair.json").read_text(encoding="utf-8"))
    cone = written["agreements"]["cone_height"]

    assert written["holds"] == {"left": True, "right": True}
    assert [written["lasts"][side]["fitting"] for side in ("left", "right")] == ["h", "k"]
    assert all(one["kept"] for one in written["agreements"].values())
    assert abs(cone["left"] - cone["right"]) < 0.1
    assert pair.cone_raised_mm[0] > 2.0
    assert pair.cone_raised_mm[1] == 0.0
    assert pair.right.dimensions["ball_girth"][1] > pair.left.dimensions["ball_girth"][1] + 5.0


def test_feet_given_the_wrong_way_round_are_refused(tmp_path: Path):
    for side in ("left", "right"):
        (tmp_path / side).mkdir()
        said = {"side": side, "subject": {"load": "unknown", "absent": []}}
        (tmp_path / side / "scan.json").write_text(json.dumps(said), encoding="utf-8")

    with pytest.raises(InputError, match="left foot first"):
        load_pair((tmp_path / "right", tmp_path / "left"), "mm")


def test_everything_promised_is_there(folders: tuple[Path, Path]):
    for folder in folders:
        assert all((folder / name).stat().st_size > 0 for name in CUSTOM_FILES)
        assert len(exchange.import_json(str(folder / "custom.json"))) == 3


def test_the_foot_below_the_top_line_lies_inside_the_written_mesh(folders: tuple[Path, Path]):
    for folder in folders:
        custom, foot = trimesh.load(folder / "custom.stl"), trimesh.load(folder / "foot_in_last.stl")
        proof = json.loads((folder / "proof.json").read_text(encoding="utf-8"))
        line = proof["top_line"]
        xyz = trimesh.sample.sample_surface(foot, 1500, seed=4)[0]
        below = (xyz - line["origin"]) @ np.array(line["normal"]) < 0.0
        floor = np.array([xyz[np.abs(xyz[:, 0] - x) < 8.0][:, 2].min() for x in xyz[:, 0]])
        judged = xyz[below & (xyz[:, 2] > floor + 12.0)]

        outside = -trimesh.proximity.signed_distance(custom, judged)

        assert custom.is_watertight
        assert len(judged) > 300
        assert outside.max() < 0.05
        assert proof["samples"] >= 100_000
        assert proof["worst_violation_mm"] <= 0.05


def test_a_left_last_leaves_as_the_mirror_of_the_same_right_one(
    pair: CustomPair, folders: tuple[Path, Path], tmp_path: Path
):
    save_custom(replace(pair.left, shoelast=replace(pair.left.shoelast, side="right")), tmp_path)
    left, right = (trimesh.load(folder / "custom.stl") for folder in (folders[0], tmp_path))

    assert np.sort(left.vertices * [1.0, -1.0, 1.0], axis=0) == pytest.approx(np.sort(right.vertices, axis=0), abs=1e-4)
    assert left.volume == pytest.approx(right.volume, rel=1e-6)
