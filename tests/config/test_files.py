import math
from pathlib import Path

import pytest

from footscan.config import (
    calibration_toml,
    file_kind,
    load_board,
    load_calibration,
    load_recording_info,
    load_scanner,
    recording_toml,
    save_calibration,
    scanner_toml,
)
from footscan.config.recording_file import RecordingInfo, Subject
from footscan.config.rig_file import load_rig
from footscan.config.toml_file import write_whole
from footscan.errors import ConfigError, StorageError


@pytest.fixture
def calibration_path(tmp_path: Path, workshop) -> Path:
    save_calibration(workshop, tmp_path / "cal.toml")
    return tmp_path / "cal.toml"


def replaced(path: Path, old: str, new: str) -> Path:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    return path


def test_a_calibration_comes_back_from_its_file(calibration_path, workshop):
    again = load_calibration(calibration_path)

    assert again.camera == workshop.camera
    assert again.lasers[1].normal == pytest.approx(workshop.lasers[1].normal, abs=1e-15)
    assert again.pose.phi_rad == pytest.approx(workshop.pose.phi_rad, abs=1e-15)
    assert again.encoder.eccentricity_phase_rad == pytest.approx(workshop.encoder.eccentricity_phase_rad, abs=1e-14)
    assert calibration_toml(load_calibration(calibration_path)).count(b"[[laser]]") == 2


def test_a_scanner_comes_back_from_its_file(tmp_path, prototype):
    write_whole(tmp_path / "scanner.toml", scanner_toml(prototype))
    again = load_scanner(tmp_path / "scanner.toml")

    assert again.camera == prototype.camera
    assert again.head.phi_rad == pytest.approx(prototype.head.phi_rad, abs=1e-14)
    assert [laser.name for laser in again.lasers] == ["right", "left"]


def test_what_is_known_of_a_subject_is_kept_and_nothing_else(tmp_path):
    info = RecordingInfo("scan", "left", "2026-11-21T12:00:00+00:00", "n", Subject(load="seated", absent=("toe_5",)))
    write_whole(tmp_path / "recording.toml", recording_toml(info))

    assert load_recording_info(tmp_path / "recording.toml") == info
    assert b"surface_mm" not in recording_toml(info)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("focal_length_mm", "focal_lenght_mm", ["camera.focal_lenght_mm", "unknown"]),
        ("latency_s = ", "latency_s = nan # ", ["timing.latency_s", "finite"]),
        ("direction = 1", "direction = 2", ["encoder.direction", "2", "1 or -1"]),
        ('name = "right"', 'name = "left"', ["laser", "right"]),
        ("width_px = 582", 'width_px = "582"', ["camera.width_px", "'582'", "integer"]),
        ("footscan-calibration/1", "footscan-calibration/2", ["footscan-calibration/2", "footscan-calibration/1"]),
        ("footscan-calibration/1", "footscan-scanner/1", ["footscan-scanner/1", "allowed"]),
        ("created = ", "# created = ", ["created", "missing"]),
        ("[pose]", "[pose", ["not valid TOML"]),
    ],
)
def test_a_mistake_in_a_calibration_is_named_with_file_and_key(calibration_path, old, new, words):
    path = replaced(calibration_path, old, new)

    with pytest.raises(ConfigError) as caught:
        load_calibration(path)
    for word in [str(path), *words]:
        assert word in str(caught.value)


def test_a_normal_that_is_no_unit_vector_is_refused(tmp_path, ideal):
    save_calibration(ideal, tmp_path / "cal.toml")
    replaced(tmp_path / "cal.toml", "-0.707106781186547", "-0.8")

    with pytest.raises(ConfigError, match="length 1"):
        load_calibration(tmp_path / "cal.toml")


def test_a_marker_larger_than_its_square_is_refused(tmp_path):
    (tmp_path / "board.toml").write_text(
        'format = "footscan-board/1"\nsquares_x = 7\nsquares_y = 5\nsquare_mm = 30.0\nmarker_mm = 32.0\n'
        'dictionary = "DICT_4X4_50"\n'
    )

    with pytest.raises(ConfigError, match="smaller than its square"):
        load_board(tmp_path / "board.toml")


def test_a_missing_file_is_said_to_be_missing(tmp_path):
    with pytest.raises(ConfigError, match="does not exist"):
        load_scanner(tmp_path / "nothing.toml")


def test_a_file_without_a_format_has_no_kind(tmp_path):
    (tmp_path / "x.toml").write_text("a = 1\n")

    with pytest.raises(ConfigError, match="format"):
        file_kind(tmp_path / "x.toml")


def test_every_shipped_design_loads_and_is_called_by_its_file():
    files = sorted((Path(__file__).parents[2] / "configs").glob("*.toml"))
    designs = [path for path in files if file_kind(path) == "scanner"]
    rigs = [path for path in files if path not in designs]

    assert {path.stem for path in designs} == {"prototype", "usb3-1440"}
    assert {path.stem for path in rigs} >= {"sim", "rig-qsb-adam", "rig-dcon", "rig-emulated"}
    for path in designs:
        assert load_scanner(path).name == path.stem
    for path in rigs:
        assert load_rig(path).profile(None).name == "standard"


def test_the_modern_design_sees_a_foot_finer_than_the_prototype():
    prototype, modern = (
        load_scanner(Path(__file__).parents[2] / f"configs/{n}.toml") for n in ("prototype", "usb3-1440")
    )
    mm_per_px = [s.camera.pixel_pitch_y_mm / s.camera.focal_length_mm for s in (modern, prototype)]

    assert mm_per_px[0] < mm_per_px[1]
    assert modern.camera.width_px * mm_per_px[0] > 0.85 * prototype.camera.width_px * mm_per_px[1]
    assert math.degrees(modern.head.phi_rad) == pytest.approx(23.0)


def test_nothing_half_written_is_left_when_the_disk_refuses(tmp_path, monkeypatch):
    def full(_):
        raise OSError(28, "No space left on device")

    (tmp_path / "a.json").write_bytes(b"old")
    monkeypatch.setattr("footscan.config.toml_file.os.fsync", full)

    with pytest.raises(StorageError, match="No space left"):
        write_whole(tmp_path / "a.json", b"new")
    assert (tmp_path / "a.json").read_bytes() == b"old"
    assert [path.name for path in tmp_path.iterdir()] == ["a.json"]
