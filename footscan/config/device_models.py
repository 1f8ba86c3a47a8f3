"""`[devices]` of a rig file: which camera, encoder and digital I/O module, and how they are reached."""

from typing import Literal

from pydantic import Field

from footscan.config.toml_file import Strict


class SimulatedCamera(Strict):
    """A camera that looks into the simulated world."""

    kind: Literal["simulated"]
    exposure_s: float = Field(default=0.004, gt=0, le=0.1)


class SimulatedEncoder(Strict):
    """The encoder of the simulated head."""

    kind: Literal["simulated"]
    samples_per_s: float = Field(default=500.0, gt=20, le=5000)


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
        person: The person stands as people do, or perfectly still.
        obstacles: What else is in the way.
        time: As fast as the wall clock, or as fast as this computer can.
    """

    object: str = "foot"
    unit: Literal["mm", "cm", "m"] = "mm"
    size: float = Field(default=1.0, ge=0.45, le=1.2)
    seed: int | None = Field(default=1, ge=0)
    person: Literal["still", "sways"] = "sways"
    time: Literal["real", "fast"] = "real"


class DevicesModel(Strict):
    """`[devices]`."""

    camera: SimulatedCamera
    encoder: SimulatedEncoder
    io: SimulatedIo
    world: WorldModel | None = None

    @property
    def simulated(self) -> bool:
        """Some device is simulated."""
        return "simulated" in (self.camera.kind, self.encoder.kind, self.io.kind)
