import time
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest

from footscan.config.device_models import FileCameraModel, V4l2CameraModel
from footscan.devices.file_camera import open_file_camera
from footscan.devices.grabbing import FrameNumbers, GrabbingCamera
from footscan.devices.pictures import View, frame_from_picture
from footscan.devices.v4l2_camera import open_v4l2_camera
from footscan.errors import CameraLostError, WrongDeviceError
from footscan.sim.emulators.capture import Abilities, EmulatedCameraPlug
from tests.devices.contracts import CameraContract

VIEW = View(64, 48, 25.0)
V4L2 = {"kind": "v4l2", "path": "emulated"}


def picture(number: int, height: int = 48, width: int = 64) -> np.ndarray:
    rows, columns = np.mgrid[:height, :width]
    return ((3 * rows + 2 * columns + number) % 256).astype(np.uint8)


def camera_plug(**abilities) -> EmulatedCameraPlug:
    return EmulatedCameraPlug(lambda time_s: picture(0), Abilities(**{"sizes": ((640, 480), (64, 48)), **abilities}))


def first_frame(camera: GrabbingCamera) -> np.ndarray:
    camera.start()
    frame = camera.read(3.0).frame
    camera.close()
    return frame


class _EmulatedV4l2(CameraContract):
    @pytest.fixture
    def plug(self) -> EmulatedCameraPlug:
        return camera_plug()

    @pytest.fixture
    def device(self, plug) -> Iterator[GrabbingCamera]:
        camera = open_v4l2_camera(V4l2CameraModel(**V4L2), VIEW, plug.open)
        yield camera
        camera.close()


class TestV4l2Unplugged(_EmulatedV4l2):
    @pytest.fixture
    def silence(self, plug):
        return plug.unplug


class TestV4l2WithAClockOfItsOwn(_EmulatedV4l2):
    @pytest.fixture
    def plug(self) -> EmulatedCameraPlug:
        return camera_plug(monotonic=False)


class _FileCamera(CameraContract):
    @pytest.fixture
    def device(self, path) -> Iterator[GrabbingCamera]:
        camera = open_file_camera(FileCameraModel(kind="file", path=str(path)), VIEW)
        yield camera
        camera.close()


class TestVideoFile(_FileCamera):
    @pytest.fixture
    def path(self, tmp_path) -> Path:
        return write_video(tmp_path / "scan.avi", 30)


class TestFolderOfPictures(_FileCamera):
    @pytest.fixture
    def path(self, tmp_path) -> Path:
        return write_folder(tmp_path / "frames", 6)


class TestVideoFileThatEnds(_FileCamera):
    @pytest.fixture
    def device(self, tmp_path) -> Iterator[GrabbingCamera]:
        path = write_video(tmp_path / "scan.avi", 20)
        camera = open_file_camera(FileCameraModel(kind="file", path=str(path), repeat=False), VIEW)
        yield camera
        camera.close()

    @pytest.fixture
    def silence(self):
        return lambda: None  # it ends by itself

    def test_a_camera_that_sends_nothing_is_lost_in_words(self, device, silence):
        with pytest.raises(CameraLostError, match="has ended; let it repeat"):
            self.some_frames(device, 40)


def write_video(path: Path, count: int) -> Path:
    writer = cv2.VideoWriter(str(path), cv2.CAP_FFMPEG, cv2.VideoWriter.fourcc(*"FFV1"), 25.0, (64, 48), isColor=False)
    assert writer.isOpened()
    for number in range(count):
        writer.write(picture(number))
    writer.release()
    return path


def write_folder(folder: Path, count: int) -> Path:
    folder.mkdir()
    for number in range(count):
        cv2.imwrite(str(folder / f"{number:04d}.png"), picture(number))
    return folder


@pytest.mark.parametrize("fourcc", ["GREY", "YUYV"])
@pytest.mark.parametrize("convert", [True, False])
def test_the_same_picture_arrives_with_and_without_conversion(fourcc, convert):
    model = V4l2CameraModel(**V4L2, fourcc=fourcc, convert=convert)
    frame = first_frame(open_v4l2_camera(model, VIEW, camera_plug().open))

    assert np.array_equal(frame, picture(0))


def test_pictures_of_a_file_arrive_unchanged_and_in_order(tmp_path):
    for path in (write_video(tmp_path / "a.avi", 12), write_folder(tmp_path / "a", 12)):
        camera = open_file_camera(FileCameraModel(kind="file", path=str(path)), VIEW)
        camera.start()
        frames = [camera.read(3.0) for _ in range(5)]
        camera.close()

        assert all(np.array_equal(frame.frame, picture(frame.number)) for frame in frames)


def test_an_upside_down_camera_is_turned():
    view = View(64, 48, 25.0, rotation_deg=180)
    frame = first_frame(open_v4l2_camera(V4l2CameraModel(**V4L2), view, camera_plug().open))

    assert np.array_equal(frame, picture(0)[::-1, ::-1])
    assert frame.flags["C_CONTIGUOUS"]


@pytest.mark.parametrize(("field", "first"), [("top", 0), ("bottom", 1)])
def test_one_field_of_interlaced_video_has_half_the_rows(field, first):
    model = V4l2CameraModel(**V4L2, field=field)
    frame = first_frame(open_v4l2_camera(model, View(64, 24, 25.0), camera_plug().open))

    assert np.array_equal(frame, picture(0)[first::2])


def test_the_red_of_a_colour_picture_is_where_the_laser_is():
    model = FileCameraModel(kind="file", path="x", channel="red")
    coloured = np.dstack([picture(0), picture(50), picture(100)])

    assert np.array_equal(frame_from_picture(coloured, model, VIEW), picture(100))


@pytest.mark.parametrize("shape", [(48, 63), (47, 64), (1, 64 * 48 + 1), (64, 48), (48, 64, 4)])
def test_a_picture_of_another_size_is_refused(shape):
    with pytest.raises(ValueError, match=r"pixels, expected are 64 x 48"):
        frame_from_picture(np.zeros(shape, np.uint8), FileCameraModel(kind="file", path="x"), VIEW)


def test_sixteen_bit_pictures_are_refused():
    with pytest.raises(ValueError, match="uint16"):
        frame_from_picture(np.zeros((48, 64), np.uint16), FileCameraModel(kind="file", path="x"), VIEW)


def test_every_setting_is_read_back_and_told():
    camera = open_v4l2_camera(V4l2CameraModel(**V4L2, gain=7, exposure_s=0.008), VIEW, camera_plug().open)
    facts = camera.facts()
    camera.close()

    assert facts.exposure_s == pytest.approx(0.008)
    assert facts.notes == (
        "pixel format: GREY",
        "colour conversion: 1",
        "height: 48",
        "width: 64",
        "frames per second: 25",
        "manual exposure: 1",
        "exposure (0.1 ms): 80",
        "gain: 7",
    )


def test_refused_settings_are_told():
    plug = camera_plug(rates=(15.0,), manual_exposure=False)
    camera = open_v4l2_camera(V4l2CameraModel(**V4L2), VIEW, plug.open)
    notes = camera.facts().notes
    camera.close()

    assert "frames per second: asked for 25, reads back 15" in notes
    assert "manual exposure: asked for 1, refused, reads back -1" in notes


def test_manual_exposure_that_needs_automatic_first_is_reached():
    plug = camera_plug(needs_automatic_first=True)
    camera = open_v4l2_camera(V4l2CameraModel(**V4L2), VIEW, plug.open)
    notes = camera.facts().notes
    camera.close()

    assert "manual exposure: 1" in notes


def test_a_camera_of_another_size_is_refused():
    with pytest.raises(WrongDeviceError, match="delivers 640 x 480 pixels instead of 64 x 48"):
        open_v4l2_camera(V4l2CameraModel(**V4L2), VIEW, camera_plug(sizes=((640, 480),)).open)


def test_stamps_are_the_drivers_where_its_clock_is_ours():
    exposed: list[float] = []
    plug = EmulatedCameraPlug(lambda t: exposed.append(t) or picture(0), Abilities(sizes=((64, 48),)))
    camera = open_v4l2_camera(V4l2CameraModel(**V4L2), VIEW, plug.open)
    camera.start()
    stamps = [camera.read(3.0).time_s for _ in range(4)]
    camera.close()

    assert stamps == pytest.approx(exposed[:4], abs=1e-6)


@pytest.mark.parametrize("trouble", ["unplug", "freeze"])
def test_a_lost_camera_is_noticed_long_before_opencvs_ten_seconds_and_found_again(trouble):
    plug = camera_plug()
    camera = open_v4l2_camera(V4l2CameraModel(**V4L2), VIEW, plug.open)
    camera.start()
    before = camera.read(3.0)
    began_s = time.monotonic()
    plug.unplug() if trouble == "unplug" else plug.frozen.set()
    with pytest.raises(CameraLostError, match="has sent nothing"):
        while time.monotonic() < began_s + 5.0:
            camera.read(5.0)
    noticed_s = time.monotonic() - began_s
    plug.plug()
    plug.frozen.clear()
    after = read_again(camera)
    camera.close()

    assert noticed_s < 4.0
    assert after.number - before.number > 5
    assert after.time_s > before.time_s + 0.2


def read_again(camera: GrabbingCamera):
    for _ in range(100):
        try:
            return camera.read(0.1)
        except CameraLostError:
            time.sleep(0.05)
    raise AssertionError


def test_a_missing_camera_is_said():
    with pytest.raises(CameraLostError, match=r"/dev/video99 does not exist; plug the device in.*v4l/by-id"):
        open_v4l2_camera(V4l2CameraModel(kind="v4l2", path="/dev/video99"), VIEW)


def test_something_that_is_no_camera_is_said(tmp_path):
    (tmp_path / "video").write_bytes(b"")

    with pytest.raises(CameraLostError, match="is no camera, or another program uses it"):
        open_v4l2_camera(V4l2CameraModel(kind="v4l2", path=str(tmp_path / "video")), VIEW)


@pytest.mark.parametrize("name", ["nothing.avi", "empty", "text.avi"])
def test_a_file_without_pictures_is_said(tmp_path, name):
    (tmp_path / "empty").mkdir()
    (tmp_path / "text.avi").write_text("no video")

    with pytest.raises(CameraLostError, match="give a video file or a folder"):
        open_file_camera(FileCameraModel(kind="file", path=str(tmp_path / name)), VIEW)


def test_pictures_of_another_size_are_refused_at_the_start(tmp_path):
    path = write_folder(tmp_path / "frames", 2)

    with pytest.raises(WrongDeviceError, match="delivers 64 x 48 pixels, expected are 582 x 500"):
        open_file_camera(FileCameraModel(kind="file", path=str(path)), View(582, 500, 25.0))


def test_frames_that_nobody_reads_are_gaps_in_the_numbers(tmp_path):
    camera = open_file_camera(
        FileCameraModel(kind="file", path=str(write_folder(tmp_path / "f", 3))), View(64, 48, 200.0)
    )
    camera.start()
    camera.read(1.0)
    time.sleep(0.5)
    numbers = [camera.read(1.0).number for _ in range(5)]
    camera.close()

    assert numbers[0] > 30
    assert np.all(np.diff(numbers) >= 1)


def test_numbers_skip_what_the_driver_lost_at_any_real_rate():
    numbers = FrameNumbers(25.0)
    times = [number / 15.0 for number in range(60) if number not in (40, 41)]
    counted = [numbers.next(time_s) for time_s in times]

    assert counted[-1] - counted[-10] == 9
    assert counted[40] - counted[39] == 3
    assert numbers.frames_per_s == pytest.approx(15.0)
