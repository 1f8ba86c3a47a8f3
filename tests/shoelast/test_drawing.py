"""The DXF holds sections where they are and the bottom pattern in plan and laid flat."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import ezdxf
import numpy as np
import pytest

from footscan.coordinates import Side
from footscan.shoelast.bottom_pattern import bottom_pattern
from footscan.shoelast.drawing import BESIDE_MM, save_last_dxf
from footscan.shoelast.handed import mirrored
from footscan.shoelast.model import Shoelast
from footscan.shoelast.patches import ChordDisc

Tub = Callable[[Side], Shoelast]


def _length(line: np.ndarray) -> float:
    return float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())


def _bent(shoelast: Shoelast, radius_mm: float) -> Shoelast:
    """The flat bottom rolled on a cylinder whose axis runs across: it can be laid flat without any stretch."""

    def roll(xyz: np.ndarray) -> np.ndarray:
        angle = xyz[..., 0] / radius_mm
        return np.stack([radius_mm * np.sin(angle), xyz[..., 1], radius_mm * (1.0 - np.cos(angle))], axis=-1)

    bottom = shoelast.bottom
    return replace(shoelast, bottom=ChordDisc(roll(bottom.net_mm), bottom.knots_s, bottom.knots_t))


@pytest.mark.parametrize("side", ["right", "left"])
def test_a_flat_bottom_is_its_own_development(tub: Tub, side: Side):
    pattern = bottom_pattern(tub(side))

    chord = pattern.middle[-1] - pattern.middle[0]
    ahead = chord / np.linalg.norm(chord)
    plan = (pattern.plan - pattern.middle[0]) @ np.array([[ahead[0], -ahead[1]], [ahead[1], ahead[0]]])
    assert np.linalg.norm(plan - pattern.developed, axis=1).max() < 0.05
    assert abs(pattern.edge_stretch) < 1e-4
    assert pattern.length_mm == pytest.approx(_length(pattern.middle), rel=1e-9)


def test_a_rolled_bottom_is_unrolled(bare_tub: Shoelast):
    flat, rolled = bottom_pattern(bare_tub), bottom_pattern(_bent(bare_tub, 150.0))

    assert np.ptp(rolled.plan[:, 0]) < np.ptp(flat.plan[:, 0]) - 25.0
    assert rolled.length_mm == pytest.approx(flat.length_mm, rel=2e-3), "control points on a circle span a little less"
    assert np.abs(rolled.developed - flat.developed).max() < 0.45
    assert abs(rolled.edge_stretch) < 1e-3


@pytest.mark.parametrize("side", ["right", "left"])
def test_the_file_holds_sections_at_their_places_and_the_patterns(tub: Tub, side: Side, tmp_path: Path):
    shoelast = tub(side)

    save_last_dxf(shoelast, tmp_path / "tub.dxf", "tub 38", spacing_mm=50.0)

    drawing = ezdxf.readfile(tmp_path / "tub.dxf")
    lines = {entity.dxf.layer: entity for entity in drawing.modelspace().query("POLYLINE")}
    sections = sorted(name for name in lines if name.startswith("SECTION_"))
    plan = np.array([vertex.dxf.location for vertex in lines["BOTTOM_PLAN"].vertices])
    developed = np.array([vertex.dxf.location for vertex in lines["BOTTOM_DEVELOPED"].vertices])
    edge = mirrored(shoelast.lines["feather_edge"], side)
    assert drawing.units == 4, "millimetres"
    assert not drawing.audit().errors
    assert sections == ["SECTION_0050", "SECTION_0100", "SECTION_0150", "SECTION_0200"]
    back = edge[:, 0].min()
    for name in sections:
        corners = np.array([vertex.dxf.location for vertex in lines[name].vertices])
        assert lines[name].is_closed
        assert np.allclose(corners[:, 0], back + float(name[-4:]), atol=0.01)
    middle = np.array([vertex.dxf.location for vertex in lines["SECTION_0150"].vertices])
    assert np.ptp(middle[:, 2]) == pytest.approx(80.0, abs=0.01)
    assert np.allclose([plan.min(axis=0)[:2], plan.max(axis=0)[:2]], [edge.min(0)[:2], edge.max(0)[:2]], atol=0.05)
    assert developed[:, 1].mean() == pytest.approx(-BESIDE_MM, abs=4.0)
    assert any("tub 38" in text.dxf.text for text in drawing.modelspace().query("TEXT"))
