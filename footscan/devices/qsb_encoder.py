"""The US Digital QSB as the encoder of the head: it streams, a thread of its own listens and stamps."""

import contextlib
import threading
import time

from footscan.config.device_models import QSB_LINE_BYTES, QsbModel
from footscan.devices import qsb_protocol as qsb
from footscan.devices.qsb_startup import start_streaming
from footscan.devices.qsb_stream import QsbStream
from footscan.devices.serial_port import LineSplitter, SerialPort
from footscan.devices.values import EncoderReading, EncoderSamples
from footscan.errors import DeviceError, EncoderLostError

SILENT_S = 0.1
_LISTEN_S = 0.05
_FIRST_SAMPLE_S = 1.0


class QsbEncoder:
    """Counts from zero at the start (unless the rig file keeps them), times on CLOCK_MONOTONIC.

    Attributes:
        identity: Type, firmware and serial number of the device.
    """

    def __init__(self, model: QsbModel) -> None:
        """Open the port, set the device up, and wait for its first sample.

        Raises:
            EncoderLostError: No port, no answer, or no sample.
            WrongDeviceError: What answers is no QSB.
        """
        self._port = SerialPort(model.port, model.baud, EncoderLostError)
        try:
            self.identity = start_streaming(self._port, model)
        except DeviceError:
            self._port.close()
            raise
        self._stream = QsbStream(self._port.wire_s(QSB_LINE_BYTES))
        self._lock, self._first = threading.Lock(), threading.Event()
        self._stopping = threading.Event()
        self._trouble: str | None = None
        self._silent = False
        self._ear = threading.Thread(target=self._listen, name="qsb", daemon=True)
        self._ear.start()
        self._await_first()

    @property
    def garbled_lines(self) -> int:
        """Lines that were left out because they made no sense."""
        return self._stream.garbled

    def read(self) -> EncoderReading:
        """The newest sample.

        Raises:
            EncoderLostError: Silent for 0.1 s, restarted, unplugged or closed.
        """
        with self._lock:
            self._refuse_trouble()
            newest = self._stream.newest
            if self._silent or newest is None:
                raise EncoderLostError(self._silence_sentence())
            return newest

    def take_samples(self) -> EncoderSamples:
        """All samples since the last call, oldest first.

        Raises:
            EncoderLostError: Restarted, unplugged or closed.
        """
        with self._lock:
            self._refuse_trouble()
            return self._stream.take_samples()

    def take_captures(self) -> EncoderSamples:
        """Counts latched by the camera's strobe on DIO 0 since the last call (`frame_trigger`).

        The counts are exact; their times are as coarse as the device's ticks (2 ms).
        """
        with self._lock:
            self._refuse_trouble()
            return self._stream.take_captures()

    def close(self) -> None:
        """Stop the stream and give the port back."""
        if self._stopping.is_set():
            return
        self._stopping.set()
        self._ear.join()
        with contextlib.suppress(DeviceError):
            self._port.write(qsb.command("W", qsb.COMMAND, qsb.STOP_STREAMS))
        self._port.close()
        with self._lock:
            self._trouble = self._trouble or "the encoder was closed; open it again."

    def _await_first(self) -> None:
        if not self._first.wait(_FIRST_SAMPLE_S):
            trouble = self._trouble
            self.close()
            raise EncoderLostError(trouble or self._silence_sentence())

    def _listen(self) -> None:
        lines, heard_s = LineSplitter(), time.monotonic()
        while not self._stopping.is_set():
            try:
                data = self._port.read(_LISTEN_S)
                now_s = time.monotonic()
                sampled = self._take_in(lines.feed(data), now_s)
            except DeviceError as err:
                self._trouble = str(err)
                return
            heard_s = now_s if sampled else heard_s
            self._silent = now_s - heard_s > SILENT_S
            if sampled:
                self._first.set()

    def _take_in(self, lines: list[bytes], arrival_s: float) -> bool:
        with self._lock:
            taken = [self._stream.feed(line, arrival_s) for line in lines]
        return any(taken)

    def _refuse_trouble(self) -> None:
        if self._trouble is not None:
            raise EncoderLostError(self._trouble)

    def _silence_sentence(self) -> str:
        nonsense = f" ({self._stream.garbled} lines made no sense)" if self._stream.garbled else ""
        return (
            f"the encoder on {self._port.path} has been silent for {SILENT_S:g} s{nonsense}; check its cable and "
            "supply, then start again and home the head."
        )
