"""The Last tab in a real browser: rank, lay round the foot, a pin, customise, take away as a file that is opened."""

from pathlib import Path

import pytest
import trimesh

from footscan.gui import texts
from footscan.gui.visitor import Visitor as Operator
from tests.gui.conftest import Served
from tests.gui.until import until

pytestmark = pytest.mark.browser


@pytest.fixture
def clinician(me: Operator, measured_patient: str) -> Operator:
    me.takes_patient(measured_patient)
    me.goes_to(texts.TAB_LAST)
    return me


def test_from_a_measured_foot_to_a_customised_last(clinician: Operator, served: Served, tmp_path: Path) -> None:
    desk = served.page.desk
    clinician.presses(texts.LAST_RANK)
    until(lambda: len(desk.state.last.ranking) > 0 and desk.state.job is None)
    ranking, chosen = desk.state.last.ranking, desk.state.last.last_id
    clinician.presses(texts.LAST_COMPARE)
    until(lambda: desk.state.last.fitted is not None)
    clinician.sees(texts.LAST_REGION_NOTE)
    clinician.chooses(texts.LAST_SHOW, "Clearance map")
    until(lambda: desk.state.last.shown == "Clearance map")
    clinician.presses(texts.LAST_PIN_ADD)
    clinician.sees("Pins (1): inner ball joint +2 mm over 15 mm")
    clinician.presses(texts.LAST_CUSTOMISE)
    until(lambda: desk.state.last.custom is not None)
    custom = desk.state.last.custom
    assert custom is not None
    clinician.sees(texts.LAST_MADE_HOLDS if custom.proof.holds else texts.LAST_MADE_NOT)
    with clinician.tab.expect_download() as download:
        clinician.button("STL").click()
    download.value.save_as(tmp_path / "milled.stl")
    milled, made = trimesh.load_mesh(tmp_path / "milled.stl"), custom.skin.mesh()

    assert [one.score for one in ranking] == sorted(one.score for one in ranking)
    assert {one.entry.side for one in ranking} == {custom.shoelast.side} == {"left"}
    assert custom.changed.any()
    assert download.value.suggested_filename == f"{chosen}-customised.stl"
    assert milled.is_watertight
    assert milled.volume == pytest.approx(made.volume, rel=1e-3)
    assert sorted(milled.extents) == pytest.approx(sorted(made.extents), abs=0.1)
    clinician.presses(texts.LAST_HIDE)
    clinician.button(texts.LAST_UNHIDE).wait_for()
    assert desk.state.last.custom is custom
    clinician.takes_patient("Jürgen Muster")

    assert (desk.state.last.custom, desk.state.last.ranking) == (None, ())
