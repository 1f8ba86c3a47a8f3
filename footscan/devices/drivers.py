"""The driver of each kind of real device that a rig file may name."""

from footscan.config.device_models import FileCameraModel, QsbModel, V4l2CameraModel
from footscan.config.io_models import AdamModel
from footscan.devices.adam_io import AdamIo
from footscan.devices.file_camera import open_file_camera
from footscan.devices.grabbing import GrabbingCamera
from footscan.devices.pictures import View
from footscan.devices.qsb_encoder import QsbEncoder
from footscan.devices.v4l2_camera import OpenCapture, open_capture, open_v4l2_camera


def open_camera(
    model: V4l2CameraModel | FileCameraModel, view: View, opener: OpenCapture = open_capture
) -> GrabbingCamera:
    """Open a camera; an emulated one comes from another opener.

    Raises:
        CameraLostError: It is not there, not permitted, or used by another program.
        WrongDeviceError: It delivers another size.
    """
    if isinstance(model, FileCameraModel):
        return open_file_camera(model, view)
    return open_v4l2_camera(model, view, opener)


def open_encoder(model: QsbModel) -> QsbEncoder:
    """Open an encoder.

    Raises:
        EncoderLostError: No port, no answer, or no sample.
        WrongDeviceError: What answers is no QSB.
    """
    return QsbEncoder(model)


def open_io(model: AdamModel) -> AdamIo:
    """Open a digital I/O module; everything is off then.

    Raises:
        OutputsLostError: No port or no answer.
        WrongDeviceError: Another module answers.
    """
    return AdamIo(model)
