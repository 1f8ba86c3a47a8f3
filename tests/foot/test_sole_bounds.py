import numpy as np
import pytest
import trimesh

from footscan.foot.shell import Shell, shell_from_mesh
from footscan.foot.skin_origin import Origin
from footscan.foot.sole_bounds import area_interval_mm2, volume_interval_mm3


def tapered_block(top_mm=60.0, rim_mm=8.0, inset_mm=4.0):
    """A block of 100 x 40 mm without a top, whose assumed edge runs inwards from 8 mm down to a flat sole."""
    rings = []
    for z, inset in ((0.0, inset_mm), (rim_mm, 0.0), (top_mm, 0.0)):
        x, y = 50.0 - inset, 20.0 - inset
        rings.append([(-x, -y, z), (x, -y, z), (x, y, z), (-x, y, z)])
    xyz = np.array([*np.concatenate(rings), (0.0, 0.0, 0.0)])
    faces = [(12, (k + 1) % 4, k) for k in range(4)]
    for row in (0, 4):
        for k in range(4):
            a, b = row + k, row + (k + 1) % 4
            faces += [(a, b, b + 4), (a, b + 4, a + 4)]
    origin = np.array([Origin.ASSUMED_SOLE] * 4 + [Origin.SEEN] * 8 + [Origin.ASSUMED_SOLE], dtype=np.uint8)
    return Shell(xyz, np.array(faces), origin)


def test_a_volume_lies_between_a_sole_at_the_lowest_seen_skin_and_vertical_walls():
    shell = tapered_block()
    low, high = volume_interval_mm3(shell, 60.0, 52 * 4000.0 + 8 * 3500.0)
    margin = 0.05 * 52.0 * 280.0

    assert low == pytest.approx(52 * 4000.0 - margin, rel=1e-6)
    assert 60 * 4000.0 <= high <= 60 * 4000.0 + 0.01 * 60 * 4000.0


def test_a_surface_lies_between_a_sole_at_the_lowest_seen_skin_and_vertical_walls():
    shell = tapered_block()
    corners = shell.xyz[shell.faces]
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum()
    low, high = area_interval_mm2(shell, float(area))

    assert low == pytest.approx((52 * 280.0 + 4000.0) * 0.997, rel=1e-6)
    assert high == pytest.approx((60 * 280.0 + 4000.0) * 1.003, rel=1e-6)


def test_a_mesh_of_unknown_origin_gets_bounds_by_height():
    box = trimesh.creation.box((100.0, 40.0, 60.0)).subdivide().subdivide().subdivide()
    box.apply_translation((0.0, 0.0, 30.0))
    low, high = volume_interval_mm3(shell_from_mesh(box), 60.0, 240000.0)

    assert low < 0.9 * 240000.0
    assert high > 240000.0
