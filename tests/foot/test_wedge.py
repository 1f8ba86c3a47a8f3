"""A foot whose heel stands on a wedge is measured as if it stood flat, and a raised heel nobody declared is told."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from footscan.errors import MeshError
from footscan.foot.measurements import Measurements, measure
from footscan.foot.shell import Shell, mesh_from_shell, moved, shell_from_mesh
from footscan.foot.sole_bend import BentFoot
from footscan.foot.wedge import Wedge, height_of_slope, slope_of_height, wedge_bend, wedge_from_json, wedge_json
from footscan.sim.foot import FootShape, build_foot
from footscan.sim.surface import trimesh_from_surface

WITHIN_MM = {"foot_length": 0.5, "foot_breadth": 0.1, "ball_girth": 0.3, "heel_breadth": 0.1, "instep_girth": 1.0}


@pytest.fixture(scope="module")
def flat() -> Measurements:
    return measure(trimesh_from_surface(build_foot(FootShape("right", 1.0))), "right")


def on_wedge(flat: Measurements, height_mm: float, turn_rad: float = 0.7) -> trimesh.Trimesh:
    """The built-in foot bent on to a wedge about its own ball, by the forward bend, and turned on the board."""
    shell = moved(shell_from_mesh(trimesh_from_surface(build_foot(FootShape("right", 1.0)))), flat.foot_from_input)
    length = float(flat["foot_length"].value or 0.0)
    heads = [flat.frame.to_foot(flat.landmarks[f"metatarsale_{side}"].xyz[None])[0] for side in ("tibiale", "fibulare")]
    ball, neutral = float(np.mean([head[0] for head in heads])), 0.5 * float(flat["ball_height"].value or 0.0)
    slope = slope_of_height(height_mm, ball, length, neutral)
    bent = BentFoot(wedge_bend(slope, ball, length), ball + 0.08 * length, neutral, length, length)
    c, s = np.cos(turn_rad), np.sin(turn_rad)
    turned = bent(shell.xyz) @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]) + np.array([12.0, -30.0, 0.0])
    return mesh_from_shell(Shell(turned, shell.faces))


@pytest.fixture(scope="module")
def raised(flat: Measurements) -> trimesh.Trimesh:
    return on_wedge(flat, 50.0)


@pytest.fixture(scope="module")
def found(raised: trimesh.Trimesh) -> Measurements:
    return measure(raised, "right", wedge=50.0)


@settings(max_examples=20, deadline=None)
@given(st.floats(5.0, 70.0), st.floats(-3.0, 3.0), st.floats(210.0, 300.0))
def test_turning_back_is_the_inverse_of_bending(height_mm: float, heading_rad: float, length_mm: float):
    joint, neutral = 0.68 * length_mm, 0.07 * length_mm
    slope = slope_of_height(height_mm, joint, length_mm, neutral)
    forward = (float(np.cos(heading_rad)), float(np.sin(heading_rad)))
    wedge = Wedge(height_mm, slope, (5.0, -7.0), forward, joint, length_mm, neutral)
    share = np.stack(np.meshgrid([0.02, 0.2, 0.4, 0.6, 0.7, 0.95], [-0.1, 0.1], [0.0, 0.05, 0.15]), -1).reshape(-1, 3)
    xyz_flat = wedge._to_input(share * length_mm)  # pyright: ignore[reportPrivateUsage]

    assert wedge.flat(wedge.bent(xyz_flat)) == pytest.approx(xyz_flat, abs=1e-4)
    assert height_of_slope(wedge) == pytest.approx(height_mm, abs=1e-6)
    assert wedge_from_json(wedge_json(wedge)) == wedge


def test_the_top_of_the_ramp_becomes_the_board():
    length, joint, neutral = 270.0, 184.0, 21.0
    slope = slope_of_height(50.0, joint, length, neutral)
    wedge = Wedge(50.0, slope, (0.0, 0.0), (1.0, 0.0), joint, length, neutral)
    along = np.linspace(20.0, 150.0, 14)
    ramp = np.column_stack([wedge.edge_mm - along * np.cos(slope), np.zeros(14), along * np.sin(slope)])
    board = np.column_stack([np.linspace(215.0, 260.0, 5), np.zeros(5), np.zeros(5)])

    assert wedge.flat(ramp)[1:, 2] == pytest.approx(np.zeros(13), abs=0.01)
    assert wedge.flat(board) == pytest.approx(board, abs=1e-6)


def test_a_foot_on_a_wedge_measures_like_the_flat_foot(flat: Measurements, found: Measurements):
    for name, within_mm in WITHIN_MM.items():
        assert found[name].value == pytest.approx(flat[name].value, abs=within_mm), name
    assert any("on a wedge of 50 mm" in remark for remark in found.remarks)
    assert found["foot_length"].reliable
    assert "ankle was bent" in found["ankle_girth"].reason


def test_landmarks_and_tapes_lie_on_the_foot_as_it_stood(raised: trimesh.Trimesh, found: Measurements):
    tape = found["instep_girth"].tape
    assert tape is not None

    for name in ("pternion", "metatarsale_tibiale", "instep_point", "foremost_point"):
        gap = np.linalg.norm(np.asarray(raised.vertices) - found.landmarks[name].xyz, axis=1).min()
        assert gap < 1.5, name
    assert abs((found.landmarks["instep_point"].xyz - tape.origin) @ tape.normal) < 0.5
    assert found.wedge is not None
    assert np.arcsin(abs(tape.normal[2])) == pytest.approx(found.wedge.slope_rad, abs=0.02)


def test_landmarks_by_hand_are_carried_both_ways(raised: trimesh.Trimesh, found: Measurements):
    marks = {name: found.landmarks[name].xyz for name in ("pternion", "metatarsale_tibiale", "instep_point")}
    again = measure(raised, "right", wedge=found.wedge, landmarks=marks)

    for name, xyz in marks.items():
        assert again.landmarks[name].xyz == pytest.approx(xyz, abs=1e-5), name
        assert again.landmarks[name].source == "manual"


def test_a_raised_heel_that_nobody_declared_is_refused(raised: trimesh.Trimesh):
    with pytest.raises(MeshError, match=r"mm higher than the ball.*--wedge"):
        measure(raised, "right")


def test_a_slightly_raised_heel_makes_nothing_reliable(flat: Measurements):
    mesh = on_wedge(flat, 12.0)
    found = measure(mesh, "right")

    assert not any(value.reliable for value in found.measurements.values())
    assert "no wedge was declared" in found["foot_length"].reason


def test_a_wedge_up_to_two_millimetres_is_the_flat_board(flat: Measurements):
    mesh = trimesh_from_surface(build_foot(FootShape("right", 1.0)))

    assert measure(mesh, "right", wedge=1.5)["foot_length"].value == flat["foot_length"].value


def test_a_flat_foot_for_which_a_wedge_was_declared_is_refused():
    mesh = trimesh_from_surface(build_foot(FootShape("right", 1.0)))

    for height_mm in (15.0, 50.0):
        with pytest.raises(MeshError, match=f"a wedge of {height_mm:g} mm was declared, but"):
            measure(mesh, "right", wedge=height_mm)


def test_impossible_wedges_are_refused(flat: Measurements):
    mesh = trimesh_from_surface(build_foot(FootShape("right", 1.0)))

    with pytest.raises(MeshError, match="allowed are 0"):
        measure(mesh, "right", wedge=500.0)
