"""A digital I/O module of the ADAM/DCON family: outputs read back after each change, and its own watchdog."""

import contextlib
import threading
import time

from footscan.config.io_models import AdamModel
from footscan.devices import wiring
from footscan.devices.adam_line import AdamLine
from footscan.devices.adam_watchdog import AdamWatchdog, DconWatchdog, ModuleWatchdog, arm_surely
from footscan.devices.serial_port import SerialPort
from footscan.devices.values import ALL_OFF, Inputs, Outputs
from footscan.errors import DeviceError, OutputsLostError, WrongDeviceError

STATUS_EVERY_S = 0.25


class AdamIo:
    """One module; every call is one or two exchanges and may come from any thread."""

    def __init__(self, model: AdamModel) -> None:
        """Open the port, see that the module is the named one, and switch everything off.

        Raises:
            OutputsLostError: No port or no answer.
            WrongDeviceError: Another module answers.
        """
        self._model, self._lock, self._closed = model, threading.RLock(), False
        self._port = SerialPort(model.port, model.baud, OutputsLostError)
        self._line = AdamLine(self._port, model.address, model.checksum, model.reply_timeout_s)
        self._watchdog: ModuleWatchdog = (AdamWatchdog if model.watchdog == "adam" else DconWatchdog)(self._line)
        self._safe_bits = self._bits = wiring.bits_when_safe(model.outputs)
        self._used = wiring.used_bits(model.outputs)
        self._doubtful = self._dangerous = self._reset_seen = self._tripped = False
        self._status_s = -1e9
        try:
            self._refuse_another_module()
            self._take_status()
            self._reset_seen = False
            self.set_outputs(ALL_OFF)
        except DeviceError:
            self._port.close()
            raise

    def set_outputs(self, outputs: Outputs) -> None:
        """Switch, and read back.

        Raises:
            OutputsLostError: The module does not answer, or shows other outputs than asked for.
        """
        with self._lock:
            self._refuse_closed()
            bits = wiring.bits_from_outputs(outputs, self._model.outputs)
            if outputs.dangerous and not self._dangerous:
                self._refuse_unguarded()
            self._write(bits)
            self._dangerous = outputs.dangerous

    def read_outputs(self) -> Outputs:
        """What the module says it switches now."""
        with self._lock:
            self._refuse_closed()
            self._insist_on_off()
            return wiring.outputs_from_bits(self._words()[0], self._model.outputs)

    def read_inputs(self) -> Inputs:
        """The switches now. Restarts and trips are asked for four times a second, and at once if an output differs.

        Raises:
            OutputsLostError: The module does not answer, or has switched something by itself.
        """
        with self._lock:
            self._refuse_closed()
            self._insist_on_off()
            shown, closed = self._words()
            sampled_s = self._line.sampled_s
            if (shown ^ self._bits) & self._used:
                self._explain(shown)
            elif sampled_s - self._status_s > STATUS_EVERY_S:
                self._take_status()
            reset, self._reset_seen = self._reset_seen, False
            return wiring.inputs_from_bits(
                closed, self._model.inputs, sampled_s, module_reset=reset, watchdog_tripped=self._tripped
            )

    def arm_watchdog(self, timeout_s: float) -> None:
        """Outputs drop when nothing is heard for `timeout_s` (rounded up to 0.1 s); clears a trip, switches all off.

        Raises:
            OutputsLostError: The module does not confirm it.
        """
        with self._lock:
            self._refuse_closed()
            self._take_status()
            self._watchdog.clear()
            self._write(self._safe_bits)
            arm_surely(self._watchdog, timeout_s, self._safe_bits)
            self._tripped = self._reset_seen = False

    def feed_watchdog(self) -> None:
        """The control thread is alive."""
        with self._lock:
            self._refuse_closed()
            self._watchdog.feed()

    def close(self) -> None:
        """Switch everything off and give the port back."""
        with self._lock:
            if self._closed:
                return
            with contextlib.suppress(DeviceError):
                self.set_outputs(ALL_OFF)
                self._watchdog.disarm()
            self._closed = True
            self._port.close()

    def _write(self, bits: int) -> None:
        """Until the module has shown `bits`, each later call first sends "all off" again: it may have missed this.

        A tripped module ignores the command (`!`) or calls it invalid; what it shows afterwards decides.
        """
        self._bits, self._doubtful, self._dangerous = bits, True, False
        self._line.ask("#", f"00{bits:02X}", r"[>!]|\?AA")
        shown, _ = self._words()
        if (shown ^ bits) & self._used:
            raise self._disobeyed(shown, bits)
        self._doubtful = False

    def _insist_on_off(self) -> None:
        if self._doubtful:
            self._write(self._safe_bits)

    def _explain(self, shown: int) -> None:
        """Outputs differ from what was last confirmed: a restart or a trip has dropped them, or something is wrong."""
        self._take_status()
        dropped = not (shown ^ self._safe_bits) & self._used
        if not (dropped and (self._reset_seen or self._tripped)):
            self._doubtful = True
            raise self._disobeyed(shown, self._bits)
        self._bits, self._dangerous = self._safe_bits, False

    def _words(self) -> tuple[int, int]:
        """Outputs and inputs as the module shows them."""
        shown = self._line.ask("$", "6", r"!([0-9A-F]{2})([0-9A-F]{2})00")
        return int(shown[1], 16), int(shown[2], 16)

    def _take_status(self) -> None:
        self._reset_seen |= self._line.ask("$", "5", "!AA([01])")[1] == "1"
        self._tripped = self._watchdog.tripped()
        self._status_s = time.monotonic()

    def _refuse_another_module(self) -> None:
        name = self._line.ask("$", "M", r"!AA([ -~]+)")[1]
        if self._model.terminals.name not in name:
            raise WrongDeviceError(
                f"the module at address {self._line.address} on {self._port.path} calls itself {name!r}, the rig file "
                f"says {self._model.dialect}; correct one of them."
            )

    def _refuse_unguarded(self) -> None:
        """Before the first beam or turn: a module that restarted since the last look has forgotten its watchdog."""
        self._take_status()
        if self._reset_seen or self._tripped:
            what = "has restarted (power was lost)" if self._reset_seen else "has tripped its watchdog"
            raise OutputsLostError(f"the output module {what}; check its supply and cable, then arm it again.")

    def _refuse_closed(self) -> None:
        if self._closed:
            raise OutputsLostError("the output module was closed; open it again.")

    def _disobeyed(self, shown: int, bits: int) -> OutputsLostError:
        outputs = self._model.outputs
        with contextlib.suppress(DeviceError):
            self._take_status()
        why = "its watchdog has tripped" if self._tripped else "it may have restarted, or a wire is loose"
        wrong = [name for name, at in outputs.channels.items() if (shown ^ bits) >> at & 1]
        return OutputsLostError(
            f"the output module shows {', '.join(wrong)} other than asked for ({why}); look at the module, then arm "
            "it again."
        )
