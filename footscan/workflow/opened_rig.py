"""`OpenedRig`: a rig with its devices, as `app` hands it out."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from footscan.config.rig_file import Rig
from footscan.coordinates import Side
from footscan.scanning.session.assembly import RigDevices
from footscan.sim.world import World

if TYPE_CHECKING:
    from footscan.sim.emulators.emulated_rig import EmulatedRig


@dataclass(frozen=True)
class OpenedRig:
    """A rig whose devices are open.

    Attributes:
        rig: Its file.
        devices: To be given to a `Session`, which closes them.
        world: What the simulated devices live in; None on a real machine.
        put_on_board: Lets another foot step onto the simulated board; None on a real machine.
        put_calibration_board: Puts the printed board at a placement; None clears the simulated footboard.
        emulated: Emulators behind ports, if the rig has any.
        give_back: To be called once the session is closed.
    """

    rig: Rig
    devices: RigDevices
    world: World | None
    put_on_board: Callable[[Side], None] | None
    put_calibration_board: Callable[[int | None], None] | None = None
    emulated: "EmulatedRig | None" = None
    give_back: Callable[[], None] = lambda: None
