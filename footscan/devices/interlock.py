"""The one door to lasers and motor: nothing shines or turns unless somebody armed it and the control thread is well."""

import contextlib
import threading
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

from footscan.devices.clock import Clock
from footscan.devices.protocols import DigitalIo
from footscan.devices.values import ALL_OFF, Inputs, Outputs
from footscan.errors import DeviceError, EmergencyStopError, InterlockError, OutputsLostError

MEASURING_AT_REST_S = 6.0
HELD_S = 1.0


class Purpose(Enum):
    """Why beams may shine: the head moves, a short measurement at rest, or a person holds the button."""

    MOVING = "the head moves"
    MEASURING = "a measurement at rest"
    HELD = "somebody holds it on"


@dataclass(frozen=True)
class InterlockLimits:
    """Seconds: of the module's watchdog, and how long anything dangerous may be on without a break."""

    watchdog_s: float
    max_on_s: float


OutputsChange = Callable[[float, Outputs | None], None]
"""Told before (None) and after (the confirmed outputs) each change, with the time."""


class Interlock:
    """Owns the digital I/O module. Only the control thread calls it, except `all_off`, which any thread may call."""

    def __init__(
        self,
        io: DigitalIo,
        clock: Clock,
        limits: InterlockLimits,
        on_change: OutputsChange = lambda time_s, outputs: None,
    ) -> None:
        self._io, self._clock, self._limits, self._on_change = io, clock, limits, on_change
        self._lock = threading.RLock()
        self._outputs = ALL_OFF
        self._armed = False
        self._purpose = Purpose.MOVING
        self._granted_s = self._moved_s = 0.0
        self._dangerous_since_s: float | None = None
        self._emergency = False
        self._ran_reverse = False
        self._io.set_outputs(ALL_OFF)
        on_change(clock.now_s(), ALL_OFF)

    @property
    def armed(self) -> bool:
        """Somebody has said that nobody's face is at beam height, and nothing has gone wrong since."""
        return self._armed

    @property
    def outputs(self) -> Outputs:
        """The outputs as last confirmed."""
        return self._outputs

    def arm(self, no_faces_at_beam_height: bool) -> None:
        """Allow lasers and motor until `disarm`.

        Raises:
            InterlockError: Nobody has confirmed that no face is at beam height.
            EmergencyStopError: The emergency stop is open, or was and has not been reset.
            OutputsLostError: The module does not answer.
        """
        if not no_faces_at_beam_height:
            raise InterlockError(
                "lasers and motor stay off until somebody confirms that no face is at beam height; look, then confirm."
            )
        with self._lock:
            self._io.read_inputs()  # asks away an old "restarted": what counts is a restart from now on
            self._refuse_emergency(self._io.read_inputs())
            self._io.arm_watchdog(self._limits.watchdog_s)
            self._armed = True

    def disarm(self) -> None:
        """Switch everything off; the next use needs `arm` again."""
        with self._lock:
            self._armed = False
            self._switch(ALL_OFF)

    def reset_emergency(self) -> None:
        """A person has looked at the machine and closed the emergency stop.

        Raises:
            EmergencyStopError: It is still open.
        """
        with self._lock:
            self._emergency = False
            self._refuse_emergency(self._io.read_inputs())

    def request(self, outputs: Outputs, purpose: Purpose = Purpose.MOVING, at_rest: bool = False) -> None:
        """Switch the outputs.

        Args:
            outputs: What should be on.
            purpose: Why beams may shine.
            at_rest: The head does not move.

        Raises:
            InterlockError: Not armed, the direction changed while turning, or beams at rest for no reason.
            OutputsLostError: The module does not obey.
        """
        with self._lock:
            self._refuse(outputs, purpose, at_rest)
            self._purpose, self._granted_s = purpose, self._clock.now_s()
            if outputs != self._outputs:
                self._switch(outputs)

    def check(self, inputs: Inputs, moving: bool) -> None:
        """Once per round of the control thread: everything that must hold while something is on; feeds the watchdog.

        Raises:
            EmergencyStopError: The emergency stop is open.
            OutputsLostError: The module restarted or dropped its outputs by itself.
            InterlockError: Something was on for too long, or beams shone without a reason.
        """
        with self._lock:
            self._refuse_emergency(inputs)
            if self._armed:
                self._refuse_lost_power(inputs)
            now_s = self._clock.now_s()
            self._refuse_long(now_s)
            self._refuse_idle_beams(now_s, moving)
            if self._armed:
                self._io.feed_watchdog()

    def all_off(self) -> None:
        """Lasers and motor off and disarmed, whatever state this is in; a module that does not answer trips by itself.

        Raises:
            OutputsLostError: The module did not confirm; its own watchdog switches off.
        """
        with self._lock:
            self._armed = False
            self._switch(ALL_OFF)

    def close(self) -> None:
        """All off, and the module given back."""
        with contextlib.suppress(DeviceError):
            self.all_off()
        self._io.close()

    def _switch(self, outputs: Outputs) -> None:
        self._on_change(self._clock.now_s(), None)
        try:
            self._io.set_outputs(outputs)
        except OutputsLostError:
            self._armed = False
            raise
        self._outputs = outputs
        if outputs.motor_run:
            self._ran_reverse = outputs.motor_reverse
        now_s = self._clock.now_s()
        if not outputs.dangerous:
            self._dangerous_since_s = None
        elif self._dangerous_since_s is None:
            self._dangerous_since_s = now_s
        self._on_change(now_s, outputs)

    def _refuse(self, outputs: Outputs, purpose: Purpose, at_rest: bool) -> None:
        if outputs.dangerous and not self._armed:
            raise InterlockError("lasers and motor are off until the machine is armed; confirm and arm it first.")
        flipped = self._outputs.motor_run and outputs.motor_reverse != self._outputs.motor_reverse
        against = outputs.motor_run and not at_rest and outputs.motor_reverse != self._ran_reverse
        if flipped or against:
            raise InterlockError("the motor's direction was to change while it turns; stop it first.")
        if outputs.lasers and at_rest and purpose is Purpose.MOVING and not outputs.motor_run:
            raise InterlockError("a laser was to shine while the head rests; beams shine only while it moves.")

    def _refuse_emergency(self, inputs: Inputs) -> None:
        if not inputs.estop_ok:
            self._emergency, self._armed = True, False
        if self._emergency:
            state = "is open" if not inputs.estop_ok else "was pressed"
            raise EmergencyStopError(
                f"the emergency stop {state}: lasers and motor have no supply. Look at the machine, release it, and "
                "reset it on the screen."
            )

    def _refuse_lost_power(self, inputs: Inputs) -> None:
        if inputs.module_reset or inputs.watchdog_tripped:
            self._armed = False
            what = (
                "has restarted (power was lost)" if inputs.module_reset else "was not fed and switched everything off"
            )
            raise OutputsLostError(f"the output module {what}; check its supply and cable, then arm it again.")

    def _refuse_long(self, now_s: float) -> None:
        if self._dangerous_since_s is not None and now_s - self._dangerous_since_s > self._limits.max_on_s:
            raise InterlockError(
                f"lasers or motor were on for more than {self._limits.max_on_s:g} s without a break and are now off; "
                "start again."
            )

    def _refuse_idle_beams(self, now_s: float, moving: bool) -> None:
        if not self._outputs.lasers or moving:
            self._moved_s = now_s
            return
        allowed_s = {Purpose.MOVING: 0.5, Purpose.MEASURING: MEASURING_AT_REST_S, Purpose.HELD: HELD_S}[self._purpose]
        rests_since_s = self._granted_s if self._purpose is not Purpose.MOVING else max(self._granted_s, self._moved_s)
        if now_s - rests_since_s > allowed_s:
            raise InterlockError(
                f"a laser shone on the same place for more than {allowed_s:g} s and is now off; start again."
            )
