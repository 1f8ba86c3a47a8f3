"""Lasts are kept in versions, found again, graded and mirrored; the built-in family is there at once."""

import json
from pathlib import Path

import numpy as np
import pytest

from footscan.errors import InputError, StorageError
from footscan.shoelast.dimensions import dimensions
from footscan.shoelast.family import build_shoelast
from footscan.shoelast.family_data import FamilyMember
from footscan.shoelast.family_index import is_current
from footscan.shoelast.grade import grade, mirror
from footscan.shoelast.last_library import BUILT_IN, INDEX, LastLibrary, family_entries
from footscan.shoelast.model import Shoelast


@pytest.fixture(scope="module")
def shoelast() -> Shoelast:
    return build_shoelast("women", 38, "g", 25, "round", stub=True)


@pytest.fixture
def library(tmp_path: Path) -> LastLibrary:
    return LastLibrary(tmp_path / "lasts")


def test_a_fresh_library_holds_the_built_in_family_of_both_sides(library: LastLibrary):
    entries = library.entries()

    assert len(entries) >= 2000
    assert {entry.side for entry in entries} == {"right", "left"}
    assert {entry.source for entry in entries} == {BUILT_IN}
    assert len({entry.id for entry in entries}) == len(entries)
    assert not library.folder.exists()


def test_the_shipped_index_belongs_to_the_design():
    assert is_current(), "run python -m footscan.shoelast.make_family_index"


@pytest.mark.parametrize(
    "last_id", ["men-eu43_5-f-12mm-round", "women-eu35-h-50mm-almond", "therapeutic-eu48-k-10mm-wide"]
)
def test_the_index_tells_what_the_built_last_measures(library: LastLibrary, last_id: str):
    told = library.entry(last_id).dimensions
    found = dimensions(library.load(last_id))

    for name, value in found.items():
        assert told[name] == pytest.approx(value.value, abs=0.15 if value.unit == "mm" else 1.0), name


def test_what_is_kept_comes_back_exactly(library: LastLibrary, shoelast: Shoelast):
    entry = library.add(shoelast, "a test", "mine")
    back = library.load("mine")

    assert np.array_equal(back.upper.net_mm, shoelast.upper.net_mm)
    assert np.array_equal(back.bottom.net_mm, shoelast.bottom.net_mm)
    assert back.lines.keys() == shoelast.lines.keys()
    assert back.points.keys() == shoelast.points.keys()
    assert back.attachments[0].kind == "stub"
    assert entry == library.entry("mine")
    assert entry.dimensions["ball_girth"] == pytest.approx(220.7, abs=0.1)


def test_a_newer_version_leaves_the_older_one_as_it_was(library: LastLibrary, shoelast: Shoelast):
    library.add(shoelast, "first", "mine")
    first = (library.folder / "mine" / "v0001.npz").read_bytes()
    second = library.add(mirror(shoelast), "second", "mine")

    assert second.version == 2
    assert library.versions("mine") == (1, 2)
    assert (library.folder / "mine" / "v0001.npz").read_bytes() == first
    assert library.load("mine", 1).side == "right"
    assert library.load("mine").side == "left"


def test_lasts_of_one_name_get_ids_of_their_own(library: LastLibrary, shoelast: Shoelast):
    named = mirror(shoelast)

    assert [library.add(named, "x").id for _ in range(2)] == [
        "women-eu38-g-25mm-round-left-2",
        "women-eu38-g-25mm-round-left-3",
    ]


def test_a_spoilt_index_is_made_again(library: LastLibrary, shoelast: Shoelast):
    entry = library.add(shoelast, "x", "mine")
    library.entries()
    (library.folder / INDEX).write_text("{")

    assert library.entry("mine") == entry
    assert json.loads((library.folder / INDEX).read_text())["lasts"].keys() == {"mine/1"}


def test_a_damaged_last_is_named(library: LastLibrary, shoelast: Shoelast):
    library.add(shoelast, "x", "mine")
    place = library.folder / "mine" / "v0001.npz"
    place.chmod(0o600)
    place.write_bytes(b"half")

    with pytest.raises(InputError, match=r"v0001\.npz"):
        library.load("mine")


@pytest.mark.parametrize("last_id", ["Mine", "../up", "", "men-eu42-g-12mm-round"])
def test_ids_that_would_confuse_are_refused(library: LastLibrary, shoelast: Shoelast, last_id: str):
    with pytest.raises(InputError):
        library.add(shoelast, "x", last_id or ".")


def test_an_unknown_id_names_its_neighbours(library: LastLibrary):
    with pytest.raises(InputError, match="men-eu42-g-12mm-round"):
        library.entry("men-eu42-g-12mm-rund")


def test_a_place_that_cannot_be_written_keeps_nothing(tmp_path: Path, shoelast: Shoelast):
    (tmp_path / "file").write_text("")

    with pytest.raises(StorageError):
        LastLibrary(tmp_path / "file").add(shoelast, "x", "mine")


def test_a_grade_grows_by_the_trades_steps_and_keeps_the_heel(shoelast: Shoelast):
    before, after = dimensions(shoelast), dimensions(grade(shoelast, 40, 1))

    assert after["ball_girth"].value - before["ball_girth"].value == pytest.approx(2 * 4.5 + 5.0, abs=0.1)
    assert after["instep_girth"].value - before["instep_girth"].value == pytest.approx(2 * 4.5 + 4.6, abs=0.1)
    assert after["stick_length"].value - before["stick_length"].value == pytest.approx(2 * 20 / 3, abs=0.3)
    assert after["pitch"].value == pytest.approx(before["pitch"].value, abs=0.3)
    assert after["toe_spring"].value == pytest.approx(before["toe_spring"].value, abs=0.3)


def test_a_grade_of_nothing_or_of_ten_sizes_is_refused(shoelast: Shoelast):
    with pytest.raises(InputError, match="already"):
        grade(shoelast, 38)
    with pytest.raises(InputError, match="no grade"):
        grade(shoelast, 48)


def test_a_mirrored_last_measures_the_same(shoelast: Shoelast):
    other = mirror(shoelast)

    assert other.side == "left"
    assert dimensions(other) == dimensions(shoelast)


def test_names_of_the_family_and_its_ids_are_one():
    assert {entry.id for entry in family_entries()} >= {FamilyMember("men", 42, "g", 12, "round", "left").name}
