import json

import pytest
from typer.testing import CliRunner

from footscan.cli.main import app
from footscan.errors import InputError


def test_a_study_prints_its_tally_and_every_scan():
    done = CliRunner().invoke(app, ["study", "motion", "--scans", "2", "--seed", "11", "--frames", "60", "--json"])
    report = json.loads(done.stdout)

    assert done.exit_code == 0
    assert [row["calibration"] for row in report["tallies"]] == ["true", "off"]
    assert [(row["moved"], row["still"]) for row in report["tallies"]] == [(1, 1), (1, 1)]
    assert len(report["scans"]) == 4
    assert report["scans"][0]["move"] == "still"


def test_a_mesh_that_is_not_there_is_named(tmp_path):
    done = CliRunner().invoke(app, ["study", "motion", "--mesh", str(tmp_path / "nobody.stl")])

    assert isinstance(done.exception, InputError)
    assert "there is no mesh file" in str(done.exception)


@pytest.mark.parametrize("wrong", [["--scans", "1"], ["--frames", "10"]])
def test_impossible_studies_are_refused(wrong):
    assert CliRunner().invoke(app, ["study", "motion", *wrong]).exit_code == 2


def test_machines_are_calibrated_and_held_against_the_truth():
    done = CliRunner().invoke(app, ["study", "machines", "--points", "--count", "1", "--first", "3", "--json"])
    report = json.loads(done.stdout)

    assert done.exit_code == 0
    assert report["broken"] == []
    assert max(report["machines"][0]["rms_mm"].values()) < 0.05


def test_every_study_has_its_command():
    told = CliRunner().invoke(app, ["study", "--help"]).stdout

    assert all(f" {name} " in told for name in ("motion", "calibration", "machines", "drivers", "lasts"))
