"""From whatever state a QSB is in to one that streams counts (QSB command list v1.28)."""

import time

from footscan.config.device_models import QsbModel
from footscan.devices import qsb_protocol as qsb
from footscan.devices.qsb_protocol import QsbIdentity, QsbReply
from footscan.devices.serial_port import LineSplitter, SerialPort
from footscan.errors import EncoderLostError, WrongDeviceError

_QUIET_S = 0.1
_DRAINING_S = 3.0
_REPLY_S = 0.4
_TRIES = 4
"""A QSB whose DTR has just been raised restarts, which takes up to 2 s."""


def start_streaming(port: SerialPort, model: QsbModel) -> QsbIdentity:
    """Stop old streams, set all registers that matter, and let samples come.

    Raises:
        EncoderLostError: Nothing answers.
        WrongDeviceError: What answers is no QSB, or does not take the settings.
    """
    for attempt in range(_TRIES):
        try:
            return _set_up(_Dialogue(port), model)
        except EncoderLostError:
            if attempt == _TRIES - 1:
                raise
    raise AssertionError


def identify(port: SerialPort) -> QsbIdentity:
    """Who answers; its streams are stopped.

    Raises:
        EncoderLostError: Nothing answers.
        WrongDeviceError: No QSB.
    """
    dialogue = _Dialogue(port)
    dialogue.silence()
    return dialogue.identity()


def _set_up(dialogue: "_Dialogue", model: QsbModel) -> QsbIdentity:
    dialogue.silence()
    identity = dialogue.identity()
    dialogue.write(qsb.LINE_FORMAT, qsb.SHORT_STAMPED_LINES)
    dialogue.write(qsb.MODE, 0)
    dialogue.write(qsb.COUNTER_MODE, qsb.FREE_RUNNING[model.counting])
    dialogue.write(qsb.COUNTER_SIGN, 0)
    if not model.keep_count:
        dialogue.write(qsb.CLEAR, qsb.CLEAR_COUNTER)
    dialogue.refuse_wrapping()
    dialogue.write(qsb.THRESHOLD, 0)
    dialogue.write(qsb.INTERVAL, model.interval_ticks)
    dialogue.write(qsb.TIME_STAMP, 1)
    if model.frame_trigger:
        dialogue.write(qsb.DIO_SETUP, qsb.LATCH_ON_FALLING_DIO_0)
        dialogue.ask(qsb.command("S", qsb.CAPTURE), "s", qsb.CAPTURE)
    dialogue.ask(qsb.command("S", qsb.COUNT), "s", qsb.COUNT)
    return identity


class _Dialogue:
    """Commands one by one, each with its reply; lines of running streams in between are passed over."""

    def __init__(self, port: SerialPort) -> None:
        self._port, self._lines = port, LineSplitter()
        self._heard = b""

    def silence(self) -> None:
        self._port.write(b"\r" + qsb.command("W", qsb.COMMAND, qsb.STOP_STREAMS))
        end_s = time.monotonic() + _DRAINING_S
        while self._port.read(_QUIET_S):
            if time.monotonic() > end_s:
                raise WrongDeviceError(
                    f"the device on {self._port.path} never stops talking, so it is no QSB; give the QSB's port."
                )
        self._lines.clear()

    def identity(self) -> QsbIdentity:
        return qsb.identity_from_version(self.ask(qsb.command("R", qsb.VERSION), "r", qsb.VERSION).value)

    def write(self, register: int, value: int) -> None:
        self.ask(qsb.command("W", register, value), "w", register)

    def refuse_wrapping(self) -> None:
        mode = self.ask(qsb.command("R", qsb.COUNTER_MODE), "r", qsb.COUNTER_MODE).value
        if not qsb.runs_freely(mode):
            raise WrongDeviceError(
                f"the QSB on {self._port.path} keeps its counter mode {mode:02X}, with which counts wrap at a preset; "
                "switch it off and on and start again."
            )

    def ask(self, line: bytes, kind: str, register: int) -> QsbReply:
        self._port.write(line)
        end_s = time.monotonic() + _REPLY_S
        while data := self._hear(end_s - time.monotonic()):
            for heard in self._lines.feed(data):
                reply = qsb.reply_from_line(heard)
                if reply is not None and reply.register == register and reply.kind in (kind, "e", "x"):
                    return self._accepted(reply, line)
            if time.monotonic() > end_s + _REPLY_S:
                break
        raise self._no_answer(line)

    def _hear(self, timeout_s: float) -> bytes:
        data = self._port.read(timeout_s)
        self._heard = (self._heard + data)[-40:]
        return data

    def _accepted(self, reply: QsbReply, line: bytes) -> QsbReply:
        if reply.refused:
            raise WrongDeviceError(
                f"the QSB on {self._port.path} refused {line.decode().strip()!r} (it answered {reply.kind!r}); this "
                "model or firmware cannot do it, use a QSB-D or QSB-S."
            )
        return reply

    def _no_answer(self, line: bytes) -> EncoderLostError:
        heard = f"only {self._heard!r} came" if self._heard else "nothing came"
        return EncoderLostError(
            f"the encoder on {self._port.path} does not answer {line.decode().strip()!r} at {self._port.baud} baud "
            f"({heard}); check its cable, its baud rate and that this is the QSB's port."
        )
