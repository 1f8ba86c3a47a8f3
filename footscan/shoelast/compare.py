"""A foot against a last: girths in the same planes, room by region, and the outline against the bottom pattern.

Only seen skin counts. Bridged and assumed skin has a line of its own and decides nothing.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import trimesh

from footscan.coordinates import Bools, Floats, Ints
from footscan.foot.crossing import find_silhouette
from footscan.foot.shell import Shell
from footscan.geometry.mesh_distance import DistanceMesh
from footscan.shoelast.dimensions import TapePlane, girth_mm, tape_planes
from footscan.shoelast.foot_pose import InsoleStack, PosedFoot, pose_foot
from footscan.shoelast.foot_pose_joints import Joints
from footscan.shoelast.foot_samples import sample_foot
from footscan.shoelast.model import Shoelast
from footscan.shoelast.prepared_foot import PreparedFoot, prepare_foot
from footscan.shoelast.profile import REGIONS, Profile, load_profile, region_of, room_mm
from footscan.shoelast.refusals import check_side
from footscan.shoelast.registration import Registration, register
from footscan.shoelast.skin import LastSkin, Sampling, skin_of
from footscan.shoelast.top_line import FeatherLine, TopLine, find_top_line

LOOSE_MM = 5.0
SAMPLES = 40_000
_SAMPLING = Sampling(288, 96, 32)
_REGISTERING_EVERY = 6
_STEP_MM = 1.0


@dataclass(frozen=True)
class RegionRoom:
    """Clearance of one region (mm, negative where the foot stands out), and what of it is tight and loose.

    `tight_share` has less room than the profile's least, `loose_share` more than `LOOSE_MM` beyond it.
    """

    samples: int
    min_mm: float
    mean_mm: float
    p5_mm: float
    p95_mm: float
    outside_share: float
    tight_share: float
    loose_share: float


@dataclass(frozen=True)
class Girth:
    """Tape girths (mm) of foot and last in one plane."""

    plane: TapePlane
    foot_mm: float
    last_mm: float


@dataclass(frozen=True)
class Outline:
    """Seen from above at every millimetre along the last: lateral and medial y of the foot's seen skin and of the
    bottom pattern; NaN where there is none."""

    x: Floats
    foot: Floats
    bottom: Floats
    last: Floats


@dataclass(frozen=True)
class Comparison:
    """A foot laid into a last.

    Attributes:
        posed: The foot as it lies; None when two lasts were compared.
        registration: How it came there.
        xyz: `(n, 3)` samples in the last's frame.
        clearance_mm: `(n,)` room there, negative outside.
        seen: `(n,)` which samples count: seen skin above the feather line and below the top line.
        regions: Region -> room, of seen skin only.
        plantar: Room of skin below the feather line that was seen; the sole itself never is.
        unseen: Room of skin that was bridged or assumed; it decides nothing.
        girths: Name -> girths in the same plane.
        outline: Of foot, bottom pattern and last in plan.
        top_line: Up to where skin counts.
        remarks: What a reader must know.
    """

    posed: PosedFoot | None
    registration: Registration | None
    xyz: Floats
    clearance_mm: Floats
    seen: Bools
    regions: Mapping[str, RegionRoom]
    plantar: RegionRoom | None
    unseen: RegionRoom | None
    girths: Mapping[str, Girth]
    outline: Outline
    top_line: TopLine | None
    remarks: tuple[str, ...]


def compare(
    shoelast: Shoelast,
    foot: PreparedFoot | trimesh.Trimesh,
    profile: Profile | str = "therapeutic",
    stack: InsoleStack | None = None,
    joints: Joints | None = None,
) -> Comparison:
    """Lay a foot into a last and measure the room.

    Args:
        shoelast: In its frame, with its points.
        foot: Prepared, or a mesh in mm standing on z = 0 (taken to be of the last's side).
        profile: Room wanted, or its name.
        stack: Insole; None for 3 mm everywhere.
        joints: What each joint of the foot may do.

    Raises:
        InputError: The wrong side, an unknown profile, or a mesh that is no foot.
        QualityError: The last's pitch is more than a scan can be bent to.
    """
    wanted = load_profile(profile) if isinstance(profile, str) else profile
    prepared = prepare_foot(foot, shoelast.side) if isinstance(foot, trimesh.Trimesh) else foot
    check_side(shoelast, prepared)
    posed = pose_foot(prepared, shoelast, stack, joints)
    samples = sample_foot(posed, SAMPLES, 0.45 * prepared.value("foot_length"))
    few = samples.of(np.arange(len(samples.xyz)) % _REGISTERING_EVERY == 0)
    posed, lie = register(posed, shoelast, few, wanted, hold_back=False)
    samples = samples.moved(posed.shell)
    skin = skin_of(shoelast, _SAMPLING)
    clearance = -DistanceMesh(skin.xyz_shoelast, skin.faces).nearest(samples.xyz).signed
    top_line, height = find_top_line(shoelast, posed), FeatherLine(shoelast).height_mm(samples.xyz)
    below, above = top_line.below(samples.xyz), height > 0.0
    seen = samples.seen & below & above
    least = room_mm(wanted, samples.place, samples.normal_foot)[0]
    return Comparison(
        posed=posed,
        registration=lie,
        xyz=samples.xyz,
        clearance_mm=clearance,
        seen=seen,
        regions=_regions(clearance, least, region_of(samples.place), seen),
        plantar=_room(clearance, least, samples.seen & below & ~above),
        unseen=_room(clearance, least, ~samples.seen & below),
        girths=_girths(posed.shell, skin, _foot_points(posed, shoelast)),
        outline=_outline(posed.shell, prepared.face_seen, top_line, shoelast, skin),
        top_line=top_line,
        remarks=posed.remarks,
    )


def compare_lasts(shoelast: Shoelast, other: Shoelast) -> Comparison:
    """Another last in the place of a foot, where it stands: zero everywhere when it is the same.

    All of its upper counts; least room 0.
    """
    skin, its = skin_of(shoelast, _SAMPLING), skin_of(other, _SAMPLING)
    xyz = its.xyz_shoelast
    clearance = -DistanceMesh(skin.xyz_shoelast, skin.faces).nearest(xyz).signed
    ball = 0.5 * (other.points["ball_medial"][0] + other.points["ball_lateral"][0])
    rear = float(other.points["rear_point"][0])
    upper = np.arange(len(xyz)) < len(its.uv)
    least = np.zeros(len(xyz))
    shell, every = Shell(xyz, its.faces), np.ones(len(its.faces), dtype=np.bool_)
    return Comparison(
        posed=None,
        registration=None,
        xyz=xyz,
        clearance_mm=clearance,
        seen=upper,
        regions=_regions(clearance, least, region_of((xyz[:, 0] - rear) / (ball - rear)), upper),
        plantar=_room(clearance, least, ~upper),
        unseen=None,
        girths=_girths(shell, skin, other.points),
        outline=_outline(shell, every, None, shoelast, skin),
        top_line=None,
        remarks=(),
    )


def _regions(clearance: Floats, least: Floats, region: Ints, seen: Bools) -> dict[str, RegionRoom]:
    rooms = {name: _room(clearance, least, seen & (region == number)) for number, name in enumerate(REGIONS)}
    return {name: room for name, room in rooms.items() if room is not None}


def _room(clearance: Floats, least: Floats, which: Bools) -> RegionRoom | None:
    if not which.any():
        return None
    here, wanted = clearance[which], least[which]
    low, high = np.percentile(here, [5.0, 95.0])
    return RegionRoom(
        samples=len(here),
        min_mm=float(here.min()),
        mean_mm=float(here.mean()),
        p5_mm=float(low),
        p95_mm=float(high),
        outside_share=float(np.mean(here < 0.0)),
        tight_share=float(np.mean(here < wanted)),
        loose_share=float(np.mean(here > wanted + LOOSE_MM)),
    )


def _foot_points(posed: PosedFoot, shoelast: Shoelast) -> dict[str, Floats]:
    """The foot's own points under the names that tapes go through; the cone's front is the last's."""
    return {
        "ball_medial": posed.points["metatarsale_tibiale"],
        "ball_lateral": posed.points["metatarsale_fibulare"],
        "instep_point": posed.points["instep_point"],
        "heel_point": posed.points["heel_corner"],
        "cone_front": shoelast.points["cone_front"],
    }


def _girths(foot: Shell, skin: LastSkin, points: Mapping[str, Floats]) -> dict[str, Girth]:
    last = Shell(skin.xyz_shoelast, np.ascontiguousarray(skin.faces))
    planes = tape_planes(points)
    return {name: Girth(plane, girth_mm(foot, plane), girth_mm(last, plane)) for name, plane in planes.items()}


def _outline(foot: Shell, seen: Bools, top_line: TopLine | None, shoelast: Shoelast, skin: LastSkin) -> Outline:
    first = np.floor(min(float(skin.xyz_shoelast[:, 0].min()), float(foot.xyz[:, 0].min())))
    end = max(float(skin.xyz_shoelast[:, 0].max()), float(foot.xyz[:, 0].max()))
    count = int(np.ceil((end - first) / _STEP_MM)) + 1
    x = first + _STEP_MM * np.arange(count)
    below = seen if top_line is None else seen & top_line.below(foot.xyz)[foot.faces].all(axis=1)
    edge = shoelast.upper.grid(np.linspace(0.0, 1.0, 721), np.array([0.0]))[0]
    ring = np.column_stack([np.arange(720), np.arange(1, 721), np.arange(1, 721)]).astype(np.int64)
    spans = [
        find_silhouette(np.ascontiguousarray(xyz[:, :2]), np.ascontiguousarray(faces), first, _STEP_MM, count)
        for xyz, faces in ((foot.xyz, foot.faces[below]), (edge, ring), (skin.xyz_shoelast, skin.faces))
    ]
    return Outline(x, *(np.where(np.isfinite(span), span, np.nan) for span in spans))
