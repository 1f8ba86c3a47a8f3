"""Ranking follows the size rule, keeps the wrong side last and shows the parts of its scores."""

import pytest

from footscan.errors import InputError
from footscan.shoelast.family_data import nominal_girths_mm
from footscan.shoelast.last_library import LastEntry, family_entries
from footscan.shoelast.prepared_foot import PreparedFoot, prepare_foot
from footscan.shoelast.profile import load_profile
from footscan.shoelast.rank import rank, rank_by_values
from footscan.sim.foot import FootShape, build_foot
from footscan.sim.surface import trimesh_from_surface


@pytest.fixture(scope="module")
def entries() -> list[LastEntry]:
    return list(family_entries())


@pytest.fixture(scope="module")
def foot() -> PreparedFoot:
    return prepare_foot(trimesh_from_surface(build_foot(FootShape("left", 1.0))), "left")


@pytest.mark.parametrize("size_eu", [37.0, 39.5, 42.0, 45.0])
@pytest.mark.parametrize("fitting", ["g", "h", "k"])
def test_a_foot_made_for_a_last_finds_its_size_and_width(entries: list[LastEntry], size_eu: float, fitting: str):
    length = (size_eu - 2.0) / 0.15
    girth = nominal_girths_mm("therapeutic", size_eu, fitting)["ball_girth"]
    values = {"foot_length": length, "ball_length": 0.735 * length, "ball_girth": girth - 4.0}

    best = rank_by_values(entries, values, "right", load_profile("therapeutic"))[0].entry

    assert best.side == "right"
    assert abs((best.size_eu or 0.0) - size_eu) <= 0.5
    near = [nominal_girths_mm(best.style, best.size_eu or 0.0, best.fitting)["ball_girth"]]
    assert abs(near[0] - girth) <= 7.0


def test_the_wrong_side_comes_after_every_usable_last(entries: list[LastEntry], foot: PreparedFoot):
    ranking = rank(entries, foot)
    sides = [one.entry.side for one in ranking]

    usable = [one.entry.side for one in ranking if not one.reason]
    assert set(usable) == {"left"}
    assert set(sides[: len(usable)]) == {"left"}
    assert all("right last" in one.reason for one in ranking if one.entry.side == "right")


def test_lasts_too_high_for_a_flat_scan_come_last_and_say_so(entries: list[LastEntry], foot: PreparedFoot):
    ranking = rank(entries, foot)
    high = [one for one in ranking if (one.entry.pitch_mm or 0.0) > 35.0]

    assert high
    assert all("on a wedge of about" in one.reason for one in high)
    assert min(one.score for one in high) > max(one.score for one in ranking if not one.reason)


def test_the_wrong_side_falls_below_the_median_unless_it_is_the_only_one_of_its_kind(
    entries: list[LastEntry], foot: PreparedFoot
):
    ranking = rank(entries, foot)
    best = ranking[0].entry.id
    twin = best.removesuffix("-left")

    without = rank([entry for entry in entries if entry.id != best], foot)
    place = {one.entry.id: k for k, one in enumerate(ranking)}
    usable = sum(not one.reason for one in without)

    assert {one.entry.side for one in ranking[: len(ranking) // 2]} == {"left"}
    assert place[twin] >= len(ranking) // 2
    assert without[usable].entry.id == twin


def test_two_widths_off_comes_after_every_last_of_the_right_width(entries: list[LastEntry]):
    length = 266.7
    girth = nominal_girths_mm("therapeutic", 42.0, "g")["ball_girth"]
    values = {"foot_length": length, "ball_length": 0.735 * length, "ball_girth": girth - 4.0}
    ranking = rank_by_values(entries, values, "right", load_profile("therapeutic"))

    place = next(k for k, one in enumerate(ranking) if one.entry.id == "therapeutic-eu42-k-15mm-wide")

    assert place >= sum(not one.reason for one in ranking) > 300
    assert "wide" in ranking[place].reason


def test_the_parts_make_up_the_score(entries: list[LastEntry], foot: PreparedFoot):
    for one in rank(entries, foot)[:20]:
        assert one.reason or one.score == pytest.approx(sum(one.parts.values()))


def test_an_empty_library_is_said(foot: PreparedFoot):
    with pytest.raises(InputError, match="no lasts"):
        rank([], foot)
