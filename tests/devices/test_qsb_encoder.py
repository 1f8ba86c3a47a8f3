import time
from collections.abc import Callable, Iterator

import numpy as np
import pytest

from footscan.devices.qsb_encoder import QsbEncoder
from footscan.errors import EncoderLostError, WrongDeviceError
from tests.devices.contracts import EncoderContract


@pytest.fixture
def qsb(plug_qsb):
    return plug_qsb()


class _EmulatedQsb(EncoderContract):
    @pytest.fixture
    def settings(self) -> dict[str, object]:
        return {}

    @pytest.fixture
    def device(self, qsb, settings) -> Iterator[QsbEncoder]:
        encoder = QsbEncoder(qsb.model(**settings))
        yield encoder
        encoder.close()

    @pytest.fixture
    def turn(self, qsb) -> Callable[[int], int]:
        return qsb.head.turn


class TestQsbThatFallsSilent(_EmulatedQsb):
    @pytest.fixture
    def silence(self, qsb):
        def mute() -> None:
            qsb.device.mute = True

        return mute


class TestQsbOnASlowLine(_EmulatedQsb):
    @pytest.fixture
    def qsb(self, plug_qsb):
        return plug_qsb(baud=9600)

    @pytest.fixture
    def settings(self) -> dict[str, object]:
        return {"interval_ticks": 12}


def test_an_unplugged_encoder_is_gone_at_once_and_for_good(qsb):
    encoder = QsbEncoder(qsb.model())
    qsb.line.unplug()
    time.sleep(0.1)

    for call in (encoder.read, encoder.take_samples):
        with pytest.raises(EncoderLostError, match="is gone"):
            call()
    encoder.close()


def test_the_factory_setting_that_wraps_at_500_is_gone(qsb):
    qsb.head.count = 1234
    encoder = QsbEncoder(qsb.model(keep_count=True))
    qsb.head.turn(5000)
    time.sleep(0.1)
    count = encoder.read().count
    encoder.close()

    assert qsb.device._registers[3] == 0x43
    assert count == 6234


@pytest.mark.parametrize(("counting", "share"), [("x1", 4), ("x2", 2), ("x4", 1)])
def test_counting_is_what_the_rig_file_says(qsb, counting, share):
    encoder = QsbEncoder(qsb.model(counting=counting))
    qsb.head.turn(4000)
    time.sleep(0.1)
    count = encoder.read().count
    encoder.close()

    assert count == 4000 // share


def _turned(encoder, qsb, steps):
    """Turn step by step, each after the one before has arrived: a line may come late on a busy computer."""
    for step in steps:
        before, give_up_s = encoder.read().count, time.monotonic() + 5.0
        qsb.head.turn(step)
        while encoder.read().count == before and time.monotonic() < give_up_s:
            time.sleep(0.01)
    return encoder.read().count


def test_the_count_goes_on_where_32_bits_end(qsb):
    encoder = QsbEncoder(qsb.model())
    up = _turned(encoder, qsb, (2**30, 2**30, 2**30, 12))
    down = _turned(encoder, qsb, (-(2**30),) * 5)
    encoder.close()

    assert up == 3 * 2**30 + 12
    assert down == up - 5 * 2**30


@pytest.mark.parametrize(("bridge_s", "ppm", "baud"), [(0.0, 0.0, 230400), (0.016, 80.0, 115200)])
def test_stamps_are_right_to_a_millisecond_whatever_the_bridge_delays(plug_qsb, bridge_s, ppm, baud):
    began_s, rate = time.monotonic(), 4000.0
    qsb = plug_qsb(count_at=lambda t: int((t - began_s) * rate), bridge_s=bridge_s, ppm=ppm, baud=baud)
    encoder = QsbEncoder(qsb.model(keep_count=True))
    zero = qsb.device._zero_count
    time.sleep(1.5)
    samples = encoder.take_samples()
    encoder.close()
    late_s = samples.time_s - ((samples.count + zero + 0.5) / rate + began_s)

    assert len(samples) > 600
    assert abs(np.median(late_s[-300:])) < 0.002
    assert late_s[-300:].std() < 0.001


def test_a_stream_that_nobody_stopped_does_not_confuse_the_next_start(qsb):
    first = QsbEncoder(qsb.model())
    first._stopping.set()
    first._ear.join()
    first._port.close()
    time.sleep(0.4)
    qsb.head.turn(77)
    second = QsbEncoder(qsb.model(keep_count=True))
    count = second.read().count
    second.close()

    assert count == 77


def test_a_restart_says_that_the_count_is_lost_and_stays_lost(qsb):
    encoder = QsbEncoder(qsb.model())
    qsb.device.reset(time.monotonic())
    time.sleep(0.2)

    with pytest.raises(EncoderLostError, match="lost its count"):
        encoder.read()
    with pytest.raises(EncoderLostError, match="lost its count"):
        encoder.take_samples()
    encoder.close()


def test_a_device_that_restarts_while_it_is_opened_is_set_up_again(qsb):
    qsb.device.reset(time.monotonic())
    encoder = QsbEncoder(qsb.model())
    qsb.head.turn(600)
    time.sleep(0.1)
    count = encoder.read().count
    encoder.close()

    assert count == 600


def test_the_strobe_latches_exact_counts(qsb):
    encoder = QsbEncoder(qsb.model(frame_trigger=True))
    for _ in range(5):
        qsb.head.turn(10)
        qsb.device.trigger(time.monotonic())
        qsb.head.turn(3)
        time.sleep(0.05)
    captures = encoder.take_captures()
    encoder.close()

    assert captures.count.tolist() == [10, 23, 36, 49, 62]
    assert np.all(np.diff(captures.time_s) > 0.03)


def test_another_baud_rate_is_named_when_nothing_answers(plug_qsb):
    qsb = plug_qsb(baud=115200)

    with pytest.raises(EncoderLostError, match="230400 baud"):
        QsbEncoder(qsb.model(baud=230400))


def test_a_device_that_refuses_a_command_is_another_one(qsb, monkeypatch):
    monkeypatch.setattr("footscan.sim.emulators.qsb._WRITABLE", {0x16, 0x15})

    with pytest.raises(WrongDeviceError, match="refused"):
        QsbEncoder(qsb.model())


def test_a_port_is_used_by_one_program_at_a_time(qsb):
    encoder = QsbEncoder(qsb.model())

    with pytest.raises(EncoderLostError, match="is used by"):
        QsbEncoder(qsb.model())
    encoder.close()


def test_a_missing_port_is_said(qsb):
    model = qsb.model().model_copy(update={"port": "/dev/serial/by-id/usb-none"})

    with pytest.raises(EncoderLostError, match="does not exist; plug the device in"):
        QsbEncoder(model)


def test_a_missing_usb_serial_number_is_said(qsb):
    with pytest.raises(EncoderLostError, match="serial number A1 is plugged in"):
        QsbEncoder(qsb.model().model_copy(update={"port": "usb:A1"}))


def test_a_closed_encoder_says_so(qsb):
    encoder = QsbEncoder(qsb.model())
    encoder.close()

    with pytest.raises(EncoderLostError, match="closed"):
        encoder.read()
