"""`customise(shoelast, foot, clearance)`: the smoothest change of a last that holds a foot, with its proof."""

from concurrent.futures import ThreadPoolExecutor

import trimesh
from threadpoolctl import threadpool_limits

from footscan.shoelast.custom_last import CustomLast
from footscan.shoelast.custom_report import measure_standard
from footscan.shoelast.custom_settings import CustomSettings
from footscan.shoelast.displacement import DisplacementTask
from footscan.shoelast.fit_case import build_case, judge_foot, make_ready
from footscan.shoelast.foot_pose import pose_foot
from footscan.shoelast.foot_samples import sample_foot
from footscan.shoelast.girth_wish import check_girths
from footscan.shoelast.model import Shoelast
from footscan.shoelast.obstacle import Watch, unwatched
from footscan.shoelast.prepared_foot import PreparedFoot, prepare_foot
from footscan.shoelast.profile import Profile, load_profile, uniform_profile
from footscan.shoelast.refusals import check_side, check_size
from footscan.shoelast.registration import register

__all__ = ["CustomSettings", "customise"]
REGISTERING = 9000
MOST_OUTSIDE_MM, DRAWN_IN_MM = 0.01, 0.5
"""What moves further beyond the transition length, between the places at which the change was looked at, is found once
more with the change ending this much sooner: one foot in fifty."""


def customise(
    shoelast: Shoelast,
    foot: PreparedFoot | trimesh.Trimesh,
    clearance: Profile | str | float = "therapeutic",
    settings: CustomSettings | None = None,
    watch: Watch = unwatched,
) -> CustomLast:
    """Change a last as smoothly as possible so that it holds a foot.

    Args:
        shoelast: In its frame, with its points.
        foot: Prepared, or a mesh in mm standing on z = 0 (taken to be of the last's side).
        clearance: A profile, its name, or one clearance (mm) for everywhere.
        settings: Transition length, insole, joints, pins, girths; None for the defaults.
        watch: Called often; what it raises ends the work.

    Raises:
        InputError: The wrong side, an unknown profile, or a mesh that is no foot.
        QualityError: The last is about two sizes short or smaller than the foot everywhere (grade first), its pitch
            is more than a scan can be bent to, or no displacement meets all that is asked.
    """
    settings = settings or CustomSettings()
    profile = _profile(clearance)
    prepared = prepare_foot(foot, shoelast.side) if isinstance(foot, trimesh.Trimesh) else foot
    check_girths(settings.girths_mm)
    check_side(shoelast, prepared)
    with threadpool_limits(1), ThreadPoolExecutor(1) as beside:  # two BLAS threads would only wait for each other
        ready = beside.submit(make_ready, shoelast, settings.transition_mm)
        posed = pose_foot(prepared, shoelast, settings.stack, settings.joints)
        watch()
        posed, registration = register(posed, shoelast, sample_foot(posed, REGISTERING), profile)
        watch()
        check_size(shoelast, posed, registration)
        judged = judge_foot(shoelast, posed)
        watch()
        case = build_case(ready.result(), judged, profile, settings)
        watch()
        before = beside.submit(measure_standard, case.shoelast)
        found = DisplacementTask(case, watch=watch).solved(registration, before)
        if found.outside_mm <= MOST_OUTSIDE_MM:
            return found
        return DisplacementTask(case, DRAWN_IN_MM, watch).solved(registration, before)


def _profile(clearance: Profile | str | float) -> Profile:
    if isinstance(clearance, str):
        return load_profile(clearance)
    return clearance if isinstance(clearance, Profile) else uniform_profile(float(clearance))
