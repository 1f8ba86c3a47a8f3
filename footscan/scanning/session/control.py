"""The control thread: owns camera, encoder and outputs; everybody else posts commands to it."""

import contextlib
import threading
from collections import deque
from collections.abc import Callable

import numpy as np

from footscan.devices.values import CameraFacts, CameraFrame
from footscan.errors import (
    DeviceError,
    EncoderLostError,
    FootscanError,
    InputError,
    InterlockError,
    OutputsLostError,
    StoppedError,
)
from footscan.scanning.session.assembly import Assembly, RigDevices, SessionSetup
from footscan.scanning.session.grabber import Grabber
from footscan.scanning.session.live import LiveView
from footscan.scanning.session.machine import Machine, Program
from footscan.scanning.session.queue_thread import failure_of_thread
from footscan.scanning.session.states import BUSY, Snapshot, State
from footscan.scanning.session.ticket import Ticket
from footscan.scanning.session.warm_up import warm_up

ROUND_S = 0.01
STUCK_S = 2.0
WRITING_S = 60.0
"""A slow disk gets so long to take the frames still in the queue when the machine is closed."""


class Session:
    """The machine in use. `post_` methods may be called from any thread and return at once; outputs start off."""

    def __init__(self, devices: RigDevices, setup: SessionSetup) -> None:
        self._devices, self.setup = devices, setup
        self.clock = devices.clock
        self._assembly = Assembly(devices, setup)
        self._commands: deque[tuple[Callable[[Machine], Program | None], Ticket, bool]] = deque()
        self._program: Program | None = None
        self._ticket: Ticket | None = None
        self._over: list[tuple[Ticket, FootscanError | None]] = []
        self._quit = self._closed = self._settled = False
        self._watched_until_s: float | None = None
        self._button_was = False
        self._frames_seen = -1
        self._thread = threading.Thread(name="control", target=self._run, daemon=True)
        self._machine = self._assembly.machine(self._hand_on)
        self._snapshot = self._machine.snapshot()

    def start(self) -> None:
        """Let the threads run. Before that, compile what they need: it would hold the control thread up."""
        warm_up(self.facts.width_px, self.facts.height_px, self.setup.tables)
        self.clock.join()
        for thread in self._helpers():
            thread.start()
        self._thread.start()

    @property
    def facts(self) -> CameraFacts:
        """What the camera delivers."""
        return self._machine.facts

    @property
    def live(self) -> LiveView | None:
        """The live view, None without a calibration."""
        return self._machine.live

    @property
    def grabber(self) -> Grabber:
        """The newest frame is here."""
        return self._machine.grabber

    def snapshot(self) -> Snapshot:
        """The machine at the end of the last round."""
        return self._snapshot

    @property
    def settled(self) -> bool:
        """Nothing runs any more and the recording is closed."""
        return self._settled

    @property
    def all_written(self) -> bool:
        """Every frame taken so far is on disk."""
        return self._machine.keeper.thread.idle

    @property
    def writing_failure(self) -> FootscanError | None:
        """Why no frame is written any more; None while well."""
        return self._machine.keeper.thread.failure

    def post(self, command: Callable[[Machine], Program | None], interrupts: bool = False) -> Ticket:
        """Give the control thread something to do: a program, or one thing done at once.

        Args:
            command: Called with the machine, on the control thread; a program it returns is run to its end.
            interrupts: It may be done while a program runs.
        """
        ticket = Ticket()
        self._commands.append((command, ticket, interrupts))
        if self._closed:
            self._refuse_waiting()
        self.clock.notify()
        return ticket

    def post_arm(self, no_faces_at_beam_height: bool) -> Ticket:
        """Allow lasers and motor."""
        return self.post(lambda machine: machine.interlock.arm(no_faces_at_beam_height))

    def post_reset(self) -> Ticket:
        """A person has looked at the machine after a fault or an emergency stop."""
        return self.post(self._reset, interrupts=True)

    def post_cancel(self, why: str = "stopped by the operator") -> Ticket:
        """Stop whatever runs, now; what was captured is kept."""
        return self.post(lambda machine: self._cancel(machine, why), interrupts=True)

    def watch(self, seconds: float | None) -> None:
        """Stop by itself unless this is called again within some seconds (None: nobody has to watch)."""
        self._watched_until_s = None if seconds is None else self.clock.now_s() + seconds

    def close(self) -> None:
        """Everything off, threads ended, devices given back; safe to call twice and from any thread."""
        before, self._quit = self._quit, True
        self.clock.notify()
        if self._thread.ident is not None:
            self._thread.join()
        elif not before:
            self._close_unused()

    def _close_unused(self) -> None:
        """It was never started: its threads will not wait on the clock, this one does."""
        for _ in self._helpers():
            self.clock.leave()
        self.clock.join()
        self._give_back()
        self._end()
        self.clock.leave()

    def _end(self) -> None:
        machine = self._machine
        if machine.state is not State.FAULT:
            machine.say(State.CLOSED)
        self._publish()
        self._closed = True
        self._refuse_waiting()

    def _refuse_waiting(self) -> None:
        while self._commands:
            with contextlib.suppress(IndexError):  # another thread may take the last one
                self._commands.popleft()[1].settle(DeviceError("the machine is closed; start the program again."))

    def _helpers(self) -> list[threading.Thread]:
        machine = self._machine
        live = [] if machine.live is None else [machine.live.thread]
        return [machine.grabber, machine.keeper.thread, *live]

    def _hand_on(self, frame: CameraFrame) -> None:
        self._machine.keeper.offer(frame)

    def _run(self) -> None:
        machine = self._machine
        try:
            next_s = self.clock.now_s()
            while not self._quit:
                self._round(machine)
                self._publish()
                if self.clock.now_s() >= next_s:
                    next_s = self.clock.now_s() + ROUND_S
                wake_s, machine.wake_s = machine.wake_s, np.inf
                self.clock.wait(min(next_s, wake_s), self._something_to_do)
        except Exception as err:  # noqa: BLE001 - whatever it is, lasers and motor go off
            self._fail(failure_of_thread("controls the machine", err))
        finally:
            self._stop_program(InterlockError("the machine was closed meanwhile."))
            self._publish()
            self._give_back()
            self._end()
            self.clock.leave()

    def _publish(self) -> None:
        """Show what is, and only then tell those who wait that their commands are over."""
        settled = self._program is None and self._machine.state not in BUSY and self._machine.keeper.finished
        self._snapshot = self._machine.snapshot()
        self._settled = settled  # only now: whoever reads this finds the final counts in the snapshot
        while self._over:
            ticket, error = self._over.pop(0)
            ticket.settle(error)

    def _something_to_do(self) -> bool:
        return bool(self._commands) or self._quit or self._machine.grabber.arrived != self._frames_seen

    def _round(self, machine: Machine) -> None:
        """One round: look, check, obey, go on."""
        self._frames_seen = machine.grabber.arrived
        for step in (self._look, self._obey_commands, self._go_on):
            try:
                step(machine)
            except FootscanError as err:
                self._fail(err)

    def _look(self, machine: Machine) -> None:
        samples = machine.carriage.update()
        self._assembly.track.add(samples)
        machine.keeper.add_counts(samples)
        machine.inputs = self._devices.io.read_inputs()
        self._refuse_dead_threads(machine)
        machine.interlock.check(machine.inputs, machine.carriage.moving)
        self._obey_button(machine)
        self._mind_the_watch(machine)

    def _refuse_dead_threads(self, machine: Machine) -> None:
        for thread in (machine.grabber, machine.keeper.thread, *([machine.live.thread] if machine.live else [])):
            if thread.failure is not None:
                raise thread.failure

    def _obey_button(self, machine: Machine) -> None:
        pressed, self._button_was = machine.inputs.button and not self._button_was, machine.inputs.button
        if pressed and machine.awaits_button:
            machine.awaits_button = False
        elif pressed and self._program is not None:
            self._cancel(machine, "stopped by the button on the machine")

    def _obey_commands(self, machine: Machine) -> None:
        for _ in range(len(self._commands)):
            command, ticket, interrupts = self._commands.popleft()
            try:
                self._refuse_command(machine, interrupts)
                program = command(machine)
            except Exception as err:
                self._over.append((ticket, failure_of_thread("controls the machine", err)))
                if isinstance(err, OutputsLostError) or not isinstance(err, FootscanError):
                    raise  # something may still be on
                continue
            if program is None:
                self._over.append((ticket, None))
            else:
                self._program, self._ticket = program, ticket

    def _refuse_command(self, machine: Machine, interrupts: bool) -> None:
        if interrupts:
            return
        if self._program is not None:
            raise InterlockError(f"the machine is busy ({machine.state.value}); wait, or stop it first.")
        if machine.state is State.FAULT:
            raise InterlockError(f"there is a fault: {machine.message} Put it right, then reset.")

    def _mind_the_watch(self, machine: Machine) -> None:
        until_s = self._watched_until_s
        if until_s is not None and self.clock.now_s() > until_s and machine.interlock.armed:
            self._watched_until_s = None
            self._cancel(machine, "stopped: nobody watches the machine any more (the page was closed or froze)")

    def _go_on(self, machine: Machine) -> None:
        if self._program is None:
            return
        try:
            next(self._program)
        except StopIteration:
            ticket, self._program, self._ticket = self._ticket, None, None
            if ticket is not None:
                self._over.append((ticket, None))

    def _cancel(self, machine: Machine, why: str) -> None:
        machine.carriage.forget_command()
        try:
            machine.interlock.disarm()
        finally:
            self._stop_program(StoppedError(f"{why}."))
        if machine.state is not State.FAULT:  # a fault stays until somebody resets it
            machine.say(State.STOPPED, f"{why}; lasers and motor are off, what was captured is kept.")

    def _reset(self, machine: Machine) -> None:
        if self._program is not None:
            raise InterlockError(f"the machine is busy ({machine.state.value}) and has no fault to reset.")
        machine.interlock.reset_emergency()
        self._replace_dead_threads(machine)
        if machine.parked or not machine.carriage.homed:
            machine.say(State.PARKED if machine.carriage.homed else State.CONNECTED)
        else:
            machine.say(State.STOPPED, "reset; lasers and motor are off, the next scan parks the head first.")

    def _replace_dead_threads(self, machine: Machine) -> None:
        """New threads for those that ended: the cable is in again, the disk has room again."""
        if machine.live is not None and machine.live.thread.failure is not None:
            machine.live = self._assembly.live()
        if machine.keeper.thread.failure is not None or machine.keeper.outdated(machine.live):
            machine.keeper.thread.finish()
            machine.keeper = self._assembly.keeper(machine.live)
        if machine.grabber.failure is not None or not machine.grabber.is_alive():
            machine.grabber = self._assembly.grabber(self._hand_on)
        for thread in self._helpers():
            if thread.ident is None:
                thread.start()

    def _fail(self, err: FootscanError) -> None:
        """Everything off first, then tell; of a row of faults the first one is told."""
        machine = self._machine
        with contextlib.suppress(DeviceError):  # a dead module is the fault itself; its own watchdog switches off
            machine.interlock.all_off()
        machine.carriage.forget_command()
        if isinstance(err, EncoderLostError):
            machine.carriage.lose_home()
        handled = self._stop_program(err)
        if machine.keeper.thread.failure is not None:
            machine.keeper.abandon()
        if machine.state is State.FAULT or handled:
            return
        refused = isinstance(err, InterlockError | InputError)  # the machine itself is well
        machine.say(State.STOPPED if refused else State.FAULT, str(err))

    def _stop_program(self, err: FootscanError) -> bool:
        """End the running program with an error; True if it had expected this one and ended well."""
        program, ticket, self._program, self._ticket = self._program, self._ticket, None, None
        handled = False
        if program is not None:
            try:
                program.throw(err)
                program.close()
            except StopIteration:
                handled = True
            except FootscanError:
                handled = False
        if ticket is not None:
            self._over.append((ticket, None if handled else err))
        return handled

    def _give_back(self) -> None:
        machine = self._machine
        machine.interlock.close()
        machine.grabber.finish()
        machine.keeper.end()
        self._devices.camera.close()
        for thread in (machine.keeper.thread, *([machine.live.thread] if machine.live else [])):
            thread.finish()
        self.clock.leave()  # the others may need the time this thread would keep still
        for thread in self._helpers():
            if thread.ident is not None:
                thread.join(WRITING_S if thread is machine.keeper.thread else STUCK_S)
        self.clock.join()
        if machine.keeper.thread.failure is not None:
            machine.keeper.abandon()
        self._devices.encoder.close()
