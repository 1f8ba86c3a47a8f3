"""A last that left as 3DM and whose surfaces were fitted anew, as after a change in Rhino, is the same last."""

import numpy as np
import pytest

from footscan.geometry.nearest import PointTree
from footscan.shoelast.dimensions import dimensions
from footscan.shoelast.family import build_shoelast
from footscan.shoelast.import_last import ImportFit, shoelast_from_mesh
from footscan.shoelast.model import Shoelast
from footscan.shoelast.rhino_file import save_last_3dm
from footscan.shoelast.rhino_read import read_3dm


@pytest.fixture(scope="module")
def last() -> Shoelast:
    """On a heel so high that the back of the heel looks down when the last lies on its long axis."""
    return build_shoelast("women", 37, "f", 60, "almond", "left")


@pytest.fixture(scope="module")
def returned(last: Shoelast, tmp_path_factory: pytest.TempPathFactory) -> tuple[Shoelast, ImportFit]:
    path = tmp_path_factory.mktemp("round") / "last.3dm"
    save_last_3dm(last, path, "round trip")
    return shoelast_from_mesh(read_3dm(path), "left", "again")


def test_its_patches_lie_on_the_surfaces_of_the_file(returned: tuple[Shoelast, ImportFit]):
    fit = returned[1]

    assert fit.rms_mm <= 0.01
    assert fit.edge_rms_mm <= 0.01
    assert fit.largest_mm <= 0.1


def test_the_edges_are_the_curves_of_the_file(last: Shoelast, returned: tuple[Shoelast, ImportFit]):
    around = np.arange(4000) / 4000
    for level in (0.0, 1.0):
        before, after = (one.upper.grid(around, np.array([level]))[0] for one in (last, returned[0]))

        assert PointTree(before).nearest(after, 1)[0].max() < 0.25


def test_every_dimension_comes_back_as_the_datum_says_how_it_stood(
    last: Shoelast, returned: tuple[Shoelast, ImportFit]
):
    before, after = dimensions(last), dimensions(returned[0])
    wide = {"bottom_length": 0.25, "volume": 0.5}
    for name, value in before.items():
        assert after[name].value == pytest.approx(value.value, abs=wide.get(name, 0.1)), name


def test_nothing_had_to_be_mended(returned: tuple[Shoelast, ImportFit]):
    told = " | ".join(returned[0].remarks)

    assert "feather edge was taken from the file" in told
    for words in ("crumbs", "bridged", "duplicate", "more than two", "turned", "cross others"):
        assert words not in told, words
