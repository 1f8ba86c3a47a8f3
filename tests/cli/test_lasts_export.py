"""`footscan lasts export` writes what was asked, says it in JSON, and refuses in one sentence."""

import json
from pathlib import Path

import pytest
import trimesh
from typer.testing import CliRunner

from footscan.cli.main import app
from footscan.errors import FootscanError, InputError
from footscan.shoelast.family import build_shoelast
from footscan.shoelast.nurbs_out import save_last_json

LAST = "women-eu37-g-30mm-round"


def _export(*words: str) -> tuple[int, str, BaseException | None]:
    result = CliRunner().invoke(app, ["lasts", "export", *words])
    return result.exit_code, result.stdout, result.exception


def test_a_built_in_last_leaves_with_its_stub(tmp_path: Path):
    path = tmp_path / "last.stl"

    status, said, _ = _export(LAST, "--out", str(path), "--stub", "--json", "--data", str(tmp_path / "data"))

    content = json.loads(said)
    mesh = trimesh.load(path, force="mesh")
    assert status == 0
    assert content["files"] == [str(path)]
    assert "triangles" in content["found"][0]
    assert mesh.is_watertight
    assert mesh.bounds[0, 0] < -10.0


def test_a_folder_of_customise_leaves_in_the_format_that_is_named(tmp_path: Path):
    folder = tmp_path / "made"
    folder.mkdir()
    save_last_json(build_shoelast("women", 37, "g", 30.0, "round", "left"), folder / "custom.json")

    status, said, _ = _export(
        str(folder), "--out", str(tmp_path / "last.x"), "--format", "3dm", "--data", str(tmp_path)
    )

    assert status == 0
    assert (tmp_path / "last.3dm").is_file()
    assert "three NURBS surfaces" in said


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["women-eu99-g-30mm-round", "--out", "last.stl"], "women-eu99"),
        ([LAST, "--out", "last.docx"], "allowed are stl"),
        ([LAST, "--out", "last.step", "--engrave", "A17"], "cannot hold an engraved text"),
        (["NOWHERE", "--out", "last.stl"], "custom.json"),
    ],
)
def test_wrong_use_is_refused_in_one_sentence(words: list[str], said: str, tmp_path: Path):
    (tmp_path / "empty").mkdir()
    words = [str(tmp_path / "empty") if word == "NOWHERE" else word for word in words]

    status, _, refusal = _export(*words[:2], str(tmp_path / words[2]), *words[3:], "--data", str(tmp_path / "data"))

    assert status != 0
    assert isinstance(refusal, FootscanError)
    assert refusal.exit_status == InputError.exit_status == 2
    assert said in str(refusal)
    assert "\n" not in str(refusal)


@pytest.mark.parametrize("side", ["right", "left"])
def test_a_last_that_left_as_3dm_is_added_as_it_was(side: str, tmp_path: Path):
    data, last = str(tmp_path / "data"), LAST if side == "right" else f"{LAST}-left"
    _export(last, "--out", str(tmp_path / "last.3dm"), "--stub", "--data", data)

    added, shown = (
        json.loads(CliRunner().invoke(app, ["lasts", *words, "--json", "--data", data]).stdout)
        for words in (("add", str(tmp_path / "last.3dm"), "--side", side), ("show", last))
    )

    assert added["dimensions"] == pytest.approx(shown["dimensions"], abs=0.01)
    assert (added["style"], added["size_eu"], added["fitting"]) == ("women", 37.0, "g")
