"""The Last tab in a real browser: rank, lay round the foot, a pin, customise, take away."""

import re
from pathlib import Path

import pytest
import trimesh

from footscan.gui import texts
from footscan.gui.visitor import Visitor as Operator
from footscan.shoelast.rhino_read import read_3dm
from tests.gui.conftest import Served
from tests.gui.until import until

pytestmark = [pytest.mark.browser, pytest.mark.slow]
"""Takes minutes on two busy cores; the small scan of these tests is at the edge of what can be customised."""


@pytest.fixture
def clinician(me: Operator, measured_patient: str) -> Operator:
    me.takes_patient(measured_patient)
    me.goes_to(texts.TAB_LAST)
    return me


def test_from_a_measured_foot_to_a_customised_last(clinician: Operator, served: Served, tmp_path: Path) -> None:
    desk = served.page.desk
    clinician.presses(texts.LAST_RANK)
    until(lambda: len(desk.state.last.ranking) > 0 and desk.state.job is None)
    ranking = desk.state.last.ranking
    clinician.sees(ranking[0].entry.name)
    clinician.presses(texts.LAST_COMPARE)
    until(lambda: desk.state.last.fitted is not None)
    clinician.sees(re.compile("never seen|negative: the foot stands out"))
    clinician.chooses(texts.LAST_SHOW, "Clearance map")
    until(lambda: desk.state.last.shown == "Clearance map")
    clinician.sees(re.compile("never seen, or above the last: not judged"))
    clinician.picture(tmp_path / "clearance.png")
    clinician.presses(texts.LAST_PIN_ADD)
    clinician.sees(re.compile("1 pins: metatarsale tibiale"))
    clinician.presses(texts.LAST_CUSTOMISE)
    until(lambda: desk.state.last.custom is not None, 120.0)
    clinician.sees(re.compile("The last (holds|does not hold)"))
    clinician.picture(tmp_path / "customised.png")
    custom = desk.state.last.custom
    files: dict[str, Path] = {}
    for label in ("STL", "3DM", "Sheet"):
        with clinician.tab.expect_download() as download:
            clinician.button(label).click()
        files[label] = tmp_path / download.value.suggested_filename
        download.value.save_as(files[label])

    assert custom is not None
    assert [one.score for one in ranking] == sorted(one.score for one in ranking)
    assert all(one.entry.side == "left" for one in ranking)
    assert custom.shoelast.side == "left"
    assert custom.changed.any()
    mesh = read_3dm(files["3DM"]).mesh
    mesh.merge_vertices(digits_vertex=4)
    assert mesh.volume == pytest.approx(custom.skin.mesh().volume, rel=1e-3)
    milled = trimesh.load_mesh(files["STL"])
    assert milled.is_watertight
    assert milled.volume == pytest.approx(mesh.volume, rel=1e-3)
    assert milled.extents == pytest.approx(mesh.extents, abs=0.1)
    assert files["STL"].name == f"{desk.state.last.last_id}-customised.stl"
    assert files["3DM"].name == f"{desk.state.last.last_id}-customised.3dm"
    assert files["Sheet"].read_bytes().startswith(b"%PDF")
    clinician.presses(texts.LAST_HIDE)
    until(lambda: desk.state.last.custom is None)
