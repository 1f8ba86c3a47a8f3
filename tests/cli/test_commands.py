"""The commands as a person runs them: in a process of their own, judged by output, exit status and files."""

import json
import subprocess
import sys
from pathlib import Path

import pytest


def footscan(*arguments, check=None):
    done = subprocess.run(
        [sys.executable, "-m", "footscan.cli.main", *map(str, arguments)], capture_output=True, text=True, check=False
    )
    if check is not None:
        assert done.returncode == check, done.stderr
    return done


def test_process_prints_one_json_object_and_nothing_else(small_scan, tmp_path):
    done = footscan(
        "process",
        small_scan,
        "--calibration",
        small_scan / "truth-calibration.toml",
        "--out",
        tmp_path / "o",
        "--json",
        check=0,
    )

    assert json.loads(done.stdout)["frames"]["used"] == 96
    assert done.stderr == "" or "Compiling" in done.stderr
    assert {path.name for path in (tmp_path / "o").iterdir()} >= {"points.ply", "scan.json", "preview.png"}


def test_process_tells_a_person_what_came_out(small_scan, tmp_path):
    done = footscan(
        "process",
        small_scan,
        "--calibration",
        small_scan / "truth-calibration.toml",
        "--out",
        tmp_path / "o",
        "--threshold",
        "40",
        check=0,
    )

    assert "96 frames, 96 used; threshold 40" in done.stdout
    assert "right minus left" in done.stdout


@pytest.mark.parametrize(
    ("arguments", "status", "words"),
    [
        (["process", "nowhere", "--calibration", "CAL", "--out", "OUT"], 2, "nowhere is no folder"),
        (["process", "SCAN", "--calibration", "no.toml", "--out", "OUT"], 2, "no.toml does not exist"),
        (["process", "SCAN", "--calibration", "CAL", "--out", "OUT", "--threshold", "300"], 2, "0 to 255"),
        (
            ["process", "SCAN", "--calibration", "CAL", "--out", "OUT", "--filter-size", "7", "--filter", "median"],
            2,
            "3 and 5",
        ),
        (["process", "SCAN", "--calibration", "CAL", "--out", "OUT", "--threshold", "254"], 4, "no stripe was found"),
        (["process", "SCAN", "--calibration", "CAL", "--out", "/proc/nothing"], 2, "could not be written"),
        (["process", "SCAN"], 2, "Missing option"),
        (["info", "SCAN/frames.csv"], 2, "not valid TOML"),
        (["simulate", "foot", "SCAN"], 2, "nothing is overwritten"),
        (["simulate", "foot", "OUT", "--ideal", "--seed", "3"], 2, "contradict"),
        (["simulate", "nothing.stl", "OUT"], 2, "nothing.stl"),
        (["frobnicate"], 2, "No such command"),
    ],
)
def test_bad_input_ends_in_one_sentence_and_the_right_status(small_scan, tmp_path, arguments, status, words):
    places = {"SCAN": str(small_scan), "CAL": str(small_scan / "truth-calibration.toml"), "OUT": str(tmp_path / "o")}
    done = footscan(*[_placed(argument, places) for argument in arguments], check=status)

    assert words in " ".join(done.stderr.replace("│", " ").split())
    assert "Traceback" not in done.stderr
    assert done.stdout == ""
    assert not (tmp_path / "o/scan.json").exists()


def _placed(argument: str, places: dict[str, str]) -> str:
    head, slash, tail = argument.partition("/")
    return places.get(head, head) + slash + tail


def test_info_describes_every_kind_of_file(small_scan):
    recording = json.loads(footscan("info", small_scan, "--json", check=0).stdout)
    calibration = json.loads(footscan("info", small_scan / "truth-calibration.toml", "--json", check=0).stdout)
    scanner = footscan("info", small_scan / "scanner.toml", check=0).stdout

    assert recording["frames_per_laser"] == {"right": 48, "left": 48}
    assert recording["problems"] == []
    assert abs(calibration["lasers"]["right"]["alpha_deg"] - 45) < 1
    assert "a_mm: 6.39" in scanner


def test_simulate_writes_a_recording_that_info_finds_whole(tmp_path):
    footscan("simulate", "sphere", tmp_path / "s", "--ideal", "--frames", "8", check=0)
    content = json.loads(footscan("info", tmp_path / "s", "--json", check=0).stdout)

    assert content["frames"] == 16
    assert content["problems"] == []
    assert {path.name for path in Path(tmp_path / "s").iterdir()} >= {"truth-calibration.toml", "truth.stl"}
