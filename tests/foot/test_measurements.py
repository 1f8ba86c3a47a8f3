import json
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from footscan.errors import MeshError
from footscan.foot.align import align_foot
from footscan.foot.catalogue import CATALOGUE
from footscan.foot.clip import cut_below
from footscan.foot.landmarks import find_landmarks
from footscan.foot.measurements import definitions, measure, measurements_json
from footscan.foot.readings import height_of
from footscan.foot.shell import mesh_from_shell, shell_from_mesh
from footscan.foot.sizes import suggest_sizes, unusual_remark
from footscan.foot.standing import stand

GIRTHS = ("ball_girth", "waist_girth", "instep_girth", "long_heel_girth", "short_heel_girth", "ankle_girth")
POWER = {"mm": 1, "deg": 0, "1": 0, "cm2": 2, "cm3": 3}


def values(result):
    return {name: value.value for name, value in result.measurements.items() if value.value is not None}


def worst(result, expected, scale=1.0):
    """Largest difference over all measurements, after scaling the expected ones by their dimension."""
    ours, theirs = values(result), values(expected)
    assert ours.keys() == theirs.keys()
    units = {name: expected[name].unit for name in ours}
    return max(abs(ours[name] - theirs[name] * scale ** POWER[units[name]]) for name in ours)


def turned(mesh, degrees, shift=(0.0, 0.0)):
    moved = mesh.copy().apply_transform(trimesh.transformations.rotation_matrix(np.radians(degrees), [0, 0, 1]))
    return moved.apply_translation([*shift, 0.0])


@pytest.fixture(scope="module")
def measured(foot):
    return measure(foot, "right")


@pytest.mark.parametrize("degrees", [11.0, 74.0, 90.0, 163.0, 180.0, 244.5, 301.0, 359.0])
def test_turning_and_shifting_changes_no_measurement(foot, measured, degrees):
    result = measure(turned(foot, degrees, (310.0, -95.0)), "right")

    assert worst(result, measured) < 0.01
    assert result.shape_side == "right"


@pytest.mark.parametrize("axis", ["A1", "A4", "A5"])
def test_every_foot_axis_is_found_whatever_the_heading(foot, axis):
    straight, slanted = measure(foot, "right", axis=axis), measure(turned(foot, 197.0), "right", axis=axis)

    assert straight.axis == axis
    assert worst(slanted, straight) < 0.01


def test_a_mirrored_foot_with_the_other_side_measures_the_same(foot, measured):
    mirrored = trimesh.Trimesh(foot.vertices * [-1.0, 1.0, 1.0], foot.faces[:, ::-1], process=False)

    result = measure(mirrored, "left")

    assert worst(result, measured) < 1e-6
    assert result.shape_side == "left"
    assert result.questions == ()


@pytest.mark.parametrize("scale", [0.45, 0.7, 1.2])
def test_feet_of_every_size_give_scaled_values(foot, measured, scale):
    result = measure(foot.copy().apply_scale(scale), "right")

    assert worst(result, measured, scale) < 0.01
    assert {n: v.reliable for n, v in result.measurements.items()} == {
        n: v.reliable for n, v in measured.measurements.items()
    }


def test_a_foot_cut_at_100_mm_and_one_with_a_leg_agree_where_both_exist(foot, measured):
    short = measure(mesh_from_shell(cut_below(shell_from_mesh(foot), 100.0)), "right")

    names = values(short).keys() - {"ankle_girth", "malleolus_medialis_height", "malleolus_lateralis_height"}
    assert {n: short[n].value for n in names} == pytest.approx({n: measured[n].value for n in names}, abs=0.02)
    assert not short["ankle_girth"].reliable
    assert "cut off" in short["ankle_girth"].reason
    assert measured["ankle_girth"].reliable


def test_what_lies_just_below_a_cut_is_cut_off(foot, measured):
    top = measured["instep_height"].value + 2.0

    low = measure(mesh_from_shell(cut_below(shell_from_mesh(foot), top)), "right")

    for name in ("instep_height", "instep_girth"):
        assert not low[name].reliable
        assert "cut off" in low[name].reason
    assert low["foot_length"].reliable


def test_half_the_points_keep_the_lengths(make_foot):
    fine, coarse = measure(make_foot(around=340, up=198), "right"), measure(make_foot(around=240, up=140), "right")

    for name in ("foot_length", "ball_length", "outside_ball_length", "foot_breadth", "heel_breadth"):
        assert coarse[name].value == pytest.approx(fine[name].value, abs=0.1)


def test_the_foot_of_formulas_has_its_own_numbers(foot, measured):
    assert measured["foot_length"].value == pytest.approx(np.ptp(foot.vertices[:, 0]), abs=1.5)
    assert measured["volume"].value == pytest.approx(
        trimesh.Trimesh(*_below(foot, 0.35 * measured["foot_length"].value)).volume / 1000.0, rel=1e-3
    )
    assert 0.9 < measured["foot_breadth"].value / measured["overall_breadth"].value <= 1.0
    assert measured["malleolus_medialis_height"].value > measured["malleolus_lateralis_height"].value
    assert measured["short_heel_girth"].value > measured["long_heel_girth"].value > measured["instep_girth"].value


def _below(mesh, height_mm):
    shell = cut_below(shell_from_mesh(mesh), height_mm)
    return shell.xyz, shell.faces


def test_a_height_on_a_flat_bulge_is_not_reliable_and_says_how_well_it_is_known(foot):
    shell = shell_from_mesh(foot)
    standing = stand(shell, align_foot(shell, "right"), {}, ())
    marks, _ = find_landmarks(standing)
    clear = marks["malleolus_medialis"]
    flat = {"malleolus_medialis": replace(clear, height_within_mm=0.5)}
    measure_height = height_of("malleolus_medialis")

    assert 0.0 < clear.height_within_mm < 0.1
    assert measure_height(standing, marks).doubts == ()
    assert measure_height(standing, flat).doubts == ("the bulge is flat: its top is known to 0.5 mm only",)
    assert measure_height(standing, flat).value == clear.xyz_foot[2]


def test_the_metatarsal_heads_are_found_where_the_foot_of_formulas_has_them(measured):
    length = measured["foot_length"].value

    assert measured["ball_length"].value / length == pytest.approx(0.73, abs=0.03)
    assert measured["outside_ball_length"].value / length == pytest.approx(0.61, abs=0.03)


def test_a_taller_mesh_is_cut_first_and_the_height_is_stated(measured):
    height = round(0.52 * measured["overall_length"].value)

    assert any(f"the leg was cut off at {height} mm" in remark for remark in measured.remarks)


def test_the_smallest_ankle_girth_is_that_of_the_thinnest_level(foot, measured):
    levels = [foot.section(plane_origin=[0, 0, z], plane_normal=[0, 0, 1]).length for z in np.arange(85.0, 130.0, 0.5)]

    assert measured["ankle_girth"].value == pytest.approx(min(levels), abs=0.3)


@pytest.mark.parametrize("name", GIRTHS)
def test_every_girth_lies_inside_its_interval(measured, name):
    low, high = measured[name].interval

    assert low < measured[name].value < high
    assert "origin of the skin is unknown" in measured[name].reason


def test_what_rests_on_the_sole_has_an_interval(measured):
    with_interval = {name for name, value in measured.measurements.items() if value.interval is not None}

    assert with_interval == {*GIRTHS, "volume", "surface_area"}


def test_unseen_skin_above_the_edge_makes_a_girth_doubtful(foot):
    marked = foot.copy()
    origin = np.zeros(len(foot.vertices), dtype=np.uint8)
    origin[
        (foot.vertices[:, 2] > 10.0) & (foot.vertices[:, 1] > 0.0) & (np.abs(foot.vertices[:, 0] - 130.0) < 25.0)
    ] = 1
    marked.vertex_attributes["origin"] = origin

    result = measure(marked, "right")

    assert result.origin_known
    assert not result["instep_girth"].reliable
    assert "not seen" in result["instep_girth"].reason
    assert result["instep_girth"].interval[0] < result["instep_girth"].value - 1.0
    assert result["heel_breadth"].reliable


@pytest.mark.parametrize(
    ("axis", "sign", "names"),
    [
        (0, 1.0, {"overall_length", "foot_length"}),
        (0, -1.0, {"overall_length", "foot_length"}),
        (1, 1.0, {"overall_breadth", "foot_breadth"}),
        (1, -1.0, {"overall_breadth", "foot_breadth"}),
    ],
)
def test_a_length_that_ends_on_unseen_skin_is_not_reliable(foot, axis, sign, names):
    marked = foot.copy()
    reach = sign * foot.vertices[:, axis]
    low = foot.vertices[:, 2] < 42.0
    marked.vertex_attributes["origin"] = np.where(low & (reach > reach[low].max() - 12.0), 1, 0).astype(np.uint8)

    result = measure(marked, "right")

    ends = {"overall_length", "foot_length", "overall_breadth", "foot_breadth"}
    assert {name for name in ends if not result[name].reliable} == names
    assert all(result[name].reason.startswith("not seen") for name in names)


def test_a_length_that_ends_at_a_closed_hole_is_not_reliable(foot):
    holed = trimesh.Trimesh(foot.vertices, foot.faces[foot.triangles_center[:, 0] < 248.0], process=False)

    result = measure(holed, "right")

    assert not result["overall_length"].reliable and "not seen" in result["overall_length"].reason
    assert not result["foot_length"].reliable
    assert result["overall_breadth"].reliable


def test_skin_seen_everywhere_leaves_a_narrow_interval_at_the_ankle_and_a_wide_one_at_the_ball(foot):
    marked = foot.copy()
    marked.vertex_attributes["origin"] = np.where(foot.vertices[:, 2] < 5.0, 2, 0).astype(np.uint8)

    result = measure(marked, "right")

    ankle, ball = (np.diff(result[name].interval)[0] for name in ("ankle_girth", "ball_girth"))
    assert ankle == pytest.approx(2.0, abs=1e-6)
    assert ball > 6.0


def test_what_bone_decides_needs_palpation_until_a_hand_says_where(foot, measured):
    marks = {name: measured.landmarks[name].xyz for name in ("metatarsale_tibiale", "metatarsale_fibulare")}

    by_hand = measure(foot, "right", landmarks=marks)

    assert not measured["ball_length"].reliable
    assert "needs palpation" in measured["ball_length"].reason
    assert by_hand["ball_length"].reliable
    assert by_hand["ball_girth"].reliable
    assert by_hand.landmarks["metatarsale_tibiale"].source == "manual"
    assert by_hand["ball_length"].value == pytest.approx(measured["ball_length"].value, abs=0.01)


def test_a_landmark_by_hand_wins_and_keeps_its_place(foot, measured):
    moved = measured.landmarks["metatarsale_tibiale"].xyz + np.array([-6.0, 0.0, 0.0])

    result = measure(foot, "right", landmarks={"metatarsale_tibiale": moved})

    assert result.landmarks["metatarsale_tibiale"].xyz == pytest.approx(moved)
    assert result["ball_length"].value == pytest.approx(measured["ball_length"].value - 6.0, abs=0.5)


def test_the_navicular_is_measured_only_where_a_hand_put_it(foot, measured):
    result = measure(foot, "right", landmarks={"navicular": np.array([115.0, 30.0, 41.5])})

    assert measured["navicular_height"].value is None
    assert "needs palpation" in measured["navicular_height"].reason
    assert result["navicular_height"].value == pytest.approx(41.5)
    assert result["navicular_height"].reliable


def test_landmarks_are_in_the_inputs_own_coordinates(foot, measured):
    result = measure(turned(foot, 125.0, (40.0, 60.0)), "right")

    there = {name: mark.xyz for name, mark in measured.landmarks.items()}
    matrix = trimesh.transformations.rotation_matrix(np.radians(125.0), [0, 0, 1])
    for name, mark in result.landmarks.items():
        expected = matrix[:3, :3] @ there[name] + [40.0, 60.0, 0.0]
        assert mark.xyz == pytest.approx(expected, abs=0.01)


def test_the_operators_side_wins_and_a_contradiction_is_a_question(foot, measured):
    result = measure(foot, "left")

    assert result.side == "left"
    assert result.shape_side == "right"
    assert len(result.questions) == 1 and "left" in result.questions[0]
    assert measured.questions == ()


def test_without_a_side_the_shape_decides_and_asks(foot, measured):
    result = measure(foot)

    assert result.side == "right"
    assert len(result.questions) == 1
    assert worst(result, measured) == 0.0


def test_a_declared_absence_makes_dependent_values_not_applicable(foot, measured):
    result = measure(foot, "right", absent=("ray_1",))

    for name in ("ball_length", "ball_girth", "toe_1_angle", "toe_height"):
        assert result[name].value is None
        assert result[name].reason.startswith("not applicable")
    assert result["heel_breadth"].value == pytest.approx(measured["heel_breadth"].value)


def test_a_stump_is_measured_as_it_is(foot, measured):
    upended = trimesh.Trimesh(foot.vertices[:, [1, 2, 0]], foot.faces, process=False)
    xyz, faces = _below(upended, 165.0)
    stump = trimesh.Trimesh(xyz[:, [2, 0, 1]], faces, process=False)

    result = measure(stump, "right")

    assert any("stump: is it one?" in question for question in result.questions)
    assert result["foot_length"].value == pytest.approx(165.0, abs=3.0)
    assert result["ball_girth"].value is None
    assert "not applicable" in result["ball_girth"].reason
    assert result["ankle_girth"].value == pytest.approx(measured["ankle_girth"].value, abs=0.5)
    assert result["heel_breadth"].value == pytest.approx(measured["heel_breadth"].value, abs=3.0)


def test_a_foot_that_does_not_stand_flat_is_not_pushed_down(foot, measured):
    lifted = measure(foot.copy().apply_translation([0.0, 0.0, 6.0]), "right")

    assert lifted["toe_height"].value == pytest.approx(measured["toe_height"].value + 6.0, abs=0.3)


def test_load_is_unknown_unless_somebody_says_so(foot, measured):
    assert measured.load == "unknown"
    assert measure(foot, "right", load="bipedal").load == "bipedal"


def test_unusual_is_a_remark_and_changes_nothing_else(foot):
    broad = foot.copy().apply_scale([1.0, 1.3, 1.0])

    adult, off = measure(broad, "right"), measure(broad, "right", norm="none")

    assert "SD above" in adult["foot_breadth"].unusual
    assert off["foot_breadth"].unusual is None
    assert adult["foot_breadth"].value == off["foot_breadth"].value
    assert adult["foot_breadth"].reliable == off["foot_breadth"].reliable


def test_norms_are_silent_for_children_and_for_what_has_none():
    assert unusual_remark("ball_girth", 300.0, 160.0, "adult") is None
    assert unusual_remark("toe_height", 300.0, 270.0, "adult") is None
    assert unusual_remark("ball_girth", 252.0, 271.0, "men") is None
    assert "below" in unusual_remark("ball_girth", 205.0, 271.0, "men")


def test_sizes_follow_the_trades_formulas():
    sizes = suggest_sizes(271.2)

    assert sizes["mondopoint"] == 270.0
    assert sizes["eu"] == 42.5  # 1.5 * 27.12 + 2 = 42.7
    assert sizes["uk"] == 9.0  # 3 * 10.677 - 23 = 9.03
    assert sizes["us_men"] == 10.0
    assert "indicative" in sizes["note"]


def test_what_cannot_be_measured_here_is_listed_with_the_reason(measured):
    assert {"footprint_area", "contact_area", "arch_vault", "heel_seat_contour", "toe_cleft_depth"} == set(
        measured.not_measurable
    )
    assert all(len(reason) > 20 for reason in measured.not_measurable.values())


def test_the_json_form_is_complete_and_plain(measured):
    document = json.loads(json.dumps(measurements_json(measured), allow_nan=False))

    assert document["format"] == "footscan-measurements/1"
    assert (document["side"], document["axis"], document["load"]) == ("right", "A2", "unknown")
    assert set(document["measurements"]) == {entry.name for entry in CATALOGUE}
    assert set(document["measurements"]["ball_girth"]) == {"value", "unit", "reliable", "reason", "interval", "unusual"}
    assert document["measurements"]["ball_girth"]["interval"] == list(measured["ball_girth"].interval)
    assert {"pternion", "metatarsale_tibiale", "instep_point", "junction_point"} <= set(document["landmarks"])
    assert document["landmarks"]["pternion"]["source"] == "auto"
    assert len(document["landmarks"]["pternion"]["xyz"]) == 3


def test_every_value_is_reliable_or_says_why_not(measured):
    for value in measured.measurements.values():
        assert value.reliable or value.reason
        assert value.value is not None or not value.reliable


def test_everything_measured_is_defined_once(measured):
    assert set(measured.measurements) <= set(definitions())
    assert len({entry.name for entry in CATALOGUE}) == len(CATALOGUE)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"axis": "A6"}, "A1, A2, A4, A5"),
        ({"side": "both"}, "left and right"),
        ({"norm": "dogs"}, "adult, men, women, none"),
        ({"landmarks": {"elbow": np.zeros(3)}}, "elbow"),
        ({"landmarks": {"pternion": np.array([0.0, np.nan, 1.0])}}, "3 finite numbers"),
    ],
)
def test_arguments_that_are_not_allowed_are_refused_with_what_is(foot, arguments, words):
    with pytest.raises(MeshError, match=words):
        measure(foot, **({"side": "right"} | arguments))


@pytest.mark.parametrize("side", ["left", "right"])
def test_the_shared_feet_are_measured_without_help(shared_feet, side):
    mesh = trimesh.load(shared_feet / "feet" / f"{side}_foot.stl").apply_scale(1000.0)

    result = measure(mesh, side)

    assert result.shape_side == side
    assert result.questions == ()
    plausible = {
        "foot_length": (271.2, 13.1),
        "ball_length": (200.9, 10.5),
        "foot_breadth": (101.9, 5.2),
        "ball_girth": (252.0, 12.9),
        "heel_breadth": (72.5, 5.5),
        "long_heel_girth": (343.5, 16.6),
        "ankle_girth": (229.3, 14.6),
        "malleolus_lateralis_height": (72.9, 5.7),
        "instep_height": (68.0, 5.0),
    }
    for name, (mean, sd) in plausible.items():
        assert abs(result[name].value - mean) < 3.0 * sd, name


@pytest.mark.parametrize(("name", "side"), [("foot-left-ideal", "left"), ("foot-right-workshop", "right")])
def test_a_shared_foot_measures_the_same_with_its_leg(shared_feet, name, side):
    with_leg = measure(trimesh.load(shared_feet / "recordings" / name / "truth.stl"), side)
    cut = measure(trimesh.load(shared_feet / "feet" / f"{side}_foot.stl").apply_scale(1000.0), side)

    assert any("cut off at 142 mm" in remark for remark in with_leg.remarks)
    for key in ("foot_length", "ball_length", "foot_breadth", "heel_breadth", "instep_girth", "toe_1_angle"):
        assert with_leg[key].value == pytest.approx(cut[key].value, abs=0.05)
