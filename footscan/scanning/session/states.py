"""What the machine is doing, in words a person understands, and what the screen shows of it."""

from dataclasses import dataclass, field
from enum import Enum


class State(Enum):
    """What happens now; the value is what the person at the machine reads."""

    CONNECTED = "connected: home the head first"
    HOMING = "the head looks for its home"
    PARKED = "step on: the head is parked, motor and lasers are off"
    CHECKING = "checking before the scan"
    COUNTDOWN = "stand still: the scan is about to begin"
    SCANNING = "scanning: stand still"
    RETURNING = "the head returns, lasers are off"
    DONE = "done: step off"
    STOPPED = "stopped: lasers and motor are off"
    CALIBRATING = "calibrating: keep hands and faces away from the head"
    HOLDING = "the laser is held on"
    FAULT = "fault: lasers and motor are off"
    CLOSED = "closed"


BUSY = (
    State.HOMING,
    State.CHECKING,
    State.COUNTDOWN,
    State.SCANNING,
    State.RETURNING,
    State.HOLDING,
    State.CALIBRATING,
)


@dataclass(frozen=True)
class Finding:
    """One thing the check before a scan has found.

    Attributes:
        cause: Its name, the same on every machine.
        sentence: What was seen and what to do.
        blocking: A scan would be useless or unsafe.
    """

    cause: str
    sentence: str
    blocking: bool = True


@dataclass(frozen=True)
class FrameCount:
    """captured = kept + rejected by name; `lost` never arrived (a gap in the camera's numbers)."""

    captured: int = 0
    kept: int = 0
    rejected: dict[str, int] = field(default_factory=dict)
    lost: int = 0


@dataclass(frozen=True)
class LiveCount:
    """given = shown + skipped by name."""

    given: int = 0
    shown: int = 0
    skipped: dict[str, int] = field(default_factory=dict)


@dataclass(frozen=True)
class Snapshot:
    """The machine at a moment, for the screen.

    Attributes:
        state: What it does.
        message: The last thing a person was told.
        theta_deg: The head's angle, None before homing.
        lasers: Which lasers are on.
        motor_on: The motor is on.
        armed: Lasers and motor may be switched on.
        estop_ok: The emergency stop is closed.
        progress: Of the scan, 0 to 1.
        remaining_s: Of the scan.
        frames: Of the scan's recording.
        live: Of the live view.
        findings: Of the last check.
    """

    state: State
    message: str = ""
    theta_deg: float | None = None
    lasers: tuple[str, ...] = ()
    motor_on: bool = False
    armed: bool = False
    estop_ok: bool = True
    progress: float = 0.0
    remaining_s: float = 0.0
    frames: FrameCount = field(default_factory=FrameCount)
    live: LiveCount = field(default_factory=LiveCount)
    findings: tuple[Finding, ...] = ()
