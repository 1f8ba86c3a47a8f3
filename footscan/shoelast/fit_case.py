"""One last and one foot that lies in it: what stays the same while a displacement is looked for."""

from dataclasses import dataclass, replace

import numpy as np

from footscan.coordinates import Floats
from footscan.foot.nurbs_fit import evaluate_at
from footscan.shoelast.change_region import ChangeRegion
from footscan.shoelast.chart import Chart, Sparse, bending_matrix, build_chart
from footscan.shoelast.custom_settings import CustomSettings
from footscan.shoelast.foot_pose import PosedFoot
from footscan.shoelast.foot_samples import FootSamples
from footscan.shoelast.judged_skin import judged_samples, wanted_room
from footscan.shoelast.model import Shoelast
from footscan.shoelast.need import CELLS, Need, Room
from footscan.shoelast.nets import Coarse, coarse_space
from footscan.shoelast.patches import lower_edge, with_boundary
from footscan.shoelast.profile import Profile
from footscan.shoelast.proof import Judged
from footscan.shoelast.top_line import TopLine, find_top_line

_SPAN_SHARE = 0.6
"""Spans of the displacement's own net are at most this share of the transition length."""


@dataclass(frozen=True)
class FitCase:
    """A last on a fine enough net, a foot that lies in it, and what is wanted.

    Attributes:
        shoelast: The standard last.
        posed: The foot as posed and registered.
        profile: Room wanted.
        settings: How to customise.
        chart: Of the last.
        region: Where its coefficients act.
        coarse: The net of the displacement.
        energy: Bending energy of a displacement.
        top_line: Up to where the foot has to be held.
        samples: Of the foot.
        judged: Which of them count.
        room: What is wanted of each.
    """

    shoelast: Shoelast
    posed: PosedFoot
    profile: Profile
    settings: CustomSettings
    chart: Chart
    region: ChangeRegion
    coarse: Coarse
    energy: Sparse
    top_line: TopLine
    samples: FootSamples
    judged: Judged
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


def build_case(shoelast: Shoelast, posed: PosedFoot, profile: Profile, settings: CustomSettings) -> FitCase:
    """Make a last and a foot ready.

    Raises:
        QualityError: Hardly any skin below the top line was seen.
    """
    chart = build_chart(shoelast)
    top_line = find_top_line(shoelast, posed)
    samples, judged = judged_samples(posed, shoelast, top_line)
    return FitCase(
        shoelast=shoelast,
        posed=posed,
        profile=profile,
        settings=settings,
        chart=chart,
        region=ChangeRegion(chart),
        coarse=coarse_space(chart.tube, _SPAN_SHARE * settings.transition_mm),
        energy=bending_matrix(chart.tube),
        top_line=top_line,
        samples=samples,
        judged=judged,
        room=wanted_room(samples, posed, profile, settings),
    )
