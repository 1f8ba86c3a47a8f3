"""Simulated time: it stands still while a thread works; paced, it is never faster than it may be."""

import threading
import time

from footscan.sim.clock import VirtualClock


def test_time_jumps_to_the_next_moment_anybody_waits_for() -> None:
    clock = VirtualClock()
    clock.join()
    begun_s = time.monotonic()
    clock.wait(clock.now_s() + 3600.0)

    assert clock.now_s() == 4600.0
    assert time.monotonic() - begun_s < 60.0


def test_paced_time_is_no_faster_than_its_pace() -> None:
    clock = VirtualClock(pace=10.0)
    clock.join()
    begun_s = time.monotonic()
    for _ in range(20):
        clock.wait(clock.now_s() + 0.1)

    assert abs(clock.now_s() - 1002.0) < 1e-6
    assert time.monotonic() - begun_s >= 0.19


def test_paced_time_stands_still_while_a_thread_works_and_does_not_hurry_afterwards() -> None:
    clock = VirtualClock(pace=100.0)
    clock.join()
    clock.wait(clock.now_s() + 1.0)
    time.sleep(0.1)
    worked_s, begun_s = clock.now_s(), time.monotonic()
    for _ in range(11):
        clock.wait(clock.now_s() + 0.5)

    assert worked_s == 1001.0
    assert time.monotonic() - begun_s >= 0.05  # ten of the steps: the first was made while the thread worked


def test_a_notice_wakes_who_waits_in_paced_time() -> None:
    clock, noticed = VirtualClock(pace=1.0), threading.Event()
    clock.join()
    clock.join()
    woken: list[bool] = []

    def waits() -> None:
        woken.append(clock.wait(clock.now_s() + 0.2, noticed.is_set))
        clock.leave()

    thread = threading.Thread(target=waits)
    thread.start()
    noticed.set()
    clock.notify()
    clock.leave()
    thread.join(20.0)

    assert woken == [True]
