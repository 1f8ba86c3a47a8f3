from collections.abc import Callable
from pathlib import Path

from footscan.workflow.scan import find_scans, process_words

EditCsv = Callable[[Path, Callable[[list[str]], list[str]]], None]


def test_a_scan_broken_off_in_its_first_sweep_is_offered_with_one_laser(scan_copy: Path, edit_csv: EditCsv):
    folder = scan_copy.rename(scan_copy.with_name("recording")).parent
    whole = process_words(folder)
    edit_csv(folder / "recording/frames.csv", lambda rows: [row for row in rows if ",right," in row])

    assert "--one-laser" not in whole
    assert process_words(folder) == [*whole, "--one-laser"]
    assert whole[:3] == ["footscan", "process", str(folder / "recording")]


def test_a_damaged_scan_is_listed_with_what_is_wrong(scan_copy: Path, tmp_path: Path):
    folder = tmp_path / "scans/20260101-120000-left"
    folder.mkdir(parents=True)
    scan_copy.rename(folder / "recording")
    (folder / "recording/frames.csv").write_text("frame,file\n")
    (stored,) = find_scans(tmp_path / "scans")

    assert "frames.csv" in stored.trouble
    assert not stored.processed


def test_an_empty_data_folder_has_no_scans(tmp_path: Path):
    assert find_scans(tmp_path / "scans") == []
