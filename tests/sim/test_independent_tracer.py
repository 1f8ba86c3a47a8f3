"""Our picture against recordings made by an independent ray tracer: same foot, same machine, same angles."""

import os
from pathlib import Path

import cv2
import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from footscan.config import load_calibration
from footscan.coordinates import Floats, Frame
from footscan.optics.calibration import theta_from_encoder
from footscan.scanning.recording import open_recording
from footscan.scanning.stripe import find_stripe
from footscan.sim.picture import Painter
from footscan.sim.surface import surface_from_trimesh

SHARED = os.environ.get("FOOTSCAN_SHARED")
pytestmark = pytest.mark.skipif(SHARED is None, reason="FOOTSCAN_SHARED does not say where the shared recordings are")
THRESHOLD = 40


def across(frame: Frame, reference: Frame) -> tuple[Floats, Floats, Floats]:
    """Distance across the stripe where both pictures show it, and each one's distance to the other, px."""
    ours, theirs = find_stripe(frame, THRESHOLD).uv, find_stripe(reference, THRESHOLD).uv
    away, near = cKDTree(theirs).query(ours, k=2)
    along = theirs[near[:, 1]] - theirs[near[:, 0]]
    length = np.linalg.norm(along, axis=1)
    normal = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.maximum(length, 1e-9)[:, None]
    both = (away[:, 0] < 1.0) & (length > 0.3) & (length < 2.0)
    off = np.sum((ours - theirs[near[:, 0]]) * normal, axis=1)[both]
    return off, away[:, 0], cKDTree(ours).query(theirs)[0]


@pytest.mark.parametrize("name", ["foot-left-ideal", "foot-right-workshop"])
def test_stripes_lie_where_an_independent_tracer_puts_them(name: str):
    folder = Path(SHARED or "") / "data" / "recordings" / name
    calibration = load_calibration(folder / "truth-calibration.toml")
    recording = open_recording(folder)
    track = recording.encoder
    exposure_s = np.array([record.time_s for record in recording.frames]) - calibration.latency_s
    theta = theta_from_encoder(np.interp(exposure_s, track.time_s, track.count), calibration.encoder)
    painter = Painter(calibration, surface_from_trimesh(trimesh.load(folder / "truth.stl")))
    compared = [
        across(
            painter.paint(float(theta[i]), recording.frames[i].laser, i),
            cv2.imread(str(recording.path(recording.frames[i])), cv2.IMREAD_UNCHANGED),
        )
        for i in range(0, 480, 15)
    ]
    off, ours, theirs = (np.concatenate([part[k] for part in compared]) for k in range(3))

    assert len(off) > 10_000
    assert np.sqrt(np.mean(off**2)) <= 0.05
    assert abs(np.mean(off)) <= 0.003
    assert np.mean(ours < 1.5) > 0.98
    assert np.mean(theirs < 1.5) > 0.98
