import json
import signal
from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

from footscan import app as rig_app
from footscan.cli.main import app
from footscan.cli.scan import opened_rig_session
from footscan.errors import DeviceError
from footscan.scanning.recording import open_recording
from footscan.scanning.session.control import Session
from footscan.workflow.designs import builtin_rig

RUN = CliRunner()


@pytest.fixture(scope="module")
def scanned(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """One scan of the simulated machine by command, at full size, in virtual time."""
    data = tmp_path_factory.mktemp("data")
    where = ["--data", str(data)]
    result = RUN.invoke(app, ["scan", "--side", "right", "--load", "bipedal", "--yes", "--fast", *where])
    assert result.exit_code == 0, result.output
    (folder,) = (data / "scans").iterdir()
    return folder, result.output


def test_scan_ends_with_a_measured_foot_and_a_motion_verdict(scanned: tuple[Path, str]):
    folder, said = scanned
    report = json.loads((folder / "results/scan.json").read_text())
    measured = json.loads((folder / "results/measurements.json").read_text())

    assert measured["side"] == "right"
    assert 240 < measured["measurements"]["foot_length"]["value"] < 270
    assert report["verdict"]["grade"] == "good"
    assert report["motion"]
    assert "step off" in said
    assert "Verdict" in said


def test_scan_writes_the_subject_and_the_calibration_it_was_made_under(scanned: tuple[Path, str]):
    folder, _ = scanned

    assert open_recording(folder / "recording").info.subject.load == "bipedal"
    assert (folder / "calibration.toml").is_file()


def test_scans_lists_what_was_processed_and_what_was_not(scanned: tuple[Path, str], tmp_path: Path):
    folder, _ = scanned
    whole = RUN.invoke(app, ["scans", "--data", str(folder.parents[1]), "--json"])
    nothing = RUN.invoke(app, ["scans", "--data", str(tmp_path)])

    assert [item["processed"] for item in json.loads(whole.output)["scans"]] == [True]
    assert "make one with" in nothing.output


def test_without_a_look_at_the_faces_nothing_is_switched_on(tmp_path: Path):
    result = RUN.invoke(app, ["scan", "--side", "left", "--fast", "--data", str(tmp_path)], input="n\n")

    assert result.exit_code != 0
    assert "stay off" in str(result.exception)
    assert not (tmp_path / "scans").exists()


def test_a_folder_that_holds_a_scan_is_left_as_it_is(scanned: tuple[Path, str], tmp_path: Path):
    folder, _ = scanned
    before = (folder / "calibration.toml").stat().st_mtime_ns
    words = ["scan", "--side", "left", "--yes", "--fast", "--out", str(folder), "--data", str(tmp_path)]
    result = RUN.invoke(app, words)

    assert "already holds a recording" in str(result.exception)
    assert (folder / "calibration.toml").stat().st_mtime_ns == before


def test_emulated_wires_cannot_be_hurried(tmp_path: Path):
    from footscan.workflow.designs import builtin_config

    rig = str(builtin_config("rig-emulated"))
    result = RUN.invoke(app, ["scan", "--side", "left", "--yes", "--fast", "--rig", rig, "--data", str(tmp_path)])

    assert "which need their time" in str(result.exception)


def test_a_profile_that_does_not_exist_names_those_that_do(tmp_path: Path):
    result = RUN.invoke(app, ["scan", "--side", "left", "--fast", "--profile", "turbo", "--data", str(tmp_path)])

    assert "standard, quick, fine" in str(result.exception)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            'kind = "simulated"\n\n[devices.encoder]',
            'kind = "webcam"\n\n[devices.encoder]',
            '"devices.camera.kind" is "webcam", allowed is "simulated"',
        ),
        ("sweep_deg = [-5.0, 365.0]", "sweep_deg = [-5.0, 300.0]", "at least 360"),
        ("travel_deg = [-25.0, 385.0]", "travel_deg = [-6.0, 366.0]", "must lie between"),
        ("speeds_deg_per_s = [18.75, 37.5, 60.0]", "speeds_deg_per_s = [60.0, 30.0]", "must be positive and rise"),
        ("max_on_s = 60.0", "max_on_s = -1.0", "max_on_s"),
        ("max_on_s = 60.0", "max_on_s = 15.0", "longer than max_on_s"),
        ("home_deg = -10.0", "home_deg = -24.0", "lie between travel_deg and home_deg"),
        ("blocked_deg = []", "blocked_deg = [[350.0, 355.0]]", "parks at -7.5 degrees, inside blocked_deg"),
        ("blocked_deg = []", "blocked_deg = [[0.0, 352.0]]", "covers 352 degrees, at most 120 leave a foot to be seen"),
        ("switching_s = 0.002", "switching_ms = 2", "switching_ms"),
        ('object = "foot"', 'object = "/no/such.stl"', "/no/such.stl"),
    ],
)
def test_a_rig_file_that_cannot_work_is_refused_in_one_sentence(tmp_path: Path, old: str, new: str, words: str):
    from footscan.workflow.designs import builtin_config

    text = builtin_config("sim").read_text()
    assert old in text
    rig = tmp_path / "rig.toml"
    rig.write_text(text.replace(old, new))
    result = RUN.invoke(app, ["scan", "--side", "left", "--yes", "--rig", str(rig), "--data", str(tmp_path / "d")])

    assert words in str(result.exception)
    assert "\n" not in str(result.exception)


def test_doctor_finds_the_simulated_machine_in_order(tmp_path: Path):
    result = RUN.invoke(app, ["doctor", "--data", str(tmp_path), "--json"])
    findings = json.loads(result.output)["findings"]

    assert result.exit_code == 0
    assert {finding["device"] for finding in findings} == {"disk", "calibration", "camera", "encoder", "io"}
    assert {finding["grade"] for finding in findings} == {"good"}


def test_a_simulated_button_cannot_be_waited_for(tmp_path: Path):
    result = RUN.invoke(app, ["scan", "--side", "left", "--yes", "--button", "--data", str(tmp_path)])

    assert "nobody can press that of a simulated one" in str(result.exception)


def test_without_an_answer_lasers_and_motor_stay_off(tmp_path: Path):
    result = RUN.invoke(app, ["scan", "--side", "left", "--fast", "--data", str(tmp_path)], input="")

    assert "not confirmed: lasers and motor stay off" in str(result.exception)


def test_a_file_is_no_place_for_a_scan(tmp_path: Path):
    (tmp_path / "file").touch()
    words = ["scan", "--side", "left", "--yes", "--fast", "--out", str(tmp_path / "file/scan"), "--data", str(tmp_path)]

    assert "is a file, no folder for a scan" in str(RUN.invoke(app, words).exception)


def test_doctor_says_what_a_machine_lacks(tmp_path: Path):
    from footscan.workflow.designs import builtin_config

    result = RUN.invoke(app, ["doctor", "--rig", str(builtin_config("rig-qsb-adam")), "--data", str(tmp_path)])

    assert result.exit_code != 0
    assert result.output.count("does not exist") >= 4


def test_an_unknown_case_of_the_drill_names_those_there_are():
    result = RUN.invoke(app, ["drill", "--case", "earthquake"])

    assert result.exit_code == 2
    assert "kill -9" in result.output.replace("\n", " ")


def test_a_session_that_does_not_start_gives_the_machine_and_the_signals_back(monkeypatch: pytest.MonkeyPatch):
    given_back: list[str] = []
    opened = replace(rig_app.open_rig(builtin_rig()), give_back=lambda: given_back.append("rig"))

    def silent(*_: object) -> Session:
        raise DeviceError("the encoder is silent")

    monkeypatch.setattr(rig_app, "open_rig", lambda *_: opened)
    monkeypatch.setattr(rig_app, "start_session", silent)
    before = signal.getsignal(signal.SIGTERM)
    with pytest.raises(DeviceError, match="silent"), opened_rig_session(opened.rig, "left", None):
        pass

    assert given_back == ["rig"]
    assert signal.getsignal(signal.SIGTERM) is before
