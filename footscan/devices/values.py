"""What devices say: frozen values, times on the rig's clock in seconds."""

from dataclasses import dataclass

from footscan.coordinates import Floats, Frame, Ints, LaserName


@dataclass(frozen=True)
class CameraFacts:
    """What a camera really delivers, read back from it.

    Attributes:
        name: Model or path, for people.
        width_px: Of the delivered picture.
        height_px: Of the delivered picture.
        frames_per_s: Asked for.
        exposure_s: Of one frame; how long its light is collected.
        notes: What the driver did with each setting, for people.
    """

    name: str
    width_px: int
    height_px: int
    frames_per_s: float
    exposure_s: float
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class CameraFrame:
    """One upright frame `(height, width)` uint8, its stamp, and the camera's running number: a gap is a lost frame."""

    frame: Frame
    time_s: float
    number: int


@dataclass(frozen=True)
class EncoderReading:
    """The counter at a moment."""

    count: int
    time_s: float


@dataclass(frozen=True)
class EncoderSamples:
    """Times `(n,)` (s) and counts `(n,)`, in order of time."""

    time_s: Floats
    count: Ints

    def __len__(self) -> int:
        return len(self.time_s)


@dataclass(frozen=True)
class Outputs:
    """Everything the module switches.

    Attributes:
        laser_right: The right laser shines.
        laser_left: The left laser shines.
        motor_run: The motor turns.
        motor_reverse: It turns clockwise seen from above.
        speed_step: Which of the drive's speeds, 0 the slowest.
        lamp: The lamp that says "in use".
        buzzer: The buzzer sounds.
    """

    laser_right: bool = False
    laser_left: bool = False
    motor_run: bool = False
    motor_reverse: bool = False
    speed_step: int = 0
    lamp: bool = False
    buzzer: bool = False

    @property
    def lasers(self) -> tuple[LaserName, ...]:
        """Names of the lasers that shine."""
        shining: list[LaserName] = ["right"] if self.laser_right else []
        return (*shining, "left") if self.laser_left else tuple(shining)

    @property
    def dangerous(self) -> bool:
        """A laser shines or the motor turns."""
        return self.laser_right or self.laser_left or self.motor_run


ALL_OFF = Outputs()


@dataclass(frozen=True)
class Inputs:
    """What the module reads.

    Attributes:
        time_s: When.
        estop_ok: The emergency stop's contact is closed; open means that lasers and motor have no supply.
        home: The head is beyond the home switch.
        button: The start/stop button on the machine is pressed.
        module_reset: The module has restarted since it was last asked (power was lost).
        watchdog_tripped: The module has switched its outputs off because nobody fed its watchdog.
    """

    time_s: float
    estop_ok: bool
    home: bool
    button: bool = False
    module_reset: bool = False
    watchdog_tripped: bool = False
