"""Two lasts become one pair of shoes, or it is said why not."""

import numpy as np
import pytest

from footscan.errors import InputError
from footscan.shoelast.dimensions import dimensions
from footscan.shoelast.family import build_shoelast
from footscan.shoelast.last_library import LastEntry
from footscan.shoelast.last_pair import agreements, check_pair, with_even_cones
from footscan.shoelast.model import Shoelast
from footscan.shoelast.pair_rank import pair_design, rank_pair
from footscan.shoelast.prepared_foot import PreparedFoot, prepare_foot
from footscan.sim.foot import FootShape, build_foot
from footscan.sim.surface import trimesh_from_surface


@pytest.fixture(scope="module")
def smaller() -> Shoelast:
    return build_shoelast("therapeutic", 40.0, "h", 15.0, "wide")


@pytest.fixture(scope="module")
def feet() -> tuple[PreparedFoot, PreparedFoot]:
    """The right one is four sizes longer."""
    left, right = (
        prepare_foot(trimesh_from_surface(build_foot(shape)), shape.side)
        for shape in (FootShape("left", 1.0), FootShape("right", 1.1))
    )
    return left, right


def entries_of(feet: tuple[PreparedFoot, PreparedFoot], sizes: tuple[tuple[str, float], ...]) -> list[LastEntry]:
    """Lasts that would suit either foot, of the sizes and sides that are wanted: size 40 the left, 44 the right one."""
    found = []
    for side, size in sizes:
        foot = feet[0] if size < 42.0 else feet[1]
        wanted = {"ball_length": 0.0, "ball_girth": 4.0, "foot_length": 13.3}
        values = {name: foot.value(name) + more for name, more in wanted.items()}
        room = {"instep_girth": 5.0, "waist_girth": 4.0, "heel_breadth": 1.0, "foot_breadth": 1.0, "toe_height": 8.0}
        values |= {name: (foot.measurements[name].value or 0.0) + more for name, more in room.items()}
        renamed = {"foot_length": "stick_length", "heel_breadth": "heel_width", "foot_breadth": "ball_width"}
        renamed["toe_height"] = "toe_box_height"
        dims = {renamed.get(name, name): value for name, value in values.items()} | {"pitch": 15.0, "toe_spring": 10.0}
        eu = 0.15 * foot.value("foot_length") + 2.0
        name = f"Derby {size:g} H {side}"
        found.append(LastEntry(name.lower().replace(" ", "-"), name, side, dims, eu, "H", "men", 15.0))  # pyright: ignore[reportArgumentType]
    return found


def test_cones_become_equal_and_nothing_else_does(smaller: Shoelast):
    larger = build_shoelast("therapeutic", 41.0, "k", 15.0, "wide")
    before = dimensions(smaller)

    raised, same = with_even_cones(smaller, larger)
    after = dimensions(raised)

    assert same is larger
    assert after["cone_height"].value == pytest.approx(dimensions(larger)["cone_height"].value, abs=0.01)
    for name in ("stick_length", "ball_girth", "waist_girth", "heel_width", "pitch", "toe_spring", "toe_box_height"):
        assert after[name].value == pytest.approx(before[name].value, abs=0.01), name
    assert after["instep_girth"].value == pytest.approx(before["instep_girth"].value, abs=0.5)
    assert np.array_equal(raised.upper.net_mm[0], smaller.upper.net_mm[0])
    assert all(one.kept for one in agreements(raised, same).values())


def test_a_pair_has_one_style_pitch_and_toe(smaller: Shoelast):
    check_pair(smaller, build_shoelast("therapeutic", 41.0, "m", 15.0, "wide"))
    others = {
        "one style": build_shoelast("men", 41.0, "h", 12.0, "round"),
        "pitch is 15.0 and 25": build_shoelast("therapeutic", 40.0, "h", 25.0, "wide"),
        "toe": build_shoelast("therapeutic", 40.0, "h", 15.0, "round"),
    }

    for words, other in others.items():
        with pytest.raises(InputError, match=words):
            check_pair(smaller, other)


@pytest.mark.parametrize(
    ("name", "fitting", "same"),
    [
        ("men-eu42-g-12mm-round", "g", "men-eu44_5-h-12mm-round-left"),
        ("Derby 42 G", "G", "Derby 43 H left"),
        ("Derby 42 G", "G", "Derby 42 H graded eu43 +1 widths"),
    ],
)
def test_names_without_size_width_and_side_tell_the_design(name: str, fitting: str, same: str):
    one, other = (
        LastEntry("a", text, "left", {}, 42.0, width, "men") for text, width in ((name, fitting), (same, "h"))
    )
    another = LastEntry("a", name.replace("round", "almond").replace("Derby", "Oxford"), "left", {}, 42.0, "g", "men")

    assert pair_design(one) == pair_design(other)
    assert pair_design(one) != pair_design(another)


def test_feet_of_unlike_size_get_unlike_lasts_of_one_design(feet: tuple[PreparedFoot, PreparedFoot]):
    entries = entries_of(feet, (("left", 40.0), ("right", 40.0), ("left", 44.0), ("right", 44.0)))

    best = rank_pair(entries, feet, "therapeutic")[0]

    assert (best.left.entry.id, best.right.entry.id) == ("derby-40-h-left", "derby-44-h-right")
    assert not best.alike


def test_a_last_without_a_twin_stands_for_its_mirror_image(feet: tuple[PreparedFoot, PreparedFoot]):
    best = rank_pair(entries_of(feet, (("right", 40.0),)), feet, "therapeutic")[0]

    assert best.alike
    assert best.left.entry.id == best.right.entry.id == "derby-40-h-right"
    assert "mirror image of a right last" in best.left.reason


def test_two_feet_of_one_side_are_no_pair(feet: tuple[PreparedFoot, PreparedFoot]):
    with pytest.raises(InputError, match="found left and left"):
        rank_pair(entries_of(feet, (("right", 40.0),)), (feet[0], feet[0]), "therapeutic")
