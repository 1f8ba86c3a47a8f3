"""A thread that ended is told in words; what a programmer needs stands in the log."""

import pytest

from footscan.errors import DeviceError
from footscan.scanning.session.queue_thread import failure_of_thread


def test_an_unexpected_end_is_told_without_the_raw_text_which_the_log_keeps(caplog: pytest.LogCaptureFixture) -> None:
    told = str(failure_of_thread("writes the recording", ValueError("-215:Assertion failed")))

    assert "writes the recording" in told and "everything was switched off" in told
    assert "Assertion" not in told
    assert "-215:Assertion failed" in caplog.text


def test_a_fault_that_has_words_of_its_own_is_told_with_them() -> None:
    fault = DeviceError("the camera is gone; check its cable.")

    assert failure_of_thread("takes the frames", fault) is fault
