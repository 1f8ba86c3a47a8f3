import os
from dataclasses import replace

import pytest

from footscan.errors import InputError, StorageError
from footscan.records import FootFacts
from footscan.records.tree_hash import hash_of_folder


def test_a_filed_scan_moves_into_the_records_with_all_it_is_made_of(store, ana, make_scan, said, result):
    scan = make_scan(1)
    hashes = [hash_of_folder(scan / part) for part in ("recording", "results")]
    take = store.file_take(ana.id, said, scan / "recording", result, scan / "results", scan / "calibration.toml")

    assert not scan.exists()
    assert [
        hash_of_folder(store.recording_folder(take.id)),
        hash_of_folder(store.results_folder(take.result.id)),
    ] == hashes
    assert store.calibration_file(take.id).read_text() == "calibration of the clinic\n"
    assert (take.patient_id, take.number, take.said, take.finished) == (ana.id, 1, said, True)
    assert (take.verdict, take.in_use, take.stale) == ("undecided", False, False)
    assert take.result.measurements == result.measurements
    assert store.check_records() == store.find_leftovers() == []


def test_a_scan_from_elsewhere_is_copied_and_stays(store, ana, make_scan, said, tmp_path):
    elsewhere = tmp_path / "stick"
    make_scan(1).rename(elsewhere)
    before = hash_of_folder(elsewhere)
    take = store.file_take(ana.id, said, elsewhere / "recording")
    (elsewhere / "recording/frames/000000.png").write_bytes(b"changed on the stick")

    assert hash_of_folder(elsewhere) != before
    assert store.check_records() == []
    assert take.result is None


def test_what_else_lies_in_a_scan_folder_is_not_removed(store, ana, make_scan, said):
    scan = make_scan(1)
    (scan / "notes.txt").write_text("of the operator")
    store.file_take(ana.id, said, scan / "recording")

    assert not (scan / "recording").exists()
    assert {path.name for path in scan.iterdir()} == {"notes.txt", "results", "calibration.toml"}


def test_a_recording_is_filed_once(store, ana, bo, make_scan, said, tmp_path):
    copy = tmp_path / "copy"
    make_scan(1).rename(copy)
    take = store.file_take(ana.id, said, copy / "recording")
    with pytest.raises(InputError, match=f"take {take.id} of patient {ana.id}"):
        store.file_take(bo.id, said, copy / "recording")

    assert store.visits(bo.id) == []


def test_a_broken_off_recording_is_filed_only_on_purpose(store, ana, make_scan, said):
    scan = make_scan(1, finished=False)
    with pytest.raises(InputError, match="broken off"):
        store.file_take(ana.id, said, scan / "recording")
    with pytest.raises(InputError, match="still being written"):
        store.file_take(ana.id, said, scan / "recording", unfinished=True)
    for path in (scan / "recording", *(scan / "recording").rglob("*")):
        os.utime(path, (1.0e9, 1.0e9))
    take = store.file_take(ana.id, said, scan / "recording", unfinished=True)

    assert not take.finished
    assert not (scan / "recording").exists()


def test_what_is_no_recording_is_refused(store, ana, said, tmp_path):
    with pytest.raises(InputError, match=r"no recording\.toml"):
        store.file_take(ana.id, said, tmp_path)


def test_links_are_not_followed_into_the_records(store, ana, make_scan, said):
    scan = make_scan(1)
    (scan / "recording/frames/secret.png").symlink_to("/etc/hostname")
    with pytest.raises(InputError, match="no plain file"):
        store.file_take(ana.id, said, scan / "recording")

    assert store.find_leftovers() == []


def test_a_failing_filing_leaves_the_scan_and_nothing_else(store, ana, make_scan, said, result, data):
    scan = make_scan(1)
    with pytest.raises(InputError, match="there is no patient 99"):
        store.file_take(99, said, scan / "recording", result, scan / "results")
    bad = replace(result, measurements=(result.measurements[0], result.measurements[0]))
    with pytest.raises(Exception, match="UNIQUE"):
        store.file_take(ana.id, said, scan / "recording", bad, scan / "results")

    assert (scan / "recording/manifest.sha256").is_file()
    assert store.find_leftovers() == []
    assert [path for path in (data / "files").rglob("*") if path.is_file()] == []
    assert store.visits(ana.id) == []


def test_a_full_disk_is_said_and_nothing_is_lost(store, ana, make_scan, said, monkeypatch):
    scan = make_scan(1)

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(StorageError, match="No space left"):
        store.file_take(ana.id, said, scan / "recording")
    monkeypatch.undo()

    assert store.file_take(ana.id, said, scan / "recording").number == 1
    assert store.find_leftovers() == []


def test_takes_of_a_foot_are_numbered_and_a_visit_is_the_day_of_the_recording(store, ana, file_scan):
    takes = [file_scan(ana, 1), file_scan(ana, 2), file_scan(ana, 3, side="right")]

    assert [take.number for take in takes] == [1, 2, 1]
    assert len(store.visits(ana.id)) == 1
    assert [take.id for take in store.takes(takes[0].visit_id)] == [take.id for take in takes]


def test_one_take_per_foot_and_load_is_in_use(store, ana, file_scan):
    first, second = file_scan(ana, 1), file_scan(ana, 2)
    standing = file_scan(ana, 3, load="bipedal")
    for take in (first, standing, second):
        store.use_take(take.id, "op")

    assert [store.take(take.id).in_use for take in (first, second, standing)] == [False, True, True]


def test_a_take_to_be_repeated_or_without_a_foot_is_not_used(store, ana, file_scan, make_scan, said):
    take = file_scan(ana, 1)
    store.use_take(take.id, "op")
    judged = store.judge_take(take.id, "repeat", "op", "moved")
    bare = make_scan(2)
    unprocessed = store.file_take(ana.id, said, bare / "recording")

    assert (judged.in_use, judged.verdict_by, judged.verdict_remark) == (False, "op", "moved")
    for useless in (take, unprocessed):
        with pytest.raises(InputError):
            store.use_take(useless.id, "op")


@pytest.mark.parametrize("verdict", ["with_remark", "repeat"])
def test_a_verdict_against_a_take_needs_words(store, ana, file_scan, verdict):
    with pytest.raises(InputError, match="the remark is empty"):
        store.judge_take(file_scan(ana).id, verdict, "op")


def test_a_new_result_counts_and_the_old_one_stays_with_its_own_definitions(store, ana, file_scan, result, tmp_path):
    take = file_scan(ana)
    (tmp_path / "new").mkdir()
    (tmp_path / "new/scan.json").write_text("{}")
    longer = replace(result.measurements[0], value=252.0, definition="heel to longest toe", version="v2")
    store.file_result(take.id, replace(result, measurements=(longer,)), tmp_path / "new", None, "op", "threshold")
    old, new = store.results(take.id)[::-1]

    assert store.take(take.id).result == new
    assert new.measurements == (longer,)
    assert old.measurements == result.measurements
    assert store.results_folder(old.id).is_dir()
    assert store.calibration_file(take.id) is not None


def test_landmarks_by_hand_stay_with_the_take(store, ana, file_scan):
    take = file_scan(ana)
    store.place_landmark(take.id, "pternion", (1.0, 2.0, 3.0), "op")
    moved = store.place_landmark(take.id, "pternion", (1.5, 2.0, 3.0), "doc")

    assert [(mark.name, mark.xyz_world, mark.placed_by) for mark in moved.landmarks] == [
        ("pternion", (1.5, 2.0, 3.0), "doc")
    ]
    assert store.remove_landmark(take.id, "pternion", "op").landmarks == ()
    with pytest.raises(InputError, match="three numbers"):
        store.place_landmark(take.id, "pternion", (float("nan"), 0.0, 0.0), "op")


def test_missing_parts_declared_later_make_a_result_stale(store, ana, file_scan):
    take = file_scan(ana)
    store.declare_foot(take.visit_id, "left", FootFacts(missing=("toe_5",), deformity="bunion"), "op")

    assert store.take(take.id).stale
    assert [stale.id for stale in store.stale_takes()] == [take.id]


def test_a_foot_can_be_why_not_scanned(store, ana):
    visit = store.open_visit(ana.id, "op", "came with a cast")
    store.declare_foot(visit.id, "right", FootFacts(not_scanned="plaster cast"), "op")

    assert store.open_visit(ana.id, "op").id == visit.id
    assert [(foot.side, foot.facts.not_scanned) for foot in store.feet(visit.id)] == [("right", "plaster cast")]
    assert store.visit(visit.id).notes == "came with a cast"


def test_an_export_holds_everything_and_is_noted(store, ana, file_scan):
    take = file_scan(ana)
    store.place_landmark(take.id, "pternion", (1.0, 2.0, 3.0), "op")
    content = store.export_patient(ana.id, "doc", "for the court")
    exported = content["visits"][0]["takes"][0]

    assert content["patient"]["name"] == "Ana"
    assert exported["results"][0]["measurements"][1]["interval"] == [231.0, 250.0]
    assert exported["landmarks"][0]["xyz_world"] == [1.0, 2.0, 3.0]
    assert content["log"][-1]["action"] == "patient exported"
    assert store.audit(ana.id)[0].reason == "for the court"
