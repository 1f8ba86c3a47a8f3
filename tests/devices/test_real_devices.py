"""The contracts on the devices of a real machine: `pytest -m hardware --rig=FILE`. Lasers and motor go on briefly."""

from collections.abc import Iterator

import pytest

from footscan.config.device_models import FileCameraModel, QsbModel, V4l2CameraModel
from footscan.config.io_models import AdamModel
from footscan.config.port_name import EMULATED
from footscan.config.rig_file import Rig, load_rig
from footscan.devices.drivers import open_camera, open_encoder, open_io
from footscan.devices.pictures import View
from footscan.devices.protocols import Camera, DigitalIo, Encoder
from tests.devices.contracts import CameraContract, DigitalIoContract, EncoderContract

pytestmark = pytest.mark.hardware


@pytest.fixture
def rig(request: pytest.FixtureRequest) -> Rig:
    path = request.config.getoption("--rig")
    if path is None:
        pytest.skip("--rig=FILE names the real machine")
    rig = load_rig(path)
    if rig.devices.emulated:
        pytest.skip("its devices are emulated")
    return rig


class TestRealCamera(CameraContract):
    @pytest.fixture
    def device(self, rig: Rig) -> Iterator[Camera]:
        model, camera = rig.devices.camera, rig.scanner.camera
        if not isinstance(model, V4l2CameraModel | FileCameraModel) or model.path == EMULATED:
            pytest.skip("the rig has no real camera")
        opened = open_camera(
            model, View(camera.width_px, camera.height_px, rig.motion.frames_per_s, camera.image_rotation_deg)
        )
        yield opened
        opened.close()


class TestRealEncoder(EncoderContract):
    @pytest.fixture
    def device(self, rig: Rig) -> Iterator[Encoder]:
        if not isinstance(rig.devices.encoder, QsbModel):
            pytest.skip("the rig has no real encoder")
        opened = open_encoder(rig.devices.encoder)
        yield opened
        opened.close()


class TestRealIo(DigitalIoContract):
    @pytest.fixture
    def device(self, rig: Rig) -> Iterator[DigitalIo]:
        if not isinstance(rig.devices.io, AdamModel):
            pytest.skip("the rig has no real output module")
        opened = open_io(rig.devices.io)
        yield opened
        opened.close()
