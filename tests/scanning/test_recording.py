import shutil

import cv2
import numpy as np
import pytest

from footscan.config import RecordingInfo, scanner_toml
from footscan.errors import ConfigError, RecordingError
from footscan.scanning.frames import UnusableFrameError, read_frame
from footscan.scanning.recorder import RecordingWriter
from footscan.scanning.recording import MANIFEST, open_recording
from footscan.scanning.verify import verify_recording

INFO = RecordingInfo("scan", "left", "2026-11-21T12:00:00+00:00")


@pytest.fixture
def frame(rng, prototype):
    return rng.integers(0, 255, (prototype.camera.height_px, prototype.camera.width_px), dtype=np.uint8)


def test_a_recording_comes_back_as_it_was_written(tmp_path, prototype, frame):
    with RecordingWriter(tmp_path / "r", INFO, scanner_toml(prototype)) as writer:
        writer.add_counts(np.array([0.0, 0.1]), np.array([5, 9]))
        writer.add_frame(frame, 0.05, "right", "ccw")
        writer.add_frame(255 - frame, 0.09, "none", "static", "empty")
    recording = open_recording(tmp_path / "r")

    assert recording.info == INFO
    assert [record.laser for record in recording.frames] == ["right", "none"]
    assert recording.frames[1].setup == "empty"
    np.testing.assert_array_equal(read_frame(recording.path(recording.frames[1]), prototype.camera), 255 - frame)
    np.testing.assert_array_equal(recording.encoder.count, [5, 9])
    assert verify_recording(recording) == []


def test_what_was_written_before_a_power_cut_can_be_read(tmp_path, prototype, frame):
    writer = RecordingWriter(tmp_path / "r", INFO, scanner_toml(prototype))
    writer.add_counts(np.array([0.0, 0.1]), np.array([5, 9]))
    writer.add_frame(frame, 0.05, "right", "ccw")
    recording = open_recording(tmp_path / "r")  # the writer was never closed

    assert len(recording.frames) == 1
    assert verify_recording(recording) == []
    writer.close()
    writer.close()


def test_a_recording_that_broke_off_is_readable_but_not_called_finished(tmp_path, prototype, frame):
    with (
        pytest.raises(RuntimeError, match="stop"),
        RecordingWriter(tmp_path / "r", INFO, scanner_toml(prototype)) as writer,
    ):
        writer.add_counts(np.array([0.0, 0.1]), np.array([5, 9]))
        writer.add_frame(frame, 0.05, "right", "ccw")
        raise RuntimeError("stop")

    assert len(open_recording(tmp_path / "r").frames) == 1
    assert not (tmp_path / "r" / MANIFEST).exists()


def test_a_setup_that_would_break_the_table_is_refused(tmp_path, prototype, frame):
    with RecordingWriter(tmp_path / "r", INFO, scanner_toml(prototype)) as writer:
        with pytest.raises(ValueError, match="plain word"):
            writer.add_frame(frame, 0.05, "right", "ccw", "a,b")
        writer.add_frame(frame, 0.05, "right", "ccw", "a")
        writer.add_counts(np.array([0.0]), np.array([5]))

    assert len(open_recording(tmp_path / "r").frames) == 1


def test_a_recording_is_never_overwritten(tmp_path, prototype):
    RecordingWriter(tmp_path / "r", INFO, scanner_toml(prototype)).close()

    with pytest.raises(RecordingError, match="nothing is overwritten"):
        RecordingWriter(tmp_path / "r", INFO, scanner_toml(prototype))


def test_every_changed_missing_or_added_file_is_named(scan_copy):
    (scan_copy / "frames/000003.png").unlink()
    text = (scan_copy / "encoder.csv").read_text()
    (scan_copy / "encoder.csv").write_text(text.replace(",", ", ", 1) if ", " in text else text + "99.0,1\n")
    shutil.copy(scan_copy / "frames/000001.png", scan_copy / "frames/999999.png")
    problems = "\n".join(verify_recording(open_recording(scan_copy)))

    assert "frames/000003.png is missing" in problems
    assert "encoder.csv was changed" in problems
    assert "frames/999999.png was added" in problems
    assert "frame 1:" not in problems


def test_a_recording_without_checksums_is_judged_by_its_frames(scan_copy):
    (scan_copy / MANIFEST).unlink()

    assert verify_recording(open_recording(scan_copy)) == []


@pytest.mark.parametrize(
    ("break_file", "reason"),
    [
        (lambda b: b"", "empty file"),
        (lambda b: b"GIF89a" + b, "not a picture"),
        (lambda b: b[: len(b) // 2], "cut file"),
        (lambda b: b[:200] + bytes([b[200] ^ 1]) + b[201:], "damaged picture"),
        (lambda b: cv2.imencode(".png", np.zeros((500, 600), np.uint8))[1].tobytes(), "wrong size"),
        (lambda b: cv2.imencode(".png", np.zeros((500, 582, 3), np.uint8))[1].tobytes(), "not 8-bit grey"),
        (lambda b: cv2.imencode(".png", np.zeros((500, 582), np.uint16))[1].tobytes(), "not 8-bit grey"),
    ],
)
def test_every_unusable_picture_has_a_named_reason(scan_copy, prototype, break_file, reason):
    path = scan_copy / "frames/000000.png"
    path.write_bytes(break_file(path.read_bytes()))

    with pytest.raises(UnusableFrameError) as caught:
        read_frame(path, prototype.camera)
    assert caught.value.reason == reason


def test_a_missing_picture_is_a_named_reason(tmp_path, prototype):
    with pytest.raises(UnusableFrameError) as caught:
        read_frame(tmp_path / "no.png", prototype.camera)
    assert caught.value.reason == "missing"


@pytest.mark.parametrize(
    ("file", "change", "words"),
    [
        ("frames.csv", lambda rows: [], "no rows"),
        ("frames.csv", lambda rows: [*rows[:3], rows[3].rsplit(",", 3)[0]], "line 5 has 3 of 6"),
        ("frames.csv", lambda rows: [rows[0].replace("right", "green"), *rows[1:]], "laser is 'green'"),
        ("frames.csv", lambda rows: [rows[0].replace("ccw", "up"), *rows[1:]], "sweep is 'up'"),
        ("frames.csv", lambda rows: [rows[0], rows[0]], "named twice"),
        (
            "frames.csv",
            lambda rows: [rows[0].replace("frames/", "../frames/"), *rows[1:]],
            "no file inside the recording",
        ),
        ("encoder.csv", lambda rows: [*rows[:5], "nan,3", *rows[5:]], "line 7: time_s is 'nan'"),
        ("encoder.csv", lambda rows: [*rows[:5], rows[2], *rows[5:]], "line 7: time goes back"),
    ],
)
def test_a_broken_table_is_named_with_its_line(scan_copy, edit_csv, file, change, words):
    edit_csv(scan_copy / file, change)

    with pytest.raises(RecordingError) as caught:
        open_recording(scan_copy)
    assert words in str(caught.value)


@pytest.mark.parametrize("file", ["frames.csv", "encoder.csv", "recording.toml"])
def test_a_missing_table_is_named(scan_copy, file):
    (scan_copy / file).unlink()

    with pytest.raises(RecordingError, match=file):
        open_recording(scan_copy)


def test_a_recording_of_a_newer_version_is_refused(scan_copy):
    path = scan_copy / "recording.toml"
    path.write_text(path.read_text().replace("footscan-recording/1", "footscan-recording/9"))

    with pytest.raises(ConfigError, match="footscan-recording/9"):
        open_recording(scan_copy)


def test_a_folder_that_is_none_is_said_to_be_none(tmp_path):
    with pytest.raises(RecordingError, match="is no folder"):
        open_recording(tmp_path / "nowhere")
