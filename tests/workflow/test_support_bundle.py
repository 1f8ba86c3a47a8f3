"""The support bundle: what a helper needs is in it, and nothing that was planted about a person."""

import json
import shutil
import zipfile
from dataclasses import replace
from datetime import date
from pathlib import Path

import pytest
from typer.testing import CliRunner

from footscan.cli.main import app
from footscan.optics.calibration import Calibration
from footscan.records import NewPatient, RecordStore
from footscan.workflow.calibration_log import keep_in_force, log_event, log_service
from footscan.workflow.designs import builtin_config
from footscan.workflow.support_bundle import machine_lines, without

PLANTED = (
    "Zenobia",
    "Quarkenstein",
    "1951-03-27",
    "AB-778899",
    "weeping ulcer",
    "drquimby",
    "hallux of Z",
    "Rue Xyzzy",
)


@pytest.fixture
def data(tmp_path: Path, ideal: Calibration) -> Path:
    """A data folder full of persons: in the records, in notes, in paths, in comments and in the page's log."""
    data = tmp_path / "data"
    with RecordStore(data) as store:
        who = NewPatient("Zenobia Quarkenstein", date(1951, 3, 27), "AB-778899", "weeping ulcer, lives in Rue Xyzzy")
        store.add_patient(who, "drquimby")
    machine = replace(ideal, machine_id="m-1", scanner="prototype of Zenobia", created="2026-01-02T03:04:05+00:00")
    quality = {"expected_error_mm": {"right": 0.0123}, "views": {"hallux of Z": 3}, "placements": ["Quarkenstein"]}
    keep_in_force(data, machine, quality, {"note": "for Zenobia Quarkenstein"})
    log_service(data, "m-1", "left-laser", "exchanged while Zenobia Quarkenstein waited, weeping ulcer")
    scan = {"agreement_mm": {"heel": 0.0321}, "sha256": "0" * 64, "recording": "/home/drquimby/Zenobia/scan"}
    log_event(data, "m-1", "scan", scan)
    (data / "page.log").write_text(
        "2026-01-01T10:00:00+00:00  drquimby controls\n"
        "2026-01-01T10:01:00+00:00  patient Zenobia Quarkenstein chosen\n"
        "2026-01-01T10:02:00+00:00  machine: parked, see /home/drquimby/Zenobia/scan for 'hallux of Z'\n"
    )
    return data


def _bundle(data: Path, tmp_path: Path) -> dict[str, str]:
    rig = tmp_path / "rig.toml"
    rig.write_text("# machine in Rue Xyzzy, paid by Zenobia Quarkenstein\n" + builtin_config("sim").read_text())
    out = tmp_path / "bundle.zip"
    done = CliRunner().invoke(app, ["support-bundle", "--out", str(out), "--rig", str(rig), "--data", str(data)])
    assert done.exit_code == 0, done.output
    with zipfile.ZipFile(out) as opened:
        return {name: opened.read(name).decode() for name in opened.namelist()}


def test_nothing_planted_about_a_person_is_in_the_bundle(data: Path, tmp_path: Path):
    members = _bundle(data, tmp_path)

    for name, text in members.items():
        for planted in PLANTED:
            assert planted.lower() not in text.lower(), (planted, name)
            assert planted.lower() not in name.lower()


def test_without_records_the_choice_of_keys_alone_keeps_persons_out(data: Path, tmp_path: Path):
    for path in data.glob("records.sqlite3*"):
        path.unlink()
    shutil.rmtree(data / "backups", ignore_errors=True)
    members = _bundle(data, tmp_path)

    told = "".join(members.values()).lower()
    assert "prototype of" in told  # the machine's own name is a fact about the machine
    for planted in PLANTED:
        assert planted.lower() not in told.replace("prototype of zenobia", "")


def test_what_a_helper_needs_is_in_the_bundle(data: Path, tmp_path: Path):
    members = _bundle(data, tmp_path)
    machine = json.loads(members["machine-1/calibration.json"])
    log = json.loads(members["machine-1/log.json"])

    assert json.loads(members["versions.json"])["packages"]["numpy"]
    assert json.loads(members["rig.json"])["scanner"]["encoder"]["steps_per_rev"] == 8000
    assert machine["calibration"]["camera"]["focal_length_mm"] == 8.0
    assert machine["quality"]["expected_error_mm"] == {"right": 0.0123}
    assert machine["doubts"]["blocking"] == 1
    assert machine["drift"][0]["median_mm"] == [0.0321]
    assert [event["kind"] for event in log] == ["calibration", "service", "scan"]
    assert log[1]["part"] == "left-laser"
    assert members["machine-log.txt"].endswith("machine: parked, see (path) for (text)")


def test_only_what_the_machine_said_is_taken_from_the_log():
    assert machine_lines("2026-01-01  Ana controls\n2026-01-01  machine: homing\nmachine: not a log line") == [
        "2026-01-01  machine: homing"
    ]


def test_words_are_removed_whole_and_in_any_case():
    assert without("ANA and analysis, Ana-Lu", ["Ana"]) == "(removed) and analysis, (removed)-Lu"
