import numpy as np
import pytest
import trimesh

from footscan.foot.measurements import TapePlane
from footscan.foot.shell import Shell, shell_from_mesh
from footscan.foot.skin_origin import Origin
from footscan.workflow.foot_truth import compare_seen_tape

LEVEL = TapePlane(np.array([0.0, 0.0, 10.0]), np.array([0.0, 0.0, 1.0]))


def tube(radius_mm, origin=None):
    shell = shell_from_mesh(trimesh.creation.cylinder(radius_mm, 60.0, sections=720))
    return Shell(shell.xyz, shell.faces, origin)


def test_the_tape_over_seen_skin_differs_by_the_radius():
    whole = compare_seen_tape(tube(40.0, np.zeros(1442, np.uint8)), tube(41.0), LEVEL)

    assert whole.scanned_mm == pytest.approx(2.0 * np.pi * 40.0, rel=1e-4)
    assert whole.true_mm == pytest.approx(2.0 * np.pi * 41.0, rel=1e-4)


def test_skin_that_was_not_seen_is_in_neither_number():
    scanned = tube(40.0)
    unseen = scanned.xyz[:, 0] < 0.0
    pulled = scanned.xyz * np.where(unseen, 0.9, 1.0)[:, None]
    origin = np.where(unseen, Origin.BRIDGED, Origin.SEEN).astype(np.uint8)
    half = compare_seen_tape(Shell(pulled, scanned.faces, origin), tube(40.0), LEVEL)

    assert half.true_mm == pytest.approx(np.pi * 40.0, rel=0.01)
    assert half.scanned_mm == pytest.approx(half.true_mm, rel=1e-3)
    assert half.whole_mm < 2.0 * np.pi * 40.0


def test_a_plane_beside_the_foot_is_refused():
    with pytest.raises(ValueError, match="misses"):
        compare_seen_tape(tube(40.0), tube(40.0), TapePlane(np.array([0.0, 0.0, 99.0]), LEVEL.normal))
