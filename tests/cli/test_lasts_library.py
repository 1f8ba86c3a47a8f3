"""`footscan lasts add | list | show | grade | mirror` on a folder of their own."""

import json
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from footscan.cli.main import app
from footscan.errors import FootscanError
from footscan.shoelast.family import build_shoelast
from footscan.shoelast.skin import Sampling, skin_of


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A data folder with one imported last, id `derby`."""
    folder = tmp_path_factory.mktemp("library")
    file = folder / "derby.stl"
    skin_of(build_shoelast("men", 42, "g", 25.0), Sampling(240, 90, 24)).mesh().export(file)
    said = _json(folder, "add", str(file), "--unit", "mm", "--side", "right", "--size", "42", "--fitting", "g")
    assert said["id"] == "derby"
    return folder


def _run(folder: Path, *words: str) -> tuple[int, str, BaseException | None]:
    result = CliRunner().invoke(app, ["lasts", *words, "--data", str(folder)])
    return result.exit_code, result.stdout, result.exception


def _json(folder: Path, *words: str) -> Any:
    status, said, refusal = _run(folder, *words, "--json")
    assert status == 0, refusal
    return json.loads(said)


def test_an_added_last_is_listed_with_its_dimensions(library: Path):
    listed = _json(library, "list", "--own")["lasts"]

    derby = next(one for one in listed if one["id"] == "derby")
    assert derby["side"] == "right"
    assert derby["dimensions"]["ball_girth"] == pytest.approx(246.0, abs=0.5)
    assert derby["dimensions"]["long_heel_girth"] > derby["dimensions"]["short_heel_girth"]


def test_the_list_counts_own_and_built_in_lasts(library: Path):
    status, said, _ = _run(library, "list", "--side", "right", "--style", "women")

    assert status == 0
    assert "0 of your own" in said.splitlines()[-1]
    assert len(said.splitlines()) > 100


def test_show_says_definitions_and_versions(library: Path):
    status, said, _ = _run(library, "show", "derby")

    assert status == 0
    assert "tape round the upright plane through both ball points" in said
    assert said.splitlines()[-1] == "Versions: 1"


def test_a_grade_is_a_last_of_its_own_a_paris_point_longer(library: Path):
    before = _json(library, "show", "derby")

    graded = _json(library, "grade", "derby", "--size", "43")

    assert graded["id"] != "derby"
    assert graded["size_eu"] == 43
    longer = graded["dimensions"]["stick_length"] - before["dimensions"]["stick_length"]
    assert longer == pytest.approx(20.0 / 3.0, abs=0.3)
    assert graded["dimensions"]["pitch"] == pytest.approx(before["dimensions"]["pitch"], abs=0.3)


def test_a_mirrored_last_is_of_the_other_side(library: Path):
    mirrored = _json(library, "mirror", "derby")

    assert mirrored["side"] == "left"
    assert mirrored["dimensions"] == _json(library, "show", "derby")["dimensions"]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["show", "derbi"], "derby"),
        (["grade", "derby", "--size", "50"], "at most 4 of each"),
        (["add", "NOWHERE.stl", "--unit", "mm", "--side", "right"], "NOWHERE.stl"),
    ],
)
def test_wrong_use_is_refused_in_one_sentence(library: Path, words: list[str], said: str):
    status, _, refusal = _run(library, *words)

    assert status != 0
    assert isinstance(refusal, FootscanError)
    assert said in str(refusal)
    assert "\n" not in str(refusal)
