"""From the shared recordings to a measured foot, against the true foot: surface, classes, measurements."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import trimesh

from footscan.config import load_calibration
from footscan.foot.measurements import Measurements, measure
from footscan.foot.skin_origin import Origin
from footscan.geometry.nearest import PointTree
from footscan.scanning.recording import open_recording
from footscan.workflow.foot import MeasuredFoot, measure_scan
from footscan.workflow.process import ProcessSettings, process_recording
from footscan.workflow.truth import distance_to_surface_mm

NAMES = ("foot-left-ideal", "foot-right-workshop")
# Values whose error on these two feet is explained in docs/decisions/0010: beyond the target of 0.2 or 0.5 mm.
KNOWN_MM = {
    "foot_length": 0.40,
    "overall_length": 0.40,
    "overall_breadth": 0.65,
    "foot_length_a1": 0.40,
    "malleolus_medialis_height": 0.70,
    "malleolus_lateralis_height": 0.30,
    "foot_breadth": 0.25,
    "foot_breadth_diagonal": 0.30,
    "ball_length": 0.45,
    "outside_ball_length": 0.30,
    "ball_height": 0.30,
    "midfoot_breadth": 0.45,
}


@dataclass(frozen=True)
class Compared:
    foot: MeasuredFoot
    truth: trimesh.Trimesh
    seen: np.ndarray
    true_measurements: Measurements


@pytest.fixture(scope="module", params=NAMES)
def compared(request, shared_dir) -> Compared:
    folder: Path = shared_dir / "data/recordings" / request.param
    recording = open_recording(folder)
    calibration = load_calibration(folder / "truth-calibration.toml")
    cloud = process_recording(recording, calibration, ProcessSettings()).cloud
    side = recording.info.side
    truth = trimesh.load(folder / "truth.stl", force="mesh", process=False)
    seen = np.load(folder / "truth-seen.npy") > 0
    return Compared(measure_scan(cloud, side, recording.info.subject), truth, seen, measure(truth, side))


def test_the_surface_is_closed_and_the_seen_skin_exact(compared):
    mesh = compared.foot.mesh
    samples, _ = trimesh.sample.sample_surface(mesh, 20000, seed=1)
    samples = samples[(samples[:, 2] > 3) & (samples[:, 2] < 95)]
    corners = np.asarray(compared.truth.triangles, dtype=float).reshape(-1, 3)
    off_mm = distance_to_surface_mm(samples, corners, np.arange(len(corners)).reshape(-1, 3))
    middles = np.asarray(compared.truth.triangles_center)
    on_seen = compared.seen[PointTree(middles).nearest(samples, 1)[1][:, 0]]

    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.volume > 0
    assert np.sqrt(np.mean(off_mm[on_seen] ** 2)) <= 0.10


def test_unseen_skin_is_never_called_seen(compared):
    samples, face = trimesh.sample.sample_surface(compared.truth, 40000, seed=3)
    band = (samples[:, 2] > 3) & (samples[:, 2] < 95)
    samples, seen = samples[band], compared.seen[face[band]]
    to_seen = PointTree(samples[seen]).nearest(samples, 1)[0][:, 0]
    to_unseen = PointTree(samples[~seen]).nearest(samples, 1)[0][:, 0]
    clear = np.where(seen, to_unseen, to_seen) > 1.0
    vertices = np.asarray(compared.foot.mesh.vertices)
    origin = np.asarray(compared.foot.mesh.vertex_attributes["origin"])
    called_seen = origin[PointTree(vertices).nearest(samples, 1)[1][:, 0]] == Origin.SEEN

    assert called_seen[clear & ~seen].mean() <= 0.05
    assert (~called_seen[clear & seen]).mean() <= 0.05


def test_measurements_are_those_of_the_true_foot(compared):
    for name, value in compared.foot.measurements.measurements.items():
        true = compared.true_measurements[name]
        if value.value is None or true.value is None or value.unit != "mm":
            continue
        if value.interval is not None:
            assert value.interval[0] <= true.value <= value.interval[1], name
        else:
            assert value.value == pytest.approx(true.value, abs=KNOWN_MM.get(name, 0.2)), name
