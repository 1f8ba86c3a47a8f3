"""What a kill leaves behind at each step of filing, made by hand; the drill does the same by chance."""

import shutil

import pytest

from footscan.errors import InputError
from footscan.records import Correction, RecordStore, drill
from footscan.records.drill_ledger import Expected
from footscan.records.tree_hash import hash_of_folder


def reopened(store, data):
    store.close()
    return RecordStore(data)


def test_killed_before_the_row_the_scan_is_still_there_and_the_copy_is_offered(store, data, ana, make_scan, said):
    scan = make_scan(1)
    sha256 = hash_of_folder(scan / "recording")
    shutil.copytree(scan / "recording", store._vault.path(sha256))
    (data / "stage/stage-dead/content").mkdir(parents=True)
    with reopened(store, data) as again:
        assert [(left.kind, left.name) for left in again.find_leftovers()] == [
            ("staged", "stage-dead"),
            ("unnamed", sha256),
        ]
        take = again.file_take(ana.id, said, scan / "recording")

        assert [left.kind for left in again.find_leftovers()] == ["staged"]
        assert take.recording_sha256 == sha256
        assert again.check_records() == []


def test_killed_after_the_row_the_move_is_finished_at_the_next_opening(store, data, ana, make_scan, said, result):
    scan = make_scan(1)
    kept = data.parent / "kept"
    shutil.copytree(scan, kept)
    store.file_take(ana.id, said, scan / "recording", result, scan / "results", scan / "calibration.toml")
    shutil.copytree(kept, scan)
    with reopened(store, data) as again:
        assert not scan.exists()
        assert again.check_records() == again.find_leftovers() == []


def test_a_new_scan_under_the_name_of_a_filed_one_is_not_touched(store, data, ana, make_scan, said):
    scan = make_scan(1)
    store.file_take(ana.id, said, scan / "recording")
    shutil.rmtree(scan)
    other = make_scan(2)
    other.rename(scan)
    with reopened(store, data):
        assert (scan / "recording/manifest.sha256").is_file()


def test_killed_while_deleting_a_patient_the_files_go_at_the_next_opening(store, data, ana, file_scan, monkeypatch):
    take = file_scan(ana)
    folder = store.recording_folder(take.id)
    monkeypatch.setattr(type(store), "_finish_discards", lambda self: None)
    store.delete_patient(ana.id, "asked for", "op")
    monkeypatch.undo()

    assert folder.is_dir()
    with reopened(store, data) as again:
        assert not folder.exists()
        assert again.check_records() == again.find_leftovers() == []


def test_a_leftover_is_removed_only_by_name_and_with_a_reason(store, data):
    (data / "stage/stage-dead").mkdir(parents=True)
    for name, reason in (("stage-dead", " "), ("../data", "x"), ("nothing", "x")):
        with pytest.raises(InputError):
            store.remove_leftover(name, reason, "op")
    store.remove_leftover("stage-dead", "killed by the power cut", "op")

    assert store.find_leftovers() == []
    assert store.audit()[0].subject == "stage-dead"


def test_nothing_acknowledged_is_gone_after_ten_kills():
    report = drill.drill_records(kills=10, seed=5)

    assert report.problems == ()
    assert sum(report.struck.values()) == report.kills == 10
    assert report.acknowledged > 0


def expected_after(store, ana, take):
    expected = Expected()
    added = {"state": "done", "action": "add", "patient": ana.id, "name": ana.name}
    facts = {"side": "left", "load": "seated", "sha256": take.recording_sha256, "results": 1}
    expected.read([added, {"state": "done", "action": "file", "take": take.id, "patient": ana.id, **facts}])
    return expected


def test_the_drill_sees_a_scan_that_was_given_up_too_early(store, ana, make_scan, said):
    scan = make_scan(1)
    sha256, recording = hash_of_folder(scan / "recording"), str(scan / "recording")
    begun = {"state": "begin", "action": "file", "patient": ana.id, "sha256": sha256, "recording": recording}

    def problems():
        expected = Expected()
        expected.read([begun])
        return expected.problems(store)

    assert problems() == []
    store.file_take(ana.id, said, scan / "recording")
    assert problems() == []
    store.delete_patient(ana.id, "test", "op")
    assert problems() == [f"the scan {recording} is neither filed nor still there"]


def test_the_drill_sees_what_is_gone(store, ana, bo, file_scan):
    take = file_scan(ana)

    assert expected_after(store, ana, take).problems(store) == []
    store.correct_take(take.id, Correction(bo.id, load="bipedal"), "x", "op")
    assert len(expected_after(store, ana, take).problems(store)) == 2
    store.delete_patient(bo.id, "x", "op")
    assert expected_after(store, ana, take).problems(store) == [f"take {take.id} is gone"]
    store.delete_patient(ana.id, "x", "op")
    assert expected_after(store, ana, take).problems(store) == [f"patient {ana.id} is gone", f"take {take.id} is gone"]
