import numpy as np

from footscan.foot.nurbs import SplineTube, clamped_knots, greville
from footscan.foot.surface_bench import compare_fits


def test_both_fits_run_on_the_same_grid() -> None:
    knots = clamped_knots(np.linspace(0.0, 1.0, 6))
    turn, rise = 2.0 * np.pi * np.arange(12) / 12, 60.0 * greville(knots)[:, None]
    net = np.stack(np.broadcast_arrays(40 * np.cos(turn), 30 * np.sin(turn), rise), axis=2)

    times = compare_fits(SplineTube(np.ascontiguousarray(net), knots), (24, 16), (14, 8))

    assert (times.points, times.controls) == (384, 112)
    assert times.ours_rms_mm < 0.2
    assert times.ratio == times.geomdl_s / times.ours_s
