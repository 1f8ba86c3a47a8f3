from footscan.optics.scanner import Scanner
from footscan.workflow.picture_bench import time_pictures


def test_both_feet_are_timed_at_the_size_of_the_designs_camera(prototype: Scanner):
    timings = list(time_pictures(prototype, 5))

    assert [timing.name for timing in timings] == ["foot", "foot, breathing"]
    assert {timing.size for timing in timings} == {"582x500"}
    assert all(0.0 < timing.ms[0] <= timing.ms[1] for timing in timings)
