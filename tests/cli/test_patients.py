"""`footscan patients ...` as a person runs it."""

import json
import os
import shutil
import subprocess
import sys

import pytest
from typer.testing import CliRunner

from footscan.cli.drill_records import drill_records_command
from footscan.cli.patients import patients_app
from footscan.errors import FootscanError
from footscan.records import RecordStore


@pytest.fixture
def data(tmp_path):
    return tmp_path / "data"


@pytest.fixture
def patients(data):
    """Run a command in this process; a refusal is given back as its sentence."""

    def run(*arguments, answer=None):
        command = [*map(str, arguments), "--data", str(data)]
        done = CliRunner().invoke(patients_app, command, input=answer, catch_exceptions=True)
        if isinstance(done.exception, FootscanError):
            return str(done.exception)
        assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
        return done.output

    return run


@pytest.fixture
def scan(data, small_scan):
    folder = data / "scans/20261123-120000-left"
    shutil.copytree(small_scan, folder / "recording")
    shutil.copy(small_scan / "truth-calibration.toml", folder / "calibration.toml")
    return folder


def test_patients_are_added_found_edited_and_shown(patients):
    assert patients("add", "Ana Łódź", "--born", "1962-03-31", "--by", "op") == "Patient 1 added: Ana Łódź\n"
    assert patients("add", "李小龍", "--number", "77", "--by", "op") == "Patient 2 added: 李小龍\n"
    assert patients("list", "lodz") == "    1  Ana Łódź  born 1962-03-31\n"
    assert patients("edit", 1, "--number", "A-1", "--notes", "one\ntwo") == "1  Ana Łódź  born 1962-03-31  number A-1\n"
    assert patients("edit", 1, "--born", "", "--number", "") == "1  Ana Łódź  no birth date\n"
    assert "No visit yet" in patients("show", 1)
    assert [row["name"] for row in json.loads(patients("list", "--json"))["patients"]] == ["Ana Łódź", "李小龍"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["add", "Ana", "--born", "2031-01-01"], "allowed is 1900-01-01 to today"),
        (["add", "Ana", "--born", "1990-02-30"], "such as 1962-03-31"),
        (["add", "A\x07na"], "U+0007"),
        (["add", "x" * 201], "201 characters, at most 200"),
        (["add", "Bo", "--born", "1962-03-31"], "--force"),
        (["add", "Cy", "--number", "7"], "the number 7 is that of patient 1"),
        (["show", "9"], "there is no patient 9"),
        (["edit", "1"], "nothing to change was given"),
        (["correct", "1", "--reason", "x"], "nothing to correct was given"),
        (["correct", "1", "--reason", "x", "--side", "left"], "there is no take 1"),
        (["judge", "1", "accepted"], "there is no take 1"),
        (["file", "nowhere", "--patient", "1"], "nowhere is no folder"),
        (["foot", "1", "--side", "left"], "there is no visit 1"),
        (["leftovers", "--remove", "x", "--reason", "y"], "there is no leftover x"),
        (["export", "1", "--out", "/etc/hostname"], "nothing is overwritten"),
    ],
)
def test_bad_input_ends_in_one_sentence(patients, arguments, words):
    patients("add", "Bo", "--born", "1962-03-31", "--number", "7")
    patients("edit", 1, "--notes", "known")
    said = patients(*arguments)

    assert words in said
    assert "\n" not in said


def test_deleting_asks_and_the_log_remains(patients):
    patients("add", "Ana", "--by", "op")

    assert patients("delete", 1, "--reason", "asked for", answer="n\n") == "not confirmed; nothing was deleted."
    assert "Patient 1 deleted." in patients("delete", 1, "--reason", "asked for", "--by", "chief", answer="y\n")
    assert patients("list") == "Nobody found; `footscan patients add NAME` enters a patient.\n"
    assert "chief: patient deleted, patient 1 (asked for)" in patients("log", 1)
    assert "Ana" not in patients("log")


def test_a_scan_is_filed_judged_used_corrected_and_exported(patients, scan, tmp_path):
    patients("add", "Ana", "--by", "op")
    filed = patients("file", scan, "--patient", 1, "--load", "seated", "--by", "op")
    patients("use", 1, "--by", "op")
    judged = patients("judge", 1, "with_remark", "--remark", "slight sway", "--by", "op")
    corrected = patients("correct", 1, "--side", "right", "--reason", "mixed up", "--by", "op")
    shown, kept = patients("show", 1), json.loads(patients("show", 1, "--json"))["visits"][0]["takes"][0]
    patients("export", 1, "--out", tmp_path / "ana.json", "--by", "op")
    exported = json.loads((tmp_path / "ana.json").read_text())

    assert "foot length 2" in filed
    assert "IN USE" in judged
    assert "(slight sway)" in judged
    assert "right" in corrected
    assert "STALE" not in corrected
    assert "take    1  right  no. 1  load seated" in shown
    assert (kept["side"], kept["in_use"], kept["stale"]) == ("right", True, False)
    assert [result["side"] for result in exported["visits"][0]["takes"][0]["results"]] == ["right", "left"]
    assert (tmp_path / "ana.json").stat().st_mode & 0o077 == 0
    assert patients("check") == "The records are whole.\n"
    assert patients("leftovers") == "No leftovers.\n"


def test_a_damaged_file_is_named_by_check(patients, data, scan):
    patients("add", "Ana", "--by", "op")
    patients("file", scan, "--patient", 1, "--no-process", "--by", "op")
    with RecordStore(data) as store:
        shutil.rmtree(store.recording_folder(1))

    assert "1 problems in the records" in patients("check")


def test_the_data_folder_is_that_of_the_environment_and_a_foreign_file_ends_with_status_2(data):
    data.mkdir()
    (data / "records.sqlite3").write_bytes(b"my shopping list" * 500)
    command = [sys.executable, "-m", "footscan.cli.main", "patients", "list"]
    environment = os.environ | {"FOOTSCAN_DATA": str(data)}
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)

    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1
    assert "is no SQLite file; move it away" in done.stderr


def test_the_drill_prints_its_figures(capsys):
    drill_records_command(kills=2, seed=1, json_only=True)
    report = json.loads(capsys.readouterr().out)

    assert (report["kills"], report["problems"]) == (2, [])
