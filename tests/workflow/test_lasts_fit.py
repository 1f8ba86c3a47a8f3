"""The files of a customised last agree with each other, in real handedness."""

import json
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
from footscan.workflow.lasts_fit import CUSTOM_FILES, customise_pair, load_pair, save_custom


@pytest.fixture(scope="module")
def folders(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    left, right = (
        prepare_foot(trimesh_from_surface(build_foot(FootShape(side, 1.0))), side) for side in ("left", "right")
    )
    shoelast = build_shoelast("therapeutic", 40.0, "h", 15.0, "round")
    pair = customise_pair(shoelast, (left, right), "therapeutic", CustomSettings(transition_mm=20.0))
    place = tmp_path_factory.mktemp("pair")
    for custom, name in zip(pair, ("left", "right"), strict=True):
        save_custom(custom, place / name)
    return place / "left", place / "right"


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


def test_a_left_last_leaves_as_the_mirror_of_the_right_one(folders: tuple[Path, Path]):
    left, right = (trimesh.load(folder / "custom.stl") for folder in folders)

    turned = left.bounds * np.array([1.0, -1.0, 1.0])

    assert np.abs(np.sort(turned, axis=0) - right.bounds).max() < 0.5
    assert left.volume > 0
