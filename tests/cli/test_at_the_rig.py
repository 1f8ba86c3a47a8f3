"""The technician's commands at a machine: `--rig`, on the simulated one, hurried and with few pictures."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from footscan.cli import calibration as calibration_commands
from footscan.cli.calibrate_rig import GuidedChoices, record_one_placement
from footscan.cli.main import app
from footscan.config.rig_file import Rig
from footscan.errors import InterlockError
from footscan.scanning.recording import open_recording
from footscan.scanning.verify import verify_recording
from footscan.workflow.designs import builtin_config

runner = CliRunner()


@pytest.fixture(scope="module")
def rig(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("rig") / "sim.toml"
    words = builtin_config("sim").read_text()
    path.write_text(words.replace("frames_per_s = 25.0", "frames_per_s = 8.0").replace("_step = 1.5", "_step = 6.0"))
    return path


def test_the_daily_check_scans_the_test_body_itself_and_holds_it_against_the_first(rig: Path, tmp_path: Path):
    data = ["--data", str(tmp_path / "data")]
    truth = str(tmp_path / "body-1" / "calibration.toml")
    command = ["calibration", "daily", str(tmp_path / "body-1"), "--rig", str(rig), "--fast", *data]
    none = runner.invoke(app, [*command, "--yes"])
    assert "no calibration in force" in str(none.exception)
    made = runner.invoke(app, ["simulate", "ball-bar", str(tmp_path / "body-0"), "--seed", "1", "--frames", "8"])
    assert made.exit_code == 0, made.output
    given = ["--calibration", str(tmp_path / "body-0" / "truth-calibration.toml")]
    refused = runner.invoke(app, [*command, *given], input="n\n")
    assert isinstance(refused.exception, InterlockError)
    assert not (tmp_path / "body-1").exists()
    first = runner.invoke(app, [*command, *given, "--yes"])
    again = runner.invoke(
        app, ["calibration", "daily", str(tmp_path / "body-1" / "recording"), "--calibration", truth, "--json", *data]
    )
    told = json.loads(again.output)

    assert first.exit_code == 0, first.output
    assert "The calibration holds." in first.output
    assert told["holds"]
    assert told["reference"] == told["figures"]
    recording = open_recording(tmp_path / "body-1" / "recording")
    assert verify_recording(recording) == []
    assert recording.info.notes.startswith("simulated")


def test_one_placement_is_recorded_after_one_question_for_each_time_somebody_is_near(
    rig: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    def few_stops(at: Rig, folder: Path, choices: GuidedChoices) -> None:
        record_one_placement(at, folder, GuidedChoices(choices.board, 6, 1, choices.yes, choices.passing))

    monkeypatch.setattr(calibration_commands, "record_one_placement", few_stops)
    command = ["calibration", "align", str(tmp_path / "one"), "--rig", str(rig), "--fast"]
    done = runner.invoke(app, command, input="y\ny\n")
    recording = open_recording(tmp_path / "one")

    assert done.exit_code == 0, done.output
    assert done.output.count("Done?") == 2
    assert "step on" not in done.output
    assert "Nothing to turn." in done.output
    assert {(r.setup, r.sweep) for r in recording.frames} == {("empty", "static"), ("1", "static")}


def test_nothing_moves_where_nobody_answers(rig: Path, tmp_path: Path):
    done = runner.invoke(app, ["calibration", "align", str(tmp_path / "one"), "--rig", str(rig), "--fast"], input="")

    assert isinstance(done.exception, InterlockError)
    assert not (tmp_path / "one" / "frames.csv").exists()
