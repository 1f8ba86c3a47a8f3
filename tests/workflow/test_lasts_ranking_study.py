"""Feet of any size get a last by the size rule; the study can tell when they do not."""

import numpy as np
import pytest

from footscan.shoelast.last_library import family_entries
from footscan.shoelast.prepared_foot import prepare_foot
from footscan.sim.foot import FootShape, build_foot
from footscan.sim.surface import trimesh_from_surface
from footscan.workflow.lasts_ranking_study import ranking_outcome, run_ranking_study


@pytest.mark.parametrize("side", ["left", "right"])
def test_the_first_of_the_ranking_follows_the_size_rule(side: str):
    mesh = trimesh_from_surface(build_foot(FootShape("left" if side == "left" else "right", 1.0)))

    outcomes = list(run_ranking_study([("foot", mesh, None)], list(family_entries()), (0.9, 1.08)))

    assert [one.side for one in outcomes] == [side, side]
    assert all(one.well for one in outcomes)
    assert outcomes[1].foot_length_mm / outcomes[0].foot_length_mm == pytest.approx(1.2, abs=0.005)


def test_a_library_without_the_size_is_not_well():
    foot = prepare_foot(trimesh_from_surface(build_foot(FootShape("right", 1.0))), "right")
    small = [entry for entry in family_entries() if (entry.size_eu or 0.0) <= 38.0]

    outcome = ranking_outcome("foot", 1.0, foot, small, "therapeutic")

    assert not outcome.well
    assert outcome.sizes_off < -0.5
    assert np.isfinite(outcome.widths_off)
