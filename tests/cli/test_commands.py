"""The commands as a person runs them, judged by output, exit status and files."""

import io
import json
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path

import pytest

from footscan.cli.main import run
from footscan.config import load_recording_info

FOOT_FILES = {"surface.stl", "surface.ply", "surface.json", "measurements.json", "report.png"}


@dataclass(frozen=True)
class Done:
    """What a person at the terminal has in hand."""

    returncode: int
    stdout: str
    stderr: str


def footscan(*arguments, check=None):
    """The program in this process, from its arguments to its exit: starting Python anew costs seconds each time."""
    out, err = io.StringIO(), io.StringIO()
    before, sys.argv = sys.argv, ["footscan", *map(str, arguments)]
    try:
        with redirect_stdout(out), redirect_stderr(err), pytest.raises(SystemExit) as end:
            run()
    finally:
        sys.argv = before
    done = Done(end.value.code or 0, out.getvalue(), err.getvalue())
    if check is not None:
        assert done.returncode == check, done.stderr
    return done


def footscan_alone(*arguments):
    """The program in a process of its own: whatever any library prints is seen."""
    command = [sys.executable, "-m", "footscan.cli.main", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def process_scan(scan, out, *more):
    calibration = scan / "truth-calibration.toml"
    return footscan("process", scan, "--calibration", calibration, "--out", out, *more, check=0)


def test_process_prints_one_json_object_and_nothing_else(small_scan, tmp_path):
    calibration = small_scan / "truth-calibration.toml"
    done = footscan_alone("process", small_scan, "--calibration", calibration, "--out", tmp_path / "o", "--json")

    assert done.returncode == 0
    assert json.loads(done.stdout)["frames"]["used"] == 96
    assert done.stderr == "" or "Compiling" in done.stderr
    assert {path.name for path in (tmp_path / "o").iterdir()} >= {"points.ply", "scan.json", "preview.png", *FOOT_FILES}


def test_process_tells_a_person_what_came_out(small_scan, tmp_path):
    done = process_scan(small_scan, tmp_path / "o", "--threshold", "40")

    assert "96 frames, 96 used; threshold 40" in done.stdout
    assert "% assumed sole" in done.stdout
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
        (["simulate", "giraffe", "OUT"], 2, "there is no object 'giraffe'; give foot, sphere"),
        (["simulate", "foot", "OUT", "--diameter", "30"], 2, "--diameter means nothing for OBJECT foot; it belongs to"),
        (
            ["simulate", "sphere", "OUT", "--size", "0.8"],
            2,
            "--size means nothing for OBJECT sphere; it belongs to foot",
        ),
        (
            ["simulate", "foot", "OUT", "--arch", "3"],
            2,
            "the arch of the built-in foot goes from 0 (flat) to 1.5 (high)",
        ),
        (["simulate", "foot", "OUT", "--hallux-valgus", "nan"], 2, "leans 0 to 28 degrees, found nan"),
        (["simulate", "foot", "OUT", "--missing-toe", "6"], 2, "toes have the numbers 1 (big toe) to 5"),
        (["simulate", "plane", "OUT", "--bow", "2"], 2, "--bow means nothing for OBJECT plane; it belongs to board"),
        (["simulate", "board", "OUT", "--frames", "9"], 2, "--frames means nothing for OBJECT board"),
        (["scan", "--side", "up"], 2, "`footscan scan --help` lists what is allowed"),
        (["bench", "session", "--rate", "0"], 2, "--rate"),
        (["study", "drivers", "--baud", "300"], 2, "300 is not studied; choose from 115200, 9600, adam4055"),
        (["frobnicate"], 2, "No such command"),
    ],
)
def test_bad_input_ends_in_one_sentence_and_the_right_status(small_scan, tmp_path, arguments, status, words):
    places = {"SCAN": str(small_scan), "CAL": str(small_scan / "truth-calibration.toml"), "OUT": str(tmp_path / "o")}
    done = footscan(*[_placed(argument, places) for argument in arguments], check=status)

    assert words in " ".join(done.stderr.replace("│", " ").split())
    assert len(done.stderr.strip().splitlines()) == 1
    assert done.stdout == ""
    assert not (tmp_path / "o/scan.json").exists()


def test_a_process_of_its_own_ends_with_the_same_sentence_and_status():
    done = footscan_alone("simulate", "giraffe", "nowhere")

    assert done.returncode == 2
    assert done.stderr.startswith("footscan: there is no object 'giraffe'")
    assert done.stdout == ""


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


def test_a_simulated_amputation_is_named_in_the_recording(tmp_path):
    toes = ("--missing-toe", "5", "--missing-toe", "2", "--arch", "0", "--hallux-valgus", "20")
    footscan("simulate", "foot", tmp_path / "s", "--frames", "8", *toes, check=0)

    assert load_recording_info(tmp_path / "s/recording.toml").subject.absent == ("toe_2", "toe_5")


@pytest.fixture(scope="module")
def processed(small_scan, tmp_path_factory):
    out = tmp_path_factory.mktemp("processed") / "o"
    process_scan(small_scan, out)
    return out


def test_a_processed_folder_is_measured_with_its_side_and_what_was_seen(processed):
    stored = json.loads((processed / "measurements.json").read_text())
    again = json.loads(footscan("measure", processed, "--json", check=0).stdout)
    bare = json.loads(footscan("measure", processed / "surface.stl", "--side", "left", "--json", check=0).stdout)

    assert stored["format"] == "footscan-measurements/1"
    assert again["side"] == stored["side"] == "left"
    assert again["origin_of_skin"] == "known"
    assert bare["origin_of_skin"] == "unknown"
    for name, value in stored["measurements"].items():
        if value["value"] is not None:
            assert again["measurements"][name]["value"] == pytest.approx(value["value"], abs=0.02), name
    assert 200 < stored["measurements"]["foot_length"]["value"] < 300


def test_a_section_gives_the_contract_values(processed):
    cut = json.loads(
        footscan("section", processed, "--origin", "0,0,30", "--normal", "0,0,1", "--json", check=0).stdout
    )

    assert {"area_mm2", "perimeter_mm", "hull_perimeter_mm", "width_mm", "height_mm", "unseen_share"} <= cut.keys()
    assert cut["perimeter_mm"] >= cut["hull_perimeter_mm"] - 1e-6
    assert 0.0 <= cut["unseen_share"] <= 1.0
    assert cut["closed"]


def test_a_bare_stl_is_cut_like_the_folder_it_comes_from(processed):
    plane = ("--origin", "0,0,30", "--normal", "0,0,1", "--json")
    folder = json.loads(footscan("section", processed, *plane, check=0).stdout)
    bare = json.loads(footscan("section", processed / "surface.stl", *plane, check=0).stdout)

    assert bare["closed"]
    assert bare["curves"] == folder["curves"]
    assert bare["area_mm2"] == pytest.approx(folder["area_mm2"], rel=1e-4)
    assert bare["hull_perimeter_mm"] == pytest.approx(folder["hull_perimeter_mm"], rel=1e-4)
    assert bare["unseen_share"] is None


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["section", "OUT", "--origin", "0,0", "--normal", "0,0,1"], "three numbers"),
        (["section", "OUT", "--origin", "0,0,999", "--normal", "0,0,1"], "does not meet the foot"),
        (["section", "OUT", "--origin", "0,0,50", "--normal", "0,0,0"], "normal"),
        (["measure", "OUT/surface.stl", "--unit", "m"], "foot is 80 to 400 mm"),
        (["measure", "OUT/scan.json"], "not read"),
        (["measure", "nothing.stl"], "not there"),
    ],
)
def test_bad_sections_and_meshes_end_in_one_sentence(processed, arguments, words):
    done = footscan(*[_placed(argument, {"OUT": str(processed)}) for argument in arguments], check=2)

    assert words in " ".join(done.stderr.replace("│", " ").split())
    assert "Traceback" not in done.stderr


def test_what_is_no_foot_keeps_its_points_and_says_why(tmp_path):
    footscan("simulate", "sphere", tmp_path / "s", "--ideal", "--frames", "48", check=0)
    calibration = tmp_path / "s/truth-calibration.toml"
    done = footscan("process", tmp_path / "s", "--calibration", calibration, "--out", tmp_path / "o")

    assert done.returncode in (2, 4)
    assert "Traceback" not in done.stderr
    assert (tmp_path / "o/points.ply").is_file()
    assert json.loads((tmp_path / "o/scan.json").read_text())["foot"]["refused"] in done.stderr.replace(
        "footscan: ", ""
    )
