"""The machine as the programs see it: the head, the light, the frames, and small steps made of them."""

from collections.abc import Callable, Generator, Iterable
from dataclasses import dataclass, replace

import numpy as np

from footscan.config.rig_file import MotionModel
from footscan.coordinates import LaserName
from footscan.devices.carriage import Carriage
from footscan.devices.clock import Clock
from footscan.devices.interlock import Interlock, Purpose
from footscan.devices.values import ALL_OFF, CameraFacts, CameraFrame, Inputs
from footscan.errors import DeviceError, FootscanError, HeadStalledError
from footscan.optics.calibration import Calibration
from footscan.optics.scanner import Scanner
from footscan.scanning.session.grabber import Grabber
from footscan.scanning.session.keeper import ExposureTiming, Keeper, LightLog, Phase
from footscan.scanning.session.live import LiveView
from footscan.scanning.session.states import Finding, LiveCount, Snapshot, State

Program = Generator[None, None, None]
"""What the head does next, one step per round of the control thread."""

PARK_TOLERANCE_RAD = np.deg2rad(0.5)
_SLACK_S = 3.0


@dataclass
class Machine:
    """Everything a program may use; only the control thread calls it.

    Attributes:
        inputs: As read in this round.
        state: What a person is shown.
        message: The last thing a person was told.
        findings: Of the last check.
        progress: Of the scan, 0 to 1.
        remaining_s: Of the scan.
        wake_s: The next round is wanted at this moment at the latest.
        awaits_button: The button on the machine means start; else it means stop.
    """

    clock: Clock
    interlock: Interlock
    carriage: Carriage
    motion: MotionModel
    scanner: Scanner
    facts: CameraFacts
    grabber: Grabber
    keeper: Keeper
    live: LiveView | None
    log: LightLog
    calibration: Calibration | None
    inputs: Inputs
    state: State = State.CONNECTED
    message: str = ""
    findings: tuple[Finding, ...] = ()
    progress: float = 0.0
    remaining_s: float = 0.0
    wake_s: float = np.inf
    awaits_button: bool = False

    def snapshot(self) -> Snapshot:
        """What others may know of it, as it is now."""
        outputs = self.interlock.outputs
        return Snapshot(
            self.state,
            self.message,
            float(np.rad2deg(self.carriage.theta_rad)) if self.carriage.homed else None,
            outputs.lasers,
            outputs.motor_run,
            self.interlock.armed,
            self.inputs.estop_ok,
            self.progress,
            self.remaining_s,
            self.keeper.count(),
            self.live.count() if self.live else LiveCount(),
            self.findings,
        )

    @property
    def timing(self) -> ExposureTiming:
        """When a stamped frame saw its light."""
        latency_s = self.calibration.latency_s if self.calibration is not None else 0.0
        return ExposureTiming(latency_s, self.facts.exposure_s)

    @property
    def park_rad(self) -> float:
        """Where the head waits: between the home switch and the sweep."""
        return float(np.deg2rad(0.5 * (self.motion.home_deg + self.motion.sweep_deg[0])))

    @property
    def parked(self) -> bool:
        """The head has found its home and stands where it waits."""
        reach = self.carriage.drive.stopping_rad(0)
        return self.carriage.homed and abs(self.carriage.theta_rad - self.park_rad) <= PARK_TOLERANCE_RAD + reach

    def say(self, state: State, message: str | None = None) -> None:
        """Show a person what happens now."""
        self.state, self.message = state, state.value if message is None else message

    def shine(self, lasers: Iterable[LaserName], purpose: Purpose = Purpose.MOVING) -> None:
        """Switch the lasers, leave everything else."""
        shining = set(lasers)
        outputs = replace(
            self.interlock.outputs, laser_right="right" in shining, laser_left="left" in shining, lamp=bool(shining)
        )
        self.interlock.request(outputs, purpose, at_rest=self.carriage.at_rest)

    def sound(self, on: bool) -> None:
        """The buzzer."""
        self.interlock.request(replace(self.interlock.outputs, buzzer=on), at_rest=self.carriage.at_rest)

    def take_for(self, phase: Phase) -> None:
        """From now on frames are taken for this."""
        self.log.phase.note(self.clock.now_s(), phase)

    def quiet(self) -> None:
        """Everything off and nothing recorded, without a word to the interlock's arming."""
        self.take_for(None)
        self.carriage.forget_command()
        self.interlock.request(ALL_OFF)

    def until(self, held: Callable[[], bool], at_most_s: float, otherwise: Callable[[], FootscanError]) -> Program:
        """Go on once something holds.

        Raises:
            FootscanError: It did not come to hold in time.
        """
        gives_up_s = self.clock.now_s() + at_most_s
        while not held():
            if self.clock.now_s() > gives_up_s:
                raise otherwise()
            yield

    def gap_after(self, time_s: float) -> float:
        """The next moment between two exposures, at least a quarter of a period from now."""
        period_s = 1.0 / self.facts.frames_per_s
        newest = self.grabber.latest
        ends_s = time_s if newest is None else self.timing.span_s(newest.time_s)[1]
        return ends_s + period_s * float(np.ceil((time_s + 0.25 * period_s - ends_s) / period_s))

    def pause(self, seconds: float) -> Program:
        """Let time pass."""
        ends_s = self.clock.now_s() + seconds
        while self.clock.now_s() < ends_s:
            yield

    def come_to_rest(self) -> Program:
        """Motor and lasers off, and wait until the head stands."""
        self.take_for(None)
        self.carriage.stop()
        yield from self.until(lambda: self.carriage.at_rest, _SLACK_S, self._keeps_turning)

    def go_to(self, theta_rad: float) -> Program:
        """Turn the head to an angle, lasers off, slowly enough to stop there."""
        if not self.carriage.at_rest:
            yield from self.come_to_rest()
        step = 0
        reach = self.carriage.drive.stopping_rad(step)
        way = theta_rad - self.carriage.theta_rad
        if abs(way) <= PARK_TOLERANCE_RAD + reach:
            return
        sign = float(np.sign(way))
        fast = len(self.motion.speeds_deg_per_s) - 1
        if abs(way) > 0.2 + 2.0 * self.carriage.drive.stopping_rad(fast):
            yield from self._turn_near(theta_rad - sign * (0.1 + self.carriage.drive.stopping_rad(fast)), fast)
        yield from self._turn_near(theta_rad - sign * reach, step)

    def _turn_near(self, stop_rad: float, speed_step: int) -> Program:
        sign = float(np.sign(stop_rad - self.carriage.theta_rad))
        if sign == 0.0:
            return
        self.carriage.turn(sign > 0, speed_step)
        yield from self.turned_to(stop_rad, sign, speed_step)
        yield from self.come_to_rest()

    def turned_to(self, theta_rad: float, sign: float, speed_step: int) -> Program:
        """Wait until the turning head has passed an angle."""
        way = abs(theta_rad - self.carriage.theta_rad)
        speed = self.carriage.drive.speeds_rad_s[speed_step]
        at_most_s = 1.5 * way / speed + _SLACK_S
        passed = lambda: sign * (self.carriage.theta_rad - theta_rad) >= 0.0  # noqa: E731
        yield from self.until(passed, at_most_s, lambda: self._too_slow(theta_rad, at_most_s))

    def see(self, frames: int, into: list[CameraFrame]) -> Program:
        """Collect the next frames whose whole exposure begins from now on."""
        begin_s = self.clock.now_s()
        last = -1
        at_most_s = (frames + 6) / self.facts.frames_per_s + 1.0
        gives_up_s = begin_s + at_most_s
        while len(into) < frames and self.clock.now_s() < gives_up_s:
            newest = self.grabber.latest
            if newest is not None and newest.number != last and self.timing.span_s(newest.time_s)[0] >= begin_s:
                last = newest.number
                into.append(newest)
            yield

    def _too_slow(self, theta_rad: float, at_most_s: float) -> DeviceError:
        return HeadStalledError(
            f"the head did not reach {np.rad2deg(theta_rad):.1f} degrees within {at_most_s:.0f} s (it is at "
            f"{np.rad2deg(self.carriage.theta_rad):.1f}); check motor, belt and the speeds of the rig file."
        )

    def _keeps_turning(self) -> DeviceError:
        return HeadStalledError(
            f"the motor is off but the head has not come to rest within {_SLACK_S:g} s; switch the machine off at its "
            "main switch and have the motor's drive checked."
        )
