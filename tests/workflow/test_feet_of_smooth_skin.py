"""The shared feet with their mesh's edges rounded, as skin is: what a scan measures against the same foot's true mesh.

Their triangles of 3.5 mm meet at up to 25 degrees, and no stripe follows such an edge to its tip (decision 22).
`pytest -m slow --log-cli-level=INFO` on this file prints every difference.
"""

import logging
from pathlib import Path

import pytest
import trimesh

from footscan.config import load_calibration
from footscan.coordinates import Side
from footscan.foot.measurements import measure
from footscan.foot.shell import shell_from_mesh
from footscan.optics.scanner import Scanner
from footscan.scanning.recording import open_recording
from footscan.workflow.foot import measure_scan
from footscan.workflow.foot_truth import compare_seen_tape
from footscan.workflow.process import ProcessSettings, process_recording
from footscan.workflow.simulate import SimulateSettings, simulate_scan

_log = logging.getLogger(__name__)
FEET: dict[Side, str] = {"left": "foot-left-ideal", "right": "foot-right-workshop"}


def _rounded(true_mesh: Path, path: Path) -> Path:
    """The mesh with its edges rounded by Loop's rule, twice."""
    mesh = trimesh.load(true_mesh, force="mesh")
    mesh.update_faces(mesh.nondegenerate_faces() & mesh.unique_faces())
    mesh.remove_unreferenced_vertices()
    mesh.subdivide_loop(2).export(path)
    return path


@pytest.mark.slow
@pytest.mark.parametrize("side", list(FEET))
def test_all_that_is_called_reliable_is_within_its_target(
    side: Side, shared_dir: Path, prototype: Scanner, tmp_path: Path
):
    thing = _rounded(shared_dir / "data/recordings" / FEET[side] / "truth.stl", tmp_path / "smooth.stl")
    folder = tmp_path / "recording"
    simulate_scan(prototype, SimulateSettings(thing=str(thing), side=side, seed=7), folder, lambda done, total: None)
    recording = open_recording(folder)
    result = process_recording(recording, load_calibration(folder / "truth-calibration.toml"), ProcessSettings())
    foot = measure_scan(result.cloud, side, recording.info.subject, xy_board=result.xy_board)
    true_mesh = trimesh.load(folder / "truth.stl", force="mesh", process=False)
    true = measure(true_mesh, side)
    shells = shell_from_mesh(foot.mesh), shell_from_mesh(true_mesh)
    judged = 0
    for name, value in foot.measurements.measurements.items():
        if value.value is None or true[name].value is None or value.unit != "mm":
            continue
        _log.info("%s %s: %+.3f mm, reliable: %s", side, name, value.value - true[name].value, value.reliable)
        if value.interval is not None:
            assert value.interval[0] <= true[name].value <= value.interval[1], name
        elif value.reliable:
            judged += 1
            assert value.value == pytest.approx(true[name].value, abs=0.2), name
        if value.tape is not None:
            seen = compare_seen_tape(*shells, value.tape)
            _log.info("    over seen skin %+.3f of %.0f mm", seen.scanned_mm - seen.true_mm, seen.true_mm)
            assert seen.scanned_mm == pytest.approx(seen.true_mm, abs=0.5), name

    assert judged >= 8
