"""The head as the encoder tells it: where it is, how fast it turns, and whether it obeys the motor."""

from dataclasses import dataclass, replace

import numpy as np

from footscan.coordinates import Floats, theta_from_count
from footscan.devices.clock import Clock
from footscan.devices.interlock import Interlock, Purpose
from footscan.devices.protocols import Encoder
from footscan.devices.values import EncoderSamples
from footscan.errors import EncoderLostError, HeadStalledError, InterlockError, WrongWayError

SILENT_S = 0.1
_KEPT_S = 1.0
_SPEED_S = 0.06
_REST_S = 0.12
_REST_COUNTS = 2
_STALL_S = 0.15
_STALL_SHARE = 0.3
_STALL_LEAST_RAD = np.deg2rad(0.4)
_WRONG_WAY_RAD = np.deg2rad(0.25)
_RUN_ON_S = 3.0
_JUMP_SPEEDS = 4.0
_JUMP_COUNTS = 8


@dataclass(frozen=True)
class Drive:
    """How the motor turns the head, and how the encoder counts it.

    Attributes:
        speeds_rad_s: Of each speed step.
        acceleration_rad_s2: When it starts and stops.
        travel_rad: The head must stay between these angles.
        steps_per_rev: Of the encoder.
        zero_count: At theta = 0.
        direction: 1 if counts rise counter-clockwise.
    """

    speeds_rad_s: tuple[float, ...]
    acceleration_rad_s2: float
    travel_rad: tuple[float, float]
    steps_per_rev: int
    zero_count: int
    direction: int

    def stopping_rad(self, speed_step: int) -> float:
        """How far the head turns on after the motor is switched off."""
        return self.speeds_rad_s[speed_step] ** 2 / (2.0 * self.acceleration_rad_s2)


@dataclass(frozen=True)
class _Command:
    sign: float
    speed_rad_s: float
    since_s: float
    from_rad: float


class Carriage:
    """Turns the head through the interlock and watches the encoder; only the control thread uses it."""

    def __init__(self, encoder: Encoder, interlock: Interlock, drive: Drive, clock: Clock) -> None:
        self.drive = drive
        self.homed = False
        self._encoder, self._interlock, self._clock = encoder, interlock, clock
        self._offset = 0
        self._recent = EncoderSamples(np.empty(0), np.empty(0, np.int64))
        self._command: _Command | None = None
        self._heard_s = clock.now_s()
        self._stands_by_s: float | None = None

    @property
    def theta_rad(self) -> float:
        """The head's angle at the newest sample; means something only once `homed`."""
        return float(self._theta(self._recent.count[-1:].astype(np.float64))[0]) if len(self._recent) else 0.0

    @property
    def count(self) -> int:
        """The counter, corrected by what homing found."""
        return int(self._recent.count[-1]) if len(self._recent) else 0

    @property
    def speed_rad_s(self) -> float:
        """Over the last 0.06 s, counter-clockwise positive."""
        return self._moved_rad(_SPEED_S) / _SPEED_S

    @property
    def at_rest(self) -> bool:
        """The motor is off and the count has stood still for 0.12 s."""
        return self._command is None and self._stands()

    @property
    def moving(self) -> bool:
        """The count changes."""
        return not self._stands()

    def update(self) -> EncoderSamples:
        """Take in what the encoder said since the last call; returns it, corrected by what homing found.

        Raises:
            EncoderLostError: Silent for 0.1 s, jumping, or counting against the motor.
            HeadStalledError: The motor is on and the head does not turn as it should, or off and it goes on.
            InterlockError: The head has left its travel.
        """
        raw = self._encoder.take_samples()
        samples = EncoderSamples(raw.time_s, raw.count + self._offset)
        now_s = self._clock.now_s()
        if len(samples):
            self._refuse_jump(samples)
            self._keep(samples, now_s)
            self._heard_s = now_s
        elif now_s - self._heard_s > SILENT_S:
            raise EncoderLostError(
                f"the encoder has been silent for {now_s - self._heard_s:.2f} s; check its cable and supply, "
                "then home the head again."
            )
        if self._command is not None:
            self._refuse_disobedience(self._command, now_s)
        self._refuse_travel()
        self._refuse_running_on(now_s)
        return samples

    def turn(self, ccw: bool, speed_step: int, buzzer: bool = False) -> None:
        """Switch the motor on. The lasers stay as they are.

        Raises:
            InterlockError: Not armed, or the head still turns the other way.
        """
        outputs = replace(
            self._interlock.outputs, motor_run=True, motor_reverse=not ccw, speed_step=speed_step, buzzer=buzzer
        )
        self._interlock.request(outputs, at_rest=self.at_rest)
        speed = self.drive.speeds_rad_s[speed_step]
        self._stands_by_s = None
        self._command = _Command(1.0 if ccw else -1.0, speed, self._clock.now_s(), self.theta_rad)

    def stop(self) -> None:
        """Switch motor and lasers off; the head turns on for a little while."""
        self.forget_command()
        outputs = replace(self._interlock.outputs, motor_run=False, laser_right=False, laser_left=False)
        self._interlock.request(outputs, Purpose.MOVING)

    def forget_command(self) -> None:
        """The outputs were switched off elsewhere."""
        if self._command is not None:
            self._stands_by_s = self._clock.now_s() + _RUN_ON_S
        self._command = None

    def set_home(self, count_at_home: int, raw_count_at_home: float) -> None:
        """The counter read `raw_count_at_home` (as shown until now) where it should read `count_at_home`."""
        shift = count_at_home - round(raw_count_at_home)
        self._offset += shift
        self._recent = EncoderSamples(self._recent.time_s, self._recent.count + shift)
        self.homed = True
        if self._command is not None:
            self._command = replace(self._command, from_rad=self._command.from_rad + self._angle_of(shift))

    def lose_home(self) -> None:
        """The counter cannot be trusted any more."""
        self.homed = False

    @property
    def newest_s(self) -> float:
        """When the newest sample was taken."""
        return float(self._recent.time_s[-1]) if len(self._recent) else -np.inf

    def count_at(self, time_s: float) -> float:
        """The counter at a recent moment up to `newest_s`, between samples interpolated."""
        return float(np.interp(time_s, self._recent.time_s, self._recent.count))

    def _theta(self, count: Floats) -> Floats:
        drive = self.drive
        return theta_from_count(count, drive.zero_count, drive.steps_per_rev, drive.direction)

    def _angle_of(self, counts: float) -> float:
        return 2.0 * np.pi * self.drive.direction * counts / self.drive.steps_per_rev

    def _stands(self) -> bool:
        recent = self._recent.count[self._recent.time_s > self._heard_s - _REST_S]
        return len(recent) == 0 or int(np.ptp(recent)) <= _REST_COUNTS

    def _moved_rad(self, window_s: float) -> float:
        if len(self._recent) == 0:
            return 0.0
        return self._angle_of(self._recent.count[-1] - self.count_at(self._recent.time_s[-1] - window_s))

    def _keep(self, samples: EncoderSamples, now_s: float) -> None:
        time_s = np.concatenate([self._recent.time_s, samples.time_s])
        count = np.concatenate([self._recent.count, samples.count])
        young = time_s > now_s - _KEPT_S
        young[-1] = True
        self._recent = EncoderSamples(time_s[young], count[young])

    def _refuse_jump(self, samples: EncoderSamples) -> None:
        time_s = np.concatenate([self._recent.time_s[-1:], samples.time_s])
        count = np.concatenate([self._recent.count[-1:], samples.count])
        fastest = max(self.drive.speeds_rad_s) * self.drive.steps_per_rev / (2.0 * np.pi)
        allowed = _JUMP_SPEEDS * fastest * np.diff(time_s) + _JUMP_COUNTS
        excess = np.abs(np.diff(count)) - allowed
        if len(excess) and excess.max() > 0:
            self.homed = False
            at = int(excess.argmax())
            raise EncoderLostError(
                f"the encoder jumped by {int(np.diff(count)[at])} counts in {1000 * np.diff(time_s)[at]:.1f} ms, at "
                f"most {allowed[at]:.0f} are possible; check its cable and shield, then home the head again."
            )

    def _refuse_disobedience(self, command: _Command, now_s: float) -> None:
        turned = command.sign * (self.theta_rad - command.from_rad)
        if turned < -_WRONG_WAY_RAD:
            raise WrongWayError(
                f"the head turns {'clockwise' if command.sign > 0 else 'counter-clockwise'} when the other direction "
                "is asked for; swap the motor's wires or correct the encoder's direction in the rig file."
            )
        expected = self._expected_rad(command, now_s)
        moved = command.sign * self._moved_rad(_STALL_S)
        if expected > _STALL_LEAST_RAD and moved < _STALL_SHARE * expected:
            raise HeadStalledError(
                f"the motor is on but the head turned {np.rad2deg(moved):.1f} of {np.rad2deg(expected):.1f} degrees "
                f"in {_STALL_S:g} s and was stopped; look for what blocks it, then go on."
            )

    def _expected_rad(self, command: _Command, now_s: float) -> float:
        """What the motor should have turned the head within the stall window, speeding up as the drive does."""

        def way(since_s: float) -> float:
            speeding_s = command.speed_rad_s / self.drive.acceleration_rad_s2
            s = max(since_s, 0.0)
            ramp = min(s, speeding_s)
            return 0.5 * self.drive.acceleration_rad_s2 * ramp**2 + command.speed_rad_s * (s - ramp)

        newest_s = self._recent.time_s[-1] if len(self._recent) else now_s
        since_s = newest_s - command.since_s
        return way(since_s) - way(since_s - _STALL_S)

    def _refuse_travel(self) -> None:
        low, high = self.drive.travel_rad
        if self.homed and self._command is not None and not low <= self.theta_rad <= high:
            raise InterlockError(
                f"the head is at {np.rad2deg(self.theta_rad):.1f} degrees, outside its travel of {np.rad2deg(low):.0f} "
                f"to {np.rad2deg(high):.0f}, and was stopped; turn it back by hand and home it."
            )

    def _refuse_running_on(self, now_s: float) -> None:
        if self._stands_by_s is None:
            return
        if self._stands():
            self._stands_by_s = None
        elif now_s > self._stands_by_s:
            self._stands_by_s = None  # said once: afterwards somebody may turn it by hand
            raise HeadStalledError(
                f"the motor is off but the head has not come to rest within {_RUN_ON_S:g} s; switch the machine off at "
                "its main switch and have the motor's drive checked."
            )
