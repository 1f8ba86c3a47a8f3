"""One last and one foot that lies in it: what stays the same while a displacement is looked for."""

from dataclasses import dataclass, replace

import numpy as np

from footscan.coordinates import Floats
from footscan.foot.nurbs_fit import evaluate_at
from footscan.geometry.mesh_distance import DistanceMesh
from footscan.shoelast.change_region import ChangeRegion
from footscan.shoelast.chart import Chart, Sparse, bending_matrix, build_chart
from footscan.shoelast.custom_settings import CustomSettings
from footscan.shoelast.foot_pose import PosedFoot
from footscan.shoelast.foot_samples import FootSamples
from footscan.shoelast.judged_skin import judged_samples, run_out_places, wanted_room
from footscan.shoelast.model import Shoelast
from footscan.shoelast.need import CELLS, Need, Room
from footscan.shoelast.nets import Coarse, coarse_space, fine_enough
from footscan.shoelast.patches import lower_edge, with_boundary
from footscan.shoelast.profile import Profile
from footscan.shoelast.proof import Judged
from footscan.shoelast.skin import Breaks, LastSkin, Sampling, even_breaks, skin_of
from footscan.shoelast.top_line import TopLine, find_top_line

_SPAN_SHARE = 0.6
"""Spans of the displacement's own net are at most this share of the transition length."""
_FAIR_SHARE = 0.1
"""Bends shorter than this share of the transition length cost most: no new crease at its border."""
_FIRST_MESH = Sampling(300, 100, 32)


@dataclass(frozen=True)
class ReadyLast:
    """A last made ready for a transition length, whatever foot it is for.

    Attributes:
        shoelast: The standard last on a fine enough net.
        chart: Of the last.
        region: Where its coefficients act.
        coarse: The net of the displacement.
        stiffness: What is least of a displacement: the energy of its bends and of their changes.
        breaks: Where the standard last is laid out as a mesh.
        skin: That mesh.
        mesh: The same, for distances.
    """

    shoelast: Shoelast
    chart: Chart
    region: ChangeRegion
    coarse: Coarse
    stiffness: Sparse
    breaks: Breaks
    skin: LastSkin
    mesh: DistanceMesh


def make_ready(shoelast: Shoelast, transition_mm: float) -> ReadyLast:
    """Refine a last for a transition length, and lay it out as a chart and as a mesh."""
    fine = fine_enough(shoelast, transition_mm)
    chart, breaks = build_chart(fine), even_breaks(_FIRST_MESH)
    skin = skin_of(fine, breaks)
    return ReadyLast(
        shoelast=fine,
        chart=chart,
        region=ChangeRegion(chart),
        coarse=coarse_space(chart.tube, _SPAN_SHARE * transition_mm),
        stiffness=bending_matrix(chart.tube, _FAIR_SHARE * transition_mm),
        breaks=breaks,
        skin=skin,
        mesh=DistanceMesh(skin.xyz_shoelast, skin.faces),
    )


@dataclass(frozen=True)
class FitCase(ReadyLast):
    """A last made ready, a foot that lies in it, and what is wanted.

    Attributes:
        posed: The foot as posed and registered.
        profile: Room wanted.
        settings: How to customise.
        top_line: Up to where the foot has to be held.
        samples: Of the foot.
        judged: Which of them count.
        run_out: `(n, 3)` seen skin above the top line, beside which a change may run out.
        room: What is wanted of each.
    """

    posed: PosedFoot
    profile: Profile
    settings: CustomSettings
    top_line: TopLine
    samples: FootSamples
    judged: Judged
    run_out: Floats
    room: Room

    @property
    def transition_mm(self) -> float:
        """How far a change may reach."""
        return self.settings.transition_mm

    def on_upper(self, need: Need) -> Floats:
        """Places `(n, 3)` of the standard upper."""
        return evaluate_at(self.chart.tube, need.u, need.v).xyz_mm

    def cell_area_mm2(self, need: Need) -> Floats:
        """Area `(n,)` of the cell of each place."""
        here = evaluate_at(self.chart.tube, need.u, need.v)
        area = np.linalg.norm(np.cross(here.along_u, here.along_v), axis=1)
        return area / float(CELLS[0] * CELLS[1])

    def displaced(self, coefficients: Floats) -> Shoelast:
        """The last with a displacement `(n_v, n_u)`."""
        upper = self.chart.displaced(coefficients)
        return replace(self.shoelast, upper=upper, bottom=with_boundary(self.shoelast.bottom, lower_edge(upper)))


@dataclass(frozen=True)
class JudgedFoot:
    """What of a case does not need the last made ready: see `FitCase`."""

    posed: PosedFoot
    top_line: TopLine
    samples: FootSamples
    judged: Judged
    run_out: Floats


def judge_foot(shoelast: Shoelast, posed: PosedFoot) -> JudgedFoot:
    """Choose the skin of a posed and registered foot that a last is judged by.

    Raises:
        QualityError: Hardly any skin below the top line was seen.
    """
    top_line = find_top_line(shoelast, posed)
    samples, judged = judged_samples(posed, shoelast, top_line)
    return JudgedFoot(posed, top_line, samples, judged, run_out_places(posed, top_line))


def build_case(ready: ReadyLast, foot: JudgedFoot, profile: Profile, settings: CustomSettings) -> FitCase:
    """Put a last and a foot that lies in it together."""
    room = wanted_room(foot.samples, foot.posed, profile, settings)
    return FitCase(**vars(ready), **vars(foot), profile=profile, settings=settings, room=room)
