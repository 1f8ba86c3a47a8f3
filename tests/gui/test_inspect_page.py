"""The clinician's tab in a real browser: sections, maps, smoothing on a copy, files."""

import csv
import json
import re
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
    me.goes_to(texts.TAB_INSPECT)
    me.sees(re.compile("tape girth"))
    return me


def _tape_mm(me: Operator) -> float:
    found = re.search(r"tape girth ([\d.]+) mm", me.html("tape girth"))
    assert found is not None
    return float(found[1])


def test_a_section_follows_the_sliders(clinician: Operator, served: Served) -> None:
    middle_mm = _tape_mm(clinician)
    clinician.drags(texts.SECTION_SHARE, 70)
    until(lambda: _tape_mm(clinician) < middle_mm)  # the toes; on the way there the instep is passed, or the ball
    toes_mm = _tape_mm(clinician)
    clinician.drags(texts.SECTION_TILT, 110)
    until(lambda: abs(served.page.desk.state.inspect.tilt_deg) > 45)
    until(lambda: _tape_mm(clinician) > middle_mm)

    assert 180 < middle_mm < 300
    assert toes_mm > 50
    clinician.drags(texts.SECTION_SHARE, 300)
    clinician.drags(texts.SECTION_TILT, -300)


def test_downloads_hold_the_measured_foot(clinician: Operator, tmp_path: Path) -> None:
    for name, file_name in {
        name: file for files in texts.DOWNLOAD_NAMES.values() for name, file in files.items()
    }.items():
        with clinician.tab.expect_download() as download:
            clinician.button(name).click()
        download.value.save_as(tmp_path / file_name)
    mesh = trimesh.load_mesh(tmp_path / "surface.stl")
    measured = json.loads((tmp_path / "measurements.json").read_text())["measurements"]
    with (tmp_path / "measurements.csv").open(newline="") as stream:
        rows = {row["name"]: row for row in csv.DictReader(stream)}

    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(trimesh.load_mesh(tmp_path / "surface.ply").volume, rel=1e-4)
    assert measured.keys() == rows.keys()
    assert float(rows["foot_length"]["value"]) == measured["foot_length"]["value"]
    assert "pternion" in rows["foot_length"]["definition"]
    assert (tmp_path / "report.png").read_bytes().startswith(b"\x89PNG")


def test_maps_have_legends_and_names_their_definition(clinician: Operator, served: Served) -> None:
    clinician.chooses(texts.SHOW, "Distance to points")
    clinician.sees(re.compile("0.4 mm or more"))
    clinician.chooses(texts.SHOW, "Seen / assumed")
    clinician.sees("assumed")
    meaning = clinician.tab.get_by_text("ball girth", exact=True).first.get_attribute("title")

    assert meaning is not None and "metatars" in meaning.lower()


def test_smoothing_is_tried_on_a_copy_and_states_its_price(clinician: Operator, served: Served) -> None:
    before = served.page.desk.state.takes[0].result
    clinician.unfolds(texts.SMOOTHING)
    clinician.presses(texts.SMOOTH_GO)
    clinician.button(texts.SMOOTH_BACK).wait_for()
    tried = served.page.desk.state.inspect.tried

    assert tried is not None
    assert tried.price["after"]["mesh_volume_cm3"] != tried.price["before"]["mesh_volume_cm3"]
    assert tried.price["after"]["foot_length"] == pytest.approx(tried.price["before"]["foot_length"], abs=0.6)
    clinician.sees(re.compile("^Shown: filter"))
    clinician.presses(texts.SMOOTH_BACK)
    until(lambda: served.page.desk.state.inspect.tried is None)
    assert served.page.desk.state.takes[0].result == before


def test_stop_stays_in_view_however_far_a_tab_is_scrolled(clinician: Operator) -> None:
    clinician.tab.get_by_text("Sections", exact=True).last.scroll_into_view_if_needed()
    box = clinician.button(texts.STOP).bounding_box()
    tabs = clinician.tab.get_by_role("tablist").last.bounding_box()

    assert box is not None and tabs is not None
    assert 0 <= box["y"] < 120
    assert box["y"] + box["height"] < tabs["y"]
