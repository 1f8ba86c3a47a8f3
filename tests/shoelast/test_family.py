"""A built-in last is a plausible last: closed, sharp at its feather edge, standing at its pitch, true to its table."""

import numpy as np
import pytest

from footscan.errors import InputError
from footscan.shoelast.dimensions import dimensions
from footscan.shoelast.family import build_shoelast
from footscan.shoelast.family_data import GIRTHS, FamilyMember, family_members, nominal_girths_mm
from footscan.shoelast.model import Shoelast
from footscan.shoelast.pose import moved
from footscan.shoelast.skin import BOTTOM, UPPER, Sampling, skin_of

MEMBERS = (
    ("women", 38.0, "g", 25.0, "round"),
    ("men", 44.5, "h", 12.0, "almond"),
    ("therapeutic", 40.0, "h", 15.0, "wide"),
    ("women", 35.0, "f", 50.0, "almond"),
)


@pytest.fixture(scope="module", params=MEMBERS, ids=lambda m: FamilyMember(*m).name)
def shoelast(request: pytest.FixtureRequest) -> Shoelast:
    return build_shoelast(*request.param)


def test_its_girths_are_the_tables(shoelast: Shoelast):
    found = dimensions(shoelast)
    table = nominal_girths_mm(shoelast.style, shoelast.size_eu or 0.0, shoelast.fitting)

    assert {name: found[name].value for name in GIRTHS} == pytest.approx(table, abs=0.1)


def test_it_stands_at_its_pitch_with_its_toe_up(shoelast: Shoelast):
    found = dimensions(shoelast)
    pitch = float(shoelast.name.split("-")[3].removesuffix("mm"))

    assert found["pitch"].value == pytest.approx(pitch, abs=0.3)
    assert 5.0 < found["toe_spring"].value < 15.0
    assert shoelast.points["tread_point"][2] == pytest.approx(0.0, abs=1e-3)


def test_its_skin_is_closed_and_turned_outward(shoelast: Shoelast):
    mesh = skin_of(shoelast).mesh()

    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.volume > 0


def test_its_feather_edge_is_sharp_all_round(shoelast: Shoelast):
    assert feather_turn_deg(shoelast).min() > 40.0


def test_its_bottom_is_convex_across_and_hollow_at_the_medial_shank(shoelast: Shoelast):
    share = np.linspace(0.05, 0.9, 30)
    lateral, middle, medial = np.moveaxis(shoelast.bottom.grid(share, np.array([0.0, 0.5, 1.0])), 1, 0)

    assert np.all(middle[:, 2] < 0.5 * (lateral + medial)[:, 2])
    assert (medial - middle)[:, 2].max() > 5.0
    assert share[(medial - middle)[:, 2].argmax()] < 0.6


def test_its_ball_is_oblique_and_its_toe_turned_in(shoelast: Shoelast):
    medial, lateral = shoelast.points["ball_medial"], shoelast.points["ball_lateral"]

    assert 10.0 < medial[0] - lateral[0] < 40.0
    assert medial[1] > 0 > lateral[1]
    assert shoelast.points["toe_feather_point"][1] > 0


def test_its_upper_bends_smoothly(shoelast: Shoelast):
    """Normals of neighbours on a fine grid turn by little; a crease or a wobble would show."""
    u, v = np.arange(720) / 720, np.linspace(0.01, 0.99, 400)
    along_u, along_v = shoelast.upper.grid(u, v, 1, 0), shoelast.upper.grid(u, v, 0, 1)
    normal = np.cross(along_u, along_v)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    turn = np.arccos(np.clip((normal[1:] * normal[:-1]).sum(-1), -1, 1))
    step = np.linalg.norm(np.diff(shoelast.upper.grid(u, v), axis=0), axis=-1)

    assert (turn / step).max() < 1 / 3.0


def test_scaled_by_one_percent_every_length_is(shoelast: Shoelast):
    before, after = dimensions(shoelast), dimensions(moved(shoelast, np.diag([1.01, 1.01, 1.01, 1.0])))

    for name, one in before.items():
        factor = 1.01**3 if one.unit == "cm3" else 1.01
        assert after[name].value == pytest.approx(one.value * factor, rel=2e-4), name


def test_a_left_one_is_the_same_in_memory():
    right, left = (build_shoelast("men", 42, "g", 12, "round", side) for side in ("right", "left"))

    assert left.side == "left"
    assert np.array_equal(right.upper.net_mm, left.upper.net_mm)
    assert left.name == right.name + "-left"


def test_a_stub_is_behind_the_heel_and_in_no_dimension():
    plain = build_shoelast("men", 42, "g", 12)
    with_stub = build_shoelast("men", 42, "g", 12, stub=True)

    assert [part.kind for part in with_stub.attachments] == ["stub"]
    assert -23 < with_stub.attachments[0].mesh.bounds[0, 0] < -16
    assert dimensions(with_stub) == dimensions(plain)


def test_the_family_has_a_thousand_lasts_with_different_names():
    names = [member.name for member in family_members()]

    assert len(set(names)) == len(names) >= 1000


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        (("child", 38, "g", 25, "round"), "men, women, therapeutic"),
        (("women", 60, "g", 25, "round"), "35 to 48"),
        (("women", 38, "z", 25, "round"), "f, g, h"),
        (("women", 38, "g", 90, "round"), "5 to 60"),
        (("women", 38, "g", 25, "square"), "round, almond, wide"),
    ],
)
def test_what_the_family_has_not_is_refused_in_words(asked: tuple, words: str):
    with pytest.raises(InputError, match=words):
        build_shoelast(*asked)


def feather_turn_deg(shoelast: Shoelast) -> np.ndarray:
    """Angle between the faces of upper and bottom along the feather edge."""
    skin = skin_of(shoelast, Sampling(360, 240, 80))
    mesh = skin.mesh()
    patch = skin.patch[mesh.face_adjacency]
    edge = (patch.min(axis=1) == UPPER) & (patch.max(axis=1) == BOTTOM)
    return np.degrees(mesh.face_adjacency_angles[edge])
