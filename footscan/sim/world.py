"""The simulated world: a foot on the board of a true machine, its head, motor and lasers, and what goes wrong.

Time is the rig's clock; the world catches up whenever a device looks at it. All devices share one world.
"""

import threading
from dataclasses import dataclass, field, replace
from typing import Literal, get_args

import numpy as np

from footscan.coordinates import Floats, Ints, LaserName
from footscan.devices.carriage import Drive
from footscan.devices.clock import Clock
from footscan.devices.values import ALL_OFF, Inputs, Outputs
from footscan.sim.drive import STEP_S, HeadDrive
from footscan.sim.io_module import IoModule
from footscan.sim.machine import TrueMachine
from footscan.sim.motion import count_from_theta
from footscan.sim.picture import DEFAULT_PICTURE, PictureSettings
from footscan.sim.standing import Standing

Trouble = Literal[
    "camera-frozen",
    "encoder-silent",
    "encoder-jump",
    "stall",
    "estop",
    "io-silent",
    "io-reset",
    "wrong-way",
    "right-laser-dead",
    "left-laser-dead",
]
TROUBLES: tuple[Trouble, ...] = get_args(Trouble)
_DEAD_LASER: dict[LaserName, Trouble] = {"right": "right-laser-dead", "left": "left-laser-dead"}
_LIGHT_KEPT = 4000
JUMP_COUNTS = 700


@dataclass(frozen=True)
class WorldSettings:
    """What the head, its switches and the motor are like.

    Attributes:
        drive: Speeds, acceleration, travel.
        home_rad: Where the home switch closes (below it, it is closed).
        ripple: Of the motor's speed.
        picture: Light and sensor.
        seed: Of ripple, noise and the angle at power-on.
    """

    drive: Drive
    home_rad: float
    ripple: float = 0.01
    picture: PictureSettings = DEFAULT_PICTURE
    seed: int = 0


@dataclass(frozen=True)
class LightChange:
    """From this moment the lasers shine like this."""

    time_s: float
    lasers: tuple[LaserName, ...]


@dataclass
class _Faults:
    at_s: dict[Trouble, float] = field(default_factory=dict)

    def active(self, trouble: Trouble, time_s: float) -> bool:
        return time_s >= self.at_s.get(trouble, np.inf)


class World:
    """Everything outside the computer; safe to look at from several threads."""

    def __init__(
        self,
        machine: TrueMachine,
        standing: Standing,
        settings: WorldSettings,
        clock: Clock,
        module: IoModule | None = None,
    ) -> None:
        self.machine, self.standing, self.settings, self.clock = machine, standing, settings, clock
        self.module = module or IoModule()
        self.start_s = clock.now_s()
        random = np.random.default_rng([settings.seed, 0x9053E])
        first_rad = float(random.uniform(settings.home_rad, 2.0 * np.pi))
        drive = settings.drive
        self._head = HeadDrive(first_rad, drive.acceleration_rad_s2, settings.ripple, settings.seed, self.start_s)
        self._first_count = int(count_from_theta(np.array([first_rad]), machine.calibration.encoder)[0])
        self._lock = threading.RLock()
        self._faults = _Faults()
        self._light: list[LightChange] = [LightChange(self.start_s, ())]
        self._off_since_s: float | None = self.start_s
        self._button = False

    def inject(self, trouble: Trouble, at_s: float | None = None) -> None:
        """Something goes wrong, now or at a moment of the clock."""
        with self._lock:
            self._faults.at_s[trouble] = self.clock.now_s() if at_s is None else at_s

    def mend(self, trouble: Trouble) -> None:
        """It is repaired."""
        with self._lock:
            self.catch_up()
            self._faults.at_s.pop(trouble, None)
            self._head.blocked = False

    def put(self, standing: Standing) -> None:
        """Something else stands on the board from now on."""
        self.standing = standing

    def press_button(self, pressed: bool) -> None:
        """The start/stop button on the machine."""
        self._button = pressed

    def silent_since(self, trouble: Trouble) -> float:
        """When something goes or went wrong; infinity if never."""
        return self._faults.at_s.get(trouble, np.inf)

    def suffers(self, trouble: Trouble, time_s: float) -> bool:
        """Whether something is wrong at a moment."""
        return self._faults.active(trouble, time_s)

    def set_outputs(self, outputs: Outputs) -> None:
        """The module is told to switch."""
        with self._lock:
            self.catch_up()
            self.module.set(outputs, self.clock.now_s())
            self._note_light(self.clock.now_s())

    def outputs(self) -> Outputs:
        """What the module switches now."""
        with self._lock:
            return self.module.outputs_at(self.catch_up())

    def arm_watchdog(self, timeout_s: float) -> None:
        """The module's watchdog runs from now on."""
        with self._lock:
            self.module.arm(timeout_s, self.catch_up())

    def feed_watchdog(self) -> None:
        """The module hears from the computer."""
        with self._lock:
            self.module.feed(self.catch_up())

    def catch_up(self) -> float:
        """Let the world's time pass up to the clock's; returns that moment."""
        with self._lock:
            now_s = self.clock.now_s()
            while now_s - self._head.now_s >= STEP_S:
                began_s = self._head.now_s
                next_s = min((moment for moment in self._events() if began_s < moment < now_s), default=now_s)
                self._pass(max(next_s, began_s + STEP_S))
            self._note_light(now_s)
            return now_s

    def theta_at(self, time_s: Floats) -> Floats:
        """True head angles at some recent moments."""
        with self._lock:
            self.catch_up()
            return self._head.theta_at(time_s)

    def counts_at(self, time_s: Floats) -> Ints:
        """What the counter showed: zero at power-on."""
        counts = count_from_theta(self.theta_at(time_s), self.machine.calibration.encoder) - self._first_count
        jumped = time_s >= self._faults.at_s.get("encoder-jump", np.inf)
        return counts + np.where(jumped, JUMP_COUNTS, 0)

    def lasers_at(self, time_s: float) -> tuple[LaserName, ...]:
        """Which lasers shone."""
        with self._lock:
            self.catch_up()
            for change in reversed(self._light):
                if change.time_s <= time_s:
                    return change.lasers
            return ()

    def inputs(self) -> Inputs:
        """The module's inputs now."""
        with self._lock:
            now_s = self.catch_up()
            self.module.outputs_at(now_s)
            return Inputs(
                now_s,
                estop_ok=not self.suffers("estop", now_s),
                home=self._head.theta_rad < self.settings.home_rad,
                button=self._button,
                module_reset=self.module.take_restart(),
                watchdog_tripped=self.module.tripped,
            )

    @property
    def off_since_s(self) -> float | None:
        """Since when lasers and motor have had no supply or no command; None while something is on."""
        with self._lock:
            self.catch_up()
            return self._off_since_s

    def _events(self) -> list[float]:
        trips = self.module.trips_at_s
        return [*self._faults.at_s.values(), *([] if trips is None else [trips])]

    def _pass(self, until_s: float) -> None:
        began_s = self._head.now_s
        if self.suffers("io-reset", began_s) and not self.module.restarted:
            self._faults.at_s.pop("io-reset")
            self.module.lose_power()
        self._head.blocked = self.suffers("stall", began_s)
        self._note_light(began_s)
        self._head.turn_until(until_s, self._asked_rad_s(began_s))

    def _effective(self, time_s: float) -> Outputs:
        """What lasers and motor get: nothing while the emergency stop is open."""
        outputs = self.module.outputs_at(time_s)
        return replace(ALL_OFF, lamp=outputs.lamp) if self.suffers("estop", time_s) else outputs

    def _asked_rad_s(self, time_s: float) -> float:
        outputs = self._effective(time_s)
        if not outputs.motor_run:
            return 0.0
        clockwise = outputs.motor_reverse != self.suffers("wrong-way", time_s)
        return (-1.0 if clockwise else 1.0) * self.settings.drive.speeds_rad_s[outputs.speed_step]

    def _note_light(self, time_s: float) -> None:
        outputs = self._effective(time_s)
        shining: tuple[LaserName, ...] = tuple(
            name for name in outputs.lasers if not self.suffers(_DEAD_LASER[name], time_s)
        )
        if shining != self._light[-1].lasers:
            self._light = [*self._light[-_LIGHT_KEPT:], LightChange(time_s, shining)]
        if outputs.dangerous:
            self._off_since_s = None
        elif self._off_since_s is None:
            self._off_since_s = time_s
