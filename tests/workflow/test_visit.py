"""One visit on the simulated foot: filed, processed, corrected, processed again."""

import json
import shutil
from dataclasses import replace
from datetime import date

import pytest

from footscan.config import load_calibration
from footscan.errors import EmptyScanError, InputError
from footscan.records import Correction, FootFacts, NewPatient, RecordStore
from footscan.scanning.filters import FilterSettings
from footscan.scanning.recording import open_recording
from footscan.scanning.sweep import SweepSettings
from footscan.workflow.foot import FootSettings
from footscan.workflow.process import ProcessSettings, process_recording
from footscan.workflow.results import save_results
from footscan.workflow.visit import Filing, correct_take, declare_foot, file_scan, reprocess_take
from footscan.workflow.visit_result import result_from_folder, settings_of_result

SETTINGS = ProcessSettings(
    SweepSettings(40, FilterSettings("median", 3)), side="left", load="seated", foot=FootSettings(0.0, 5.0)
)


@pytest.fixture(scope="module")
def results(small_scan, tmp_path_factory):
    """Results of `small_scan`, with settings that are not the usual ones."""
    out = tmp_path_factory.mktemp("visit") / "results"
    machine = load_calibration(small_scan / "truth-calibration.toml")
    save_results(process_recording(open_recording(small_scan), machine, SETTINGS), SETTINGS, out)
    return out


@pytest.fixture
def store(tmp_path):
    with RecordStore(tmp_path / "data") as opened:
        yield opened


@pytest.fixture
def ana(store):
    return store.add_patient(NewPatient("Ana", date(1962, 3, 31)), "op")


@pytest.fixture
def scan(store, small_scan):
    """The scan as `footscan scan` leaves it, not processed."""
    folder = store.data / "scans/20261123-120000-left"
    shutil.copytree(small_scan, folder / "recording")
    shutil.copy(small_scan / "truth-calibration.toml", folder / "calibration.toml")
    return folder


@pytest.fixture
def filed(store, ana, scan, results):
    """The scan filed with its results."""
    shutil.copytree(results, scan / "results")
    return file_scan(store, ana.id, scan, Filing("op", load="seated", process=False))


def value(take, name):
    return next(item for item in take.result.measurements if item.name == name)


def test_a_scan_without_results_is_processed_when_it_is_filed(store, ana, scan):
    take = file_scan(store, ana.id, scan, Filing("op", load="seated", surface="bare"))
    report = json.loads((store.results_folder(take.result.id) / "scan.json").read_text())

    assert 200 < value(take, "foot_length").value < 300
    assert (take.said.side, take.said.load, take.stale) == ("left", "seated", False)
    assert report["subject"]["surface"] == "bare"
    assert take.result.calibration_sha256 == report["calibration"]["sha256"]
    assert not scan.exists()
    assert store.check_records() == store.find_leftovers() == []


def test_results_that_fit_are_taken_over_as_they_are(store, ana, scan, results):
    shutil.copytree(results, scan / "results")
    take = file_scan(store, ana.id, scan, Filing("op", load="seated"))
    stored = json.loads((results / "measurements.json").read_text())["measurements"]

    assert {item.name: item.value for item in take.result.measurements} == {k: v["value"] for k, v in stored.items()}
    assert len(store.results(take.id)) == 1
    assert value(take, "foot_length").definition
    assert len({item.version for item in take.result.measurements}) > 20


def test_the_settings_of_a_result_are_those_it_was_made_with(results):
    result = result_from_folder(results)

    assert replace(settings_of_result(result), side="left", load="seated") == SETTINGS


def test_a_wrong_side_and_load_are_put_right_and_measured_again(store, filed):
    right = correct_take(store, filed.id, Correction(side="right", load="bipedal"), "mixed up", "op")
    content = json.loads((store.results_folder(right.result.id) / "measurements.json").read_text())

    assert (content["side"], content["load"]) == ("right", "bipedal")
    assert (right.result.side, right.result.load, right.stale) == ("right", "bipedal", False)
    assert right.result.settings == filed.result.settings
    assert [result.side for result in store.results(filed.id)] == ["right", "left"]
    assert open_recording(store.recording_folder(filed.id)).info.side == "left"


def test_a_wrong_patient_is_put_right_without_measuring_again(store, filed):
    bo = store.add_patient(NewPatient("Bo"), "op")
    right = correct_take(store, filed.id, Correction(patient_id=bo.id), "other file open", "op")

    assert right.patient_id == bo.id
    assert right.result == filed.result


def test_a_correction_stands_when_measuring_again_fails(store, filed, monkeypatch):
    def dark(*_, **__):
        raise EmptyScanError("no stripe was found")

    monkeypatch.setattr("footscan.workflow.visit.process_recording", dark)
    with pytest.raises(EmptyScanError):
        correct_take(store, filed.id, Correction(side="right"), "mixed up", "op")

    assert [(take.id, take.said.side, take.result.side) for take in store.stale_takes()] == [
        (filed.id, "right", "left")
    ]


def test_another_threshold_and_a_landmark_by_hand_count(store, filed):
    store.place_landmark(filed.id, "instep_point", (10.0, 0.0, 60.0), "doc")
    settings = replace(settings_of_result(filed.result), sweep=SweepSettings(60))
    again = reprocess_take(store, filed.id, "op", "bright room", settings=settings)
    marks = json.loads((store.results_folder(again.result.id) / "measurements.json").read_text())["landmarks"]

    assert (again.result.settings["threshold"], again.result.settings["threshold_used"]) == (60, 60)
    assert marks["instep_point"]["source"] == "manual"
    assert marks["instep_point"]["xyz"] == pytest.approx([10.0, 0.0, 60.0], abs=1e-6)
    assert store.audit(filed.patient_id)[0].reason == "bright room"


def test_a_missing_toe_declared_later_is_missing_in_the_result(store, filed):
    declare_foot(store, filed.visit_id, "left", FootFacts(missing=("toe_5",)), "op")
    take = store.take(filed.id)

    assert (take.result.missing, take.stale) == (("toe_5",), False)
    with pytest.raises(InputError, match="the missing part is 'toe_9'; allowed are toe_1"):
        declare_foot(store, filed.visit_id, "left", FootFacts(missing=("toe_9",)), "op")


def test_nothing_is_filed_where_no_stripe_is_found(store, filed):
    settings = replace(settings_of_result(filed.result), sweep=SweepSettings(254))
    with pytest.raises(EmptyScanError):
        reprocess_take(store, filed.id, "op", settings=settings)

    assert len(store.results(filed.id)) == 1
    assert store.find_leftovers() == []


def test_a_bare_recording_needs_a_calibration_unless_it_is_only_kept(store, ana, small_scan):
    with pytest.raises(InputError, match="--calibration"):
        file_scan(store, ana.id, small_scan, Filing("op"))
    take = file_scan(store, ana.id, small_scan, Filing("op", process=False))

    assert take.result is None
    with pytest.raises(InputError, match="without a calibration"):
        reprocess_take(store, take.id, "op")
    assert (small_scan / "recording.toml").is_file()


@pytest.mark.parametrize("damage", ["{", "[]", "{}"])
def test_damaged_results_are_refused_and_the_scan_stays(store, ana, scan, results, damage):
    shutil.copytree(results, scan / "results")
    (scan / "results/scan.json").write_text(damage)
    with pytest.raises(InputError, match="process the recording again"):
        file_scan(store, ana.id, scan, Filing("op"))

    assert (scan / "recording/frames.csv").is_file()
    assert store.visits(ana.id) == []
