"""Garbage on the wire: never a hang beyond the time-out, never an error of another kind, never an output left on."""

import contextlib
import time

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from footscan.config.device_models import FileCameraModel, QsbModel
from footscan.config.io_models import AdamModel
from footscan.devices import qsb_protocol as qsb
from footscan.devices.adam_io import AdamIo
from footscan.devices.adam_line import checksum, reply_text
from footscan.devices.pictures import View, frame_from_picture
from footscan.devices.qsb_encoder import QsbEncoder
from footscan.devices.qsb_startup import start_streaming
from footscan.devices.qsb_stream import QsbStream
from footscan.devices.serial_port import LineSplitter
from footscan.devices.values import ALL_OFF, Inputs, Outputs
from footscan.errors import DeviceError, EncoderLostError, OutputsLostError
from footscan.sim.emulators.adam import AdamEmulator
from footscan.sim.emulators.panel import WiredPanel
from footscan.sim.emulators.qsb import QsbEmulator
from tests.devices.conftest import IO_TABLE

many = settings(max_examples=400, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
words = st.binary(max_size=40)
counts = st.integers(-(2**31), 2**31 - 1)
u32 = st.integers(0, 2**32 - 1)


class MemoryPort:
    """A port that leads to a state machine in this process, with a wire that spoils bytes; its time is its own."""

    path, baud = "/dev/memory", 115200

    def __init__(self, device, spoil=lambda data: data) -> None:
        self._device, self.spoil, self._waiting = device, spoil, b""
        self.now_s = 0.0

    def write(self, data: bytes) -> None:
        self.now_s += 0.002
        for _, reply in self._device.hear(self.spoil(data), self.now_s):
            self._waiting += self.spoil(reply)

    def read(self, timeout_s: float) -> bytes:
        self.now_s += 0.0 if self._waiting else max(timeout_s, 0.0)
        data, self._waiting = self._waiting, b""
        return data

    def wire_s(self, count: int) -> float:
        return count * 10 / self.baud

    def close(self) -> None:
        self._waiting = b""


@given(st.lists(words, max_size=30))
@many
def test_lines_are_the_same_however_the_bytes_are_cut(parts):
    whole, pieces = LineSplitter(10_000), LineSplitter(10_000)
    together = whole.feed(b"".join(parts))

    assert [line for part in parts for line in pieces.feed(part)] == together
    assert all(line and b"\r" not in line and b"\n" not in line for line in together)


def test_endless_garbage_does_not_pile_up():
    lines = LineSplitter(256)
    for _ in range(5):
        lines.feed(bytes(range(14, 256)) * 8)

    assert len(lines._rest) <= 256


@given(words)
@many
def test_no_bytes_upset_the_parsers(line):
    reply = qsb.reply_from_line(line)

    assert reply is None or reply.kind in "rwsex"
    assert reply_text(line, with_checksum=True) is None or line[-2:] == checksum(line[:-2])


@given(st.sampled_from("rwsex"), st.integers(0, 255), u32, st.none() | u32, st.booleans())
@many
def test_every_reply_of_a_qsb_is_read_in_every_format(kind, register, value, tick, spaces):
    stamp = [] if tick is None else [f"{tick:08X}"]
    line = (" " * spaces).join([kind, f"{register:02X}", f"{value:08X}", *stamp, "!"]).encode()

    assert qsb.reply_from_line(line) == qsb.QsbReply(kind, register, value, tick)


@given(st.integers(-(2**40), 2**40), st.integers(-(2**31), 2**31 - 1))
def test_unwrapping_finds_the_neighbour_with_the_same_low_bits(near, step):
    assert qsb.unwrapped((near + step) & 0xFFFFFFFF, near) == near + step


@given(counts)
def test_a_command_carries_negative_values_in_all_eight_digits(value):
    digits = qsb.command("W", 8, value)[3:-1]

    assert int(digits, 16) == value & 0xFFFFFFFF
    assert value >= 0 or len(digits) == 8


@given(st.data())
@settings(max_examples=150, deadline=None)
def test_a_stream_with_spoiled_lines_gives_only_samples_in_order(data):
    stream, good = QsbStream(0.001), 0
    spoiled = data.draw(st.dictionaries(st.integers(0, 79), words, max_size=20))
    with contextlib.suppress(EncoderLostError):
        for tick in range(80):
            line = spoiled.get(tick, f"s0E{7 * tick:08X}{tick + 1:08X}!".encode())
            good += stream.feed(line, 100.0 + tick / 512)
    samples = stream.take_samples()

    assert len(samples) == good
    assert np.all(np.diff(samples.time_s) > 0)


@given(st.integers(5, 70), st.integers(0, 20), st.sampled_from(b"0123456789ABCDEF"))
@settings(max_examples=300, deadline=None)
def test_one_spoiled_digit_of_a_stamp_costs_at_most_that_line(at, place, digit):
    stream = QsbStream(0.001)
    for tick in range(80):
        line = bytearray(f"s0E{0:08X}{tick + 1000:08X}!\n".encode())
        if tick == at and 11 <= place < 16:
            line[place] = digit
        stream.feed(bytes(line), 100.0 + tick / 512)
    time_s = stream.take_samples().time_s

    assert len(time_s) >= 79
    assert np.abs(np.diff(time_s) * 512 - 1).max() < 1.01


def _spoiler(random: np.random.Generator, share: float):
    def spoil(data: bytes) -> bytes:
        if random.random() > share:
            return data
        kind = random.integers(5)
        if kind == 0:
            return b""
        if kind == 1:
            return data[: random.integers(len(data) + 1)]
        if kind == 2:
            return data + bytes(random.integers(0, 256, 5, dtype=np.uint8))
        if kind == 3:
            return bytes(random.integers(0, 256, len(data), dtype=np.uint8))
        spoiled = bytearray(data)
        spoiled[random.integers(len(data))] = int(random.integers(256))
        return bytes(spoiled)

    return spoil


@pytest.fixture
def spoiled_io(monkeypatch):
    """An I/O driver on a module in this process; time is the port's."""

    def make(dialect: str, with_checksum: bool):
        model = AdamModel.model_validate(
            IO_TABLE | {"dialect": dialect, "checksum": with_checksum, "reply_timeout_s": 0.06}
        )
        panel = WiredPanel(model, Inputs(0.0, estop_ok=True, home=False))
        device = AdamEmulator(model.dialect, panel, with_checksum=with_checksum)
        port = MemoryPort(device)
        for room in ("adam_line", "adam_watchdog", "adam_io"):
            monkeypatch.setattr(f"footscan.devices.{room}.time.monotonic", lambda: port.now_s)
        monkeypatch.setattr("footscan.devices.adam_io.SerialPort", lambda *rest: port)
        return AdamIo(model), port, panel, device

    return make


@pytest.mark.parametrize("dialect", ["adam4055", "i7060"])
@pytest.mark.parametrize("with_checksum", [True, False])
def test_ten_thousand_spoiled_exchanges_with_a_module(spoiled_io, dialect, with_checksum):
    module, port, panel, device = spoiled_io(dialect, with_checksum)
    random = np.random.default_rng([5, with_checksum])
    refused, longest_s, calls = 0, 0.0, 0
    while calls < 2500:
        port.spoil = _spoiler(random, 0.1 * random.random())
        with contextlib.suppress(DeviceError):
            module.arm_watchdog(0.2)
        for _ in range(20):
            wanted = Outputs(laser_right=bool(random.integers(2)), motor_run=bool(random.integers(2)))
            for call in (module.read_inputs, lambda wanted=wanted: module.set_outputs(wanted), module.feed_watchdog):
                began_s, calls = port.now_s, calls + 1
                try:
                    call()
                except DeviceError as err:
                    refused += 1
                    assert len(str(err)) < 600
                longest_s = max(longest_s, port.now_s - began_s)
        port.spoil = lambda data: data
        _end(module, port, device)

        assert not panel.outputs.dangerous
    assert refused > 20
    assert longest_s < 1.0


replies = st.one_of(
    st.binary(max_size=14),
    st.from_regex(rb"[!>?]01[0-9A-F]{0,8}", fullmatch=True),
    st.from_regex(rb"![0-9A-F]{4}00", fullmatch=True),
    st.sampled_from([b">", b"!", b"?01", b"!01", b"!010", b"!011", b"!0104", b"!00", b"!000300"]),
)


@pytest.mark.parametrize("dialect", ["adam4055", "i7060"])
@given(st.lists(replies, min_size=50, max_size=50))
@settings(max_examples=100, deadline=None, suppress_health_check=list(HealthCheck))
def test_ten_thousand_invented_replies_of_a_module(spoiled_io, dialect, invented):
    """The module obeys, and says anything; with 2 x 100 lists of 50, and two tries for most of them."""
    module, port, panel, device = spoiled_io(dialect, with_checksum=False)
    hear = port._device.hear
    for number, reply in enumerate(invented):
        port._device.hear = lambda data, at_s, reply=reply: [
            (at_s, reply + b"\r") for _ in [*hear(data, at_s), None][:1]
        ]
        call = (
            lambda: module.arm_watchdog(0.2),
            lambda: module.set_outputs(Outputs(laser_left=True, motor_run=True)),
            module.read_inputs,
            module.feed_watchdog,
        )[number % 4]
        began_s = port.now_s
        with contextlib.suppress(DeviceError):
            call()

        assert port.now_s - began_s < 1.0
    port._device.hear = hear
    _end(module, port, device)

    assert not panel.outputs.dangerous


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=100, deadline=None)
def test_ten_thousand_invented_lines_of_an_encoder_are_samples_in_order_or_nothing(seed):
    random = np.random.default_rng(seed)
    stream, spoil = QsbStream(0.001), _spoiler(random, 0.9)
    with contextlib.suppress(EncoderLostError):
        for number in range(100):
            kind, register = "rwsex"[random.integers(5)], random.choice([0x0E, 0x05, int(random.integers(256))])
            line = f"{kind}{register:02X}{random.integers(2**32):08X}{random.integers(2**32):08X}!".encode()
            stream.feed(spoil(line), 100.0 + number / 512)
    samples = stream.take_samples()

    assert np.all(np.diff(samples.time_s) > 0)
    assert np.all(np.isfinite(samples.time_s))


def _end(module: AdamIo, port: MemoryPort, device: AdamEmulator) -> None:
    """Off as the interlock does it; where that fails, the watchdog's time passes without a word."""
    try:
        module.set_outputs(ALL_OFF)
    except OutputsLostError:
        port.now_s += 0.3
        device.act(port.now_s)


def test_spoiled_start_ups_of_an_encoder_end_in_time_with_a_device_error_or_a_stream(monkeypatch):
    random = np.random.default_rng(8)
    model = QsbModel(kind="qsb", port="emulated")
    started = 0
    for _ in range(150):
        port = MemoryPort(QsbEmulator(lambda time_s: 0, 0.0), _spoiler(random, 0.5 * random.random() ** 2))
        monkeypatch.setattr("footscan.devices.qsb_startup.time.monotonic", lambda port=port: port.now_s)
        with contextlib.suppress(DeviceError):
            started += start_streaming(port, model).serial_number == 1234

        assert port.now_s < 20.0
    assert 20 < started < 150


def test_ten_thousand_arrays_from_a_camera_are_frames_or_value_errors():
    random, view = np.random.default_rng(7), View(8, 6, 25.0)
    models = [
        FileCameraModel.model_validate({"kind": "file", "path": "x", "field": f}) for f in ("both", "top", "bottom")
    ]
    frames = 0
    for number in range(10_000):
        sizes = random.choice([0, 1, 2, 3, 6, 8, 12, 48, 96, 144, int(random.integers(70))], random.integers(1, 4))
        picture = random.integers(0, 256, sizes).astype(random.choice(["uint8", "uint16", "float32"]))
        with contextlib.suppress(ValueError):
            frame = frame_from_picture(picture, models[number % 3], view)
            frames += 1
            assert (frame.shape, frame.dtype) == ((6, 8), np.uint8)

    assert frames > 10


@given(st.lists(words, min_size=1, max_size=6))
@settings(max_examples=60, deadline=None)
def test_an_emulated_device_swallows_anything(parts):
    head = QsbEmulator(lambda time_s: 0, 0.0)
    model = AdamModel.model_validate(IO_TABLE)
    module = AdamEmulator("adam4055", WiredPanel(model, Inputs(0.0, estop_ok=True, home=False)))
    for at, part in enumerate(parts):
        list(head.hear(part, float(at)))
        list(module.hear(part, float(at)))

    assert list(module.hear(b"\r$016\r", 9.0))[-1][1].startswith(b"!")


def test_garbage_in_the_middle_of_a_live_stream_is_counted_and_left_out(plug_qsb):
    emulated = plug_qsb()
    encoder = QsbEncoder(emulated.model())
    random = np.random.default_rng(3)
    for _ in range(30):
        emulated.line._line._say([(time.monotonic(), bytes(random.integers(0, 256, 11, dtype=np.uint8)) + b"\n")])
        time.sleep(0.01)
    encoder.take_samples()
    newest = encoder.read()
    garbled = encoder.garbled_lines
    encoder.close()

    assert garbled >= 20
    assert newest.count == 0
