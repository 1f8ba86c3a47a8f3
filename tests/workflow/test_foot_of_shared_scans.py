"""From the shared recordings to a measured foot, against the true foot: surface, classes, measurements."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy.spatial import KDTree

from footscan.config import load_calibration
from footscan.foot.measurements import Measurements, measure
from footscan.foot.shell import shell_from_mesh
from footscan.foot.skin_origin import Origin
from footscan.foot.surface import fit_foot_surface
from footscan.foot.surface_mesh import mesh_from_surface
from footscan.geometry.nearest import PointTree
from footscan.scanning.recording import open_recording
from footscan.workflow.foot import MeasuredFoot, measure_scan
from footscan.workflow.foot_truth import compare_seen_tape
from footscan.workflow.process import ProcessSettings, ScanResult, process_recording
from footscan.workflow.truth import distance_to_surface_mm

NAMES = ("foot-left-ideal", "foot-right-workshop")
# Values beyond the target of 0.2 mm on one of these two feet; docs/decisions/0022 says why.
KNOWN_MM = {
    "foot_length": 0.32,
    "overall_length": 0.32,
    "overall_breadth": 0.23,
    "malleolus_medialis_height": 0.48,
    "malleolus_lateralis_height": 0.21,
    "ball_length": 0.34,
}
# Those of them that say themselves that they are not to be trusted so far.
DOUBTED = {"foot-left-ideal": (), "foot-right-workshop": ("malleolus_medialis_height", "ball_length")}
# A whole girth rests on the assumed edge of the sole as well.
GIRTH_MM = 0.9
# Tape over seen skin; the true leg of these feet is a prism with edges above 98 mm, which a scan rounds off.
SEEN_TAPE_MM = {"ankle_girth": 0.83}


@dataclass(frozen=True)
class Compared:
    name: str
    foot: MeasuredFoot
    truth: trimesh.Trimesh
    seen: np.ndarray
    true_measurements: Measurements
    result: ScanResult


@pytest.fixture(scope="module", params=NAMES)
def compared(request, shared_dir) -> Compared:
    folder: Path = shared_dir / "data/recordings" / request.param
    recording = open_recording(folder)
    calibration = load_calibration(folder / "truth-calibration.toml")
    result = process_recording(recording, calibration, ProcessSettings())
    side = recording.info.side
    truth = trimesh.load(folder / "truth.stl", force="mesh", process=False)
    seen = np.load(folder / "truth-seen.npy") > 0
    foot = measure_scan(result.cloud, side, recording.info.subject, xy_board=result.xy_board)
    return Compared(request.param, foot, truth, seen, measure(truth, side), result)


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
    assert np.sqrt(np.mean(off_mm[on_seen] ** 2)) <= 0.06


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

    assert called_seen[clear & ~seen].mean() <= 0.04
    assert (~called_seen[clear & seen]).mean() <= 0.03


def test_the_bare_board_brings_the_assumed_skin_nearer_to_the_true_skin(compared):
    cloud = compared.result.cloud
    corners = np.asarray(compared.truth.triangles, dtype=float).reshape(-1, 3)
    plain = fit_foot_surface(cloud.xyz_world, cloud.weight.astype(float), cloud.laser)
    off_mm = [
        distance_to_surface_mm(edge_of_sole(mesh), corners, np.arange(len(corners)).reshape(-1, 3))
        for mesh in (compared.foot.mesh, mesh_from_surface(plain))
    ]

    assert compared.foot.surface.closure.name == "bare-board"
    assert plain.closure.name == "curvature-rounded"
    assert np.median(off_mm[0]) < 0.45
    assert np.quantile(off_mm[0], 0.95) < 0.9 * np.quantile(off_mm[1], 0.95)


def edge_of_sole(mesh):
    """The assumed skin between board and seen skin, `(n, 3)`."""
    xyz = np.asarray(mesh.vertices)
    origin = np.asarray(mesh.vertex_attributes["origin"])
    return xyz[(origin == Origin.ASSUMED_SOLE) & (xyz[:, 2] > 1.0)]


def test_measurements_are_those_of_the_true_foot(compared):
    for name, value in compared.foot.measurements.measurements.items():
        true = compared.true_measurements[name]
        if value.value is None or true.value is None:
            continue
        if value.interval is not None:
            assert value.interval[0] <= true.value <= value.interval[1], name
            assert value.unit != "mm" or value.value == pytest.approx(true.value, abs=GIRTH_MM), name
        elif value.unit == "mm":
            assert value.value == pytest.approx(true.value, abs=KNOWN_MM.get(name, 0.2)), name
    for name in DOUBTED[compared.name]:
        assert not compared.foot.measurements[name].reliable, name


def test_girths_are_exact_on_the_skin_that_was_seen(compared):
    scanned, true = shell_from_mesh(compared.foot.mesh), shell_from_mesh(compared.truth)
    tapes = {
        name: value.tape for name, value in compared.foot.measurements.measurements.items() if value.tape is not None
    }

    assert len(tapes) == 6
    for name, tape in tapes.items():
        seen = compare_seen_tape(scanned, true, tape)
        assert seen.true_mm > 0.4 * seen.whole_mm, name
        assert seen.scanned_mm == pytest.approx(seen.true_mm, abs=SEEN_TAPE_MM.get(name, 0.4)), name


def test_the_skin_crosses_itself_nowhere_at_the_toes(compared):
    mesh = compared.foot.mesh
    middles = np.asarray(mesh.triangles_center) @ compared.foot.measurements.foot_from_input[0, :3]
    corners = np.asarray(mesh.triangles)
    on_board = corners[:, :, 2].max(axis=1) == 0.0
    corners = corners[(middles > np.quantile(middles, 0.75)) & ~on_board]

    assert len(corners) > 15000
    assert count_crossings(corners) == 0
    assert count_crossings(np.concatenate([corners[:2000], corners[:2000] + 0.4])) > 100


def count_crossings(corners):
    """How many edges of `(m, 3, 3)` facets run through another facet; facets that touch at a corner are left out."""
    middles = corners.mean(axis=1)
    reach = 2.0 * np.linalg.norm(corners - middles[:, None], axis=2).max()
    pairs = KDTree(middles).query_pairs(reach, output_type="ndarray")
    pairs = np.concatenate([pairs, pairs[:, ::-1]])
    low, high = corners.min(axis=1), corners.max(axis=1)
    a, b = pairs.T
    a, b = pairs[((low[a] < high[b]) & (low[b] < high[a])).all(axis=1)].T
    touching = (corners[a][:, :, None] == corners[b][:, None]).all(axis=3).any(axis=(1, 2))
    return sum(int(runs_through(corners[a[~touching]], corners[b[~touching]], k).sum()) for k in range(3))


def runs_through(facets, others, k):
    """Whether edge k of each `(n, 3, 3)` facet runs through the facet beside it."""
    begin, end = facets[:, k], facets[:, (k + 1) % 3]
    normal = np.cross(others[:, 1] - others[:, 0], others[:, 2] - others[:, 0])
    above, below = (((point - others[:, 0]) * normal).sum(axis=1) for point in (begin, end))
    through = above * below < 0
    share = above / np.where(through, above - below, 1.0)
    place = begin + share[:, None] * (end - begin)
    for j in range(3):
        edge = others[:, (j + 1) % 3] - others[:, j]
        through &= (np.cross(edge, place - others[:, j]) * normal).sum(axis=1) > 0
    return through
