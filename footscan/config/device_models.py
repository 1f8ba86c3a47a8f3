"""`[devices]` of a rig file: which camera, encoder and digital I/O module, and how they are reached."""

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from footscan.config.io_models import AdamModel
from footscan.config.port_name import EMULATED, PortName, refuse_relative
from footscan.config.toml_file import Strict, tuple_from_list

QSB_LINE_BYTES = 21
"""Of one streamed sample in the QSB's shortest form with a time stamp."""
QSB_TICKS_PER_S = 512


class SimulatedCamera(Strict):
    """A camera that looks into the simulated world."""

    kind: Literal["simulated"]
    exposure_s: float = Field(default=0.004, gt=0, le=0.1)


class PictureModel(Strict):
    """What becomes of each delivered picture.

    Attributes:
        exposure_s: Of one frame.
        field: Interlaced video combs when the stripe moves: keep the top or the bottom field's rows only.
        channel: What the grey value of a colour picture is: its luminance, or its red, where the laser is.
    """

    exposure_s: float = Field(default=0.004, gt=0, le=0.5)
    field: Literal["both", "top", "bottom"] = "both"
    channel: Literal["luminance", "red"] = "luminance"

    @property
    def rows_per_row(self) -> int:
        """Delivered rows for each row of the frame."""
        return 1 if self.field == "both" else 2


class V4l2CameraModel(PictureModel):
    """A camera or frame grabber of the Linux kernel.

    Attributes:
        path: /dev/v4l/by-id/...; it stays the same when other cameras are plugged in.
        fourcc: The pixel format asked for.
        convert: OpenCV turns pictures into BGR; without, GREY and YUYV arrive as the camera sends them.
        gain: Raw value of the driver's control.
        manual_exposure: The driver's menu entry for "manual" (1 in UVC); some want to be set to automatic first.
        input: Of a frame grabber with several sockets.
    """

    kind: Literal["v4l2"]
    path: Annotated[str, AfterValidator(refuse_relative)]
    fourcc: Literal["GREY", "YUYV", "MJPG"] = "GREY"
    convert: bool = True
    gain: int | None = Field(default=None, ge=0, le=100_000)
    manual_exposure: int = Field(default=1, ge=0, le=3)
    input: int | None = Field(default=None, ge=0, le=15)

    @model_validator(mode="after")
    def _decodable(self) -> "V4l2CameraModel":
        if self.fourcc == "MJPG" and not self.convert:
            raise ValueError('fourcc "MJPG" is compressed and needs convert = true')
        if self.channel == "red" and not (self.fourcc != "GREY" and self.convert):
            raise ValueError('channel "red" needs a colour fourcc (YUYV or MJPG) and convert = true')
        return self


class FileCameraModel(PictureModel):
    """A video file or a folder of pictures in name order, played at the rig's frame rate.

    Attributes:
        path: Of the file or folder.
        repeat: Start again at the end; without, the camera is lost there.
    """

    kind: Literal["file"]
    path: str = Field(min_length=1)
    repeat: bool = True


class SimulatedEncoder(Strict):
    """The encoder of the simulated head."""

    kind: Literal["simulated"]
    samples_per_s: float = Field(default=500.0, gt=20, le=5000)


class QsbModel(Strict):
    """A US Digital QSB that streams counts with its own time stamps.

    Attributes:
        port: /dev/serial/by-id/..., usb:SERIAL, or "emulated".
        baud: As set in the device (factory 230400).
        counting: Edges of the quadrature signal that count; `steps_per_rev` is what remains after this.
        interval_ticks: Between samples, in ticks of 1/512 s.
        keep_count: Do not set the counter to zero at the start.
        frame_trigger: The camera's strobe is wired to DIO 0: the count is latched at each frame.
    """

    kind: Literal["qsb"]
    port: PortName
    baud: Literal[9600, 19200, 38400, 115200, 230400] = 230400
    counting: Literal["x1", "x2", "x4"] = "x4"
    interval_ticks: int = Field(default=1, ge=1, le=25)
    keep_count: bool = False
    frame_trigger: bool = False

    @property
    def samples_per_s(self) -> float:
        """Streamed."""
        return QSB_TICKS_PER_S / self.interval_ticks

    @model_validator(mode="after")
    def _fits_the_line(self) -> "QsbModel":
        least = -(-QSB_TICKS_PER_S * QSB_LINE_BYTES * 10 // self.baud)
        if self.interval_ticks < least:
            raise ValueError(
                f"{self.samples_per_s:.0f} samples/s do not fit through {self.baud} baud, use interval_ticks = {least} "
                "or more, or set the QSB to a faster baud"
            )
        return self


class SimulatedIo(Strict):
    """The digital I/O module of the simulated world."""

    kind: Literal["simulated"]


class WorldModel(Strict):
    """`[devices.world]`: what the simulated devices live in.

    Attributes:
        object: What stands on the board: foot, another object of `footscan simulate`, or a mesh file.
        unit: Of the mesh file.
        size: Of the built-in foot.
        seed: Which workshop built the machine; without it the machine is exactly as designed.
        person: Stands like a statue, calm (breathing and pulse), or restless (sways, drifts, twitches).
        obstacles: What else is in the way.
        time: As fast as the wall clock, as fast as this computer can, or paced: like the wall clock, but standing still
            while a busy computer is behind, which spoils nothing.
        pace: Simulated seconds per second when paced.
        mirror: Unix socket of another process that keeps a twin of the output module (for the drill of a killed
            program).
    """

    object: str = "foot"
    unit: Literal["mm", "cm", "m"] = "mm"
    size: float = Field(default=1.0, ge=0.45, le=1.2)
    seed: int | None = Field(default=1, ge=0)
    person: Literal["statue", "calm", "restless"] = "calm"
    time: Literal["real", "fast", "paced"] = "real"
    pace: float = Field(default=1.0, gt=0.0, le=100.0)
    obstacles: Annotated[
        tuple[Literal["idle-leg", "handhold", "trouser-hem"], ...], BeforeValidator(tuple_from_list)
    ] = ()
    mirror: str | None = None


CameraModels = Annotated[SimulatedCamera | V4l2CameraModel | FileCameraModel, Field(discriminator="kind")]
EncoderModels = Annotated[SimulatedEncoder | QsbModel, Field(discriminator="kind")]
IoModels = Annotated[SimulatedIo | AdamModel, Field(discriminator="kind")]


class DevicesModel(Strict):
    """`[devices]`."""

    camera: CameraModels
    encoder: EncoderModels
    io: IoModels
    world: WorldModel | None = None

    @property
    def simulated(self) -> bool:
        """Some device is simulated."""
        return "simulated" in (self.camera.kind, self.encoder.kind, self.io.kind)

    @property
    def emulated(self) -> bool:
        """Some driver talks to an emulator."""
        return EMULATED in self._places()

    @model_validator(mode="after")
    def _consistent(self) -> "DevicesModel":
        for mistake in self._mistakes():
            raise ValueError(mistake)
        return self

    def _places(self) -> list[str]:
        camera = [self.camera.path] if isinstance(self.camera, V4l2CameraModel) else []
        encoder = [self.encoder.port] if isinstance(self.encoder, QsbModel) else []
        return [*camera, *encoder, *([self.io.port] if isinstance(self.io, AdamModel) else [])]

    def _mistakes(self) -> Iterator[str]:
        named = [place for place in self._places() if place != EMULATED]
        if len(set(named)) < len(named):
            yield f"two devices are on {named[-1]}, give each its own port"
        if self.emulated and self.world is None:
            yield 'a device is "emulated" but there is no [devices.world] for it to live in, add one'
        if self.emulated and self.world is not None and self.world.time != "real":
            yield 'emulated devices speak at their real speed, set time = "real" in [devices.world]'
