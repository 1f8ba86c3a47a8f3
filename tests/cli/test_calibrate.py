"""The technician's commands as a user sees them: files, words, exit status."""

import json
import tomllib
from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

from footscan.cli.main import app
from footscan.config import load_board, load_calibration
from footscan.errors import InputError, MachineMismatchError, PoorFitError, QualityError, RecordingError
from footscan.optics.calibration import Calibration, fingerprint
from footscan.optics.table_store import load_tables
from footscan.workflow.calibration_log import keep_in_force

runner = CliRunner()


@pytest.fixture(scope="module")
def recording(shared_dir: Path) -> Path:
    return shared_dir / "data" / "recordings" / "calibration-workshop"


def test_a_board_is_printed_with_its_description(tmp_path: Path):
    done = runner.invoke(app, ["board", "--out", str(tmp_path / "board.pdf")])
    board = load_board(tmp_path / "board.toml")

    assert done.exit_code == 0
    assert "A4" in done.output
    assert "calliper" in done.output or "measure over all" in done.output
    assert (tmp_path / "board.pdf").read_bytes().startswith(b"%PDF")
    assert (board.squares_x, board.squares_y, board.square_mm, board.measured) == (7, 5, 30.0, False)


def test_measured_lengths_go_into_the_board_file(tmp_path: Path):
    lengths = ["--measured-x", "210.4", "--measured-y", "150.2"]
    done = runner.invoke(app, ["board", "--out", str(tmp_path / "board.pdf"), *lengths])

    assert done.exit_code == 0
    assert load_board(tmp_path / "board.toml").measured


def test_a_calibration_is_written_with_quality_tables_and_history(recording: Path, tmp_path: Path):
    out, data = tmp_path / "cal.toml", tmp_path / "data"
    done = runner.invoke(app, ["calibrate", str(recording), "--out", str(out), "--data", str(data)])
    content, calibration = tomllib.loads(out.read_text()), load_calibration(out)

    assert done.exit_code == 0, done.output
    assert "scale not verified" in done.output
    assert content["quality"]["scale_verified"] is False
    assert len(content["quality"]["recording_sha256"]) == 64
    assert content["quality"]["standard_deviation"]["focal_length_mm"] > 0.0
    assert load_tables(tmp_path / "cal.tables.npz", calibration)["right"].calibration_sha256 == fingerprint(calibration)
    told = runner.invoke(app, ["calibration", "history", "--data", str(data), "--json"])
    assert json.loads(told.output)["machines"]["workshop-7"]["events"][0]["sha256"] == fingerprint(calibration)


def test_a_refused_calibration_leaves_the_one_in_force_alone(recording: Path, tmp_path: Path):
    out = tmp_path / "cal.toml"
    out.write_bytes((recording / "truth-calibration.toml").read_bytes())
    before = out.read_bytes()
    command = ["calibrate", str(recording), "--out", str(out), "--measured-x", "212", "--measured-y", "150"]
    done = runner.invoke(app, command)

    assert isinstance(done.exception, PoorFitError)
    assert done.exception.exit_status == 4
    assert "print scale unequal" in str(done.exception)
    assert out.read_bytes() == before


def test_the_calibration_of_another_machine_is_not_overwritten(recording: Path, tmp_path: Path):
    out = tmp_path / "cal.toml"
    out.write_text((recording / "truth-calibration.toml").read_text().replace("workshop-7", "workshop-8"))

    assert isinstance(
        runner.invoke(app, ["calibrate", str(recording), "--out", str(out)]).exception, MachineMismatchError
    )


def test_a_scan_is_no_calibration_recording(small_scan: Path, tmp_path: Path):
    done = runner.invoke(app, ["calibrate", str(small_scan), "--out", str(tmp_path / "cal.toml")])

    assert isinstance(done.exception, RecordingError)
    assert "needs a calibration recording" in str(done.exception)


@pytest.mark.parametrize("lengths", [["--measured-x", "210"], ["--measured-x", "21", "--measured-y", "15"]])
def test_measured_lengths_must_be_two_and_plausible(recording: Path, tmp_path: Path, lengths: list[str]):
    done = runner.invoke(app, ["calibrate", str(recording), "--out", str(tmp_path / "cal.toml"), *lengths])

    assert isinstance(done.exception, InputError)


def test_acceptance_without_an_artefact_says_what_is_missing(small_scan: Path):
    truth = str(small_scan / "truth-calibration.toml")
    done = runner.invoke(app, ["accept", str(small_scan), "--calibration", truth])

    assert isinstance(done.exception, RecordingError)
    assert "--artefact" in str(done.exception)


def test_a_sphere_is_accepted_under_its_size_and_refused_under_another(small_sphere: Path, tmp_path: Path):
    command = ["accept", str(small_sphere), "--calibration", str(small_sphere / "truth-calibration.toml")]
    done = runner.invoke(app, [*command, "--out", str(tmp_path)])
    report = json.loads((tmp_path / "acceptance.json").read_text())

    assert done.exit_code == 0, done.output
    assert report["of_what"].startswith("simulated sphere")
    assert report["accepted"]
    assert abs(report["parts"]["sphere 1"]["both"]["size_error_mm"]) < 0.1
    assert (tmp_path / "acceptance.pdf").read_bytes().startswith(b"%PDF")
    wrong = tmp_path / "wrong.toml"
    wrong.write_text('format = "footscan-artefact/1"\nkind = "sphere"\ndiameters_mm = [60.5]\n')
    assert "PS -0.5" in str(runner.invoke(app, [*command, "--artefact", str(wrong)]).exception)


@pytest.fixture(scope="module")
def small_sphere(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sphere") / "scan"
    done = runner.invoke(app, ["simulate", "sphere", str(folder), "--seed", "4", "--frames", "48"])
    assert done.exit_code == 0, done.output
    return folder


def test_a_scan_is_refused_while_an_intervention_has_made_the_calibration_invalid(tmp_path: Path, ideal: Calibration):
    machine = replace(ideal, machine_id="sim-1", created="2026-01-01T00:00:00+00:00")
    keep_in_force(tmp_path, machine, {}, {})
    noted = runner.invoke(app, ["calibration", "service", "lens", "--data", str(tmp_path)])
    scan = runner.invoke(app, ["scan", "--side", "left", "--fast", "--yes", "--data", str(tmp_path)])

    assert "everything is no longer known" in noted.output
    assert isinstance(scan.exception, QualityError)
    assert "lens exchanged or turned; calibrate the whole machine" in str(scan.exception)
    assert not (tmp_path / "scans").exists()
