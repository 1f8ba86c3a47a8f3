"""Which skin a customised last is judged by, and what room is wanted there."""

import numpy as np

from footscan.coordinates import Floats
from footscan.errors import QualityError
from footscan.shoelast.custom_settings import CustomSettings
from footscan.shoelast.foot_pose import PosedFoot
from footscan.shoelast.foot_samples import FootSamples, sample_foot
from footscan.shoelast.model import Shoelast
from footscan.shoelast.need import Room
from footscan.shoelast.pins import pinned_mm
from footscan.shoelast.profile import Profile, most_loss_mm, room_mm
from footscan.shoelast.proof import Judged, judge
from footscan.shoelast.top_line import FeatherLine, TopLine

SEEN_SAMPLES = 106_000
RUN_OUT_MM = 20.0
"""So far above the top line seen skin that stands out of a last lets a change run out; it sets no condition."""
_RUN_OUT_SAMPLES = 8000
_LEAST_SHARE, _UNSEEN_SHARE = 0.05, 0.2


def seen_share(judged: Judged) -> float:
    """Share of the skin between feather line and top line that was seen, from samples of `judged_samples`."""
    seen, unseen = float(judged.seen.sum()), float(judged.unseen.sum())
    return seen / (seen + unseen / _UNSEEN_SHARE)


def wanted_room(samples: FootSamples, posed: PosedFoot, profile: Profile, settings: CustomSettings) -> Room:
    """What is wanted of every sample; pins add to it."""
    least, most = room_mm(profile, samples.place, samples.normal_foot)
    extra = pinned_mm(settings.pins, posed, samples)
    return Room(least + extra, np.maximum(most, least) + extra, most_loss_mm(profile, samples.place))


def judged_samples(posed: PosedFoot, shoelast: Shoelast, top_line: TopLine) -> tuple[FootSamples, Judged]:
    """Samples of which at least the proof's number are judged.

    Raises:
        QualityError: Hardly any skin below the top line was seen.
    """
    feather = FeatherLine(shoelast)
    low = np.asarray(top_line.below(posed.shell.xyz)[posed.shell.faces].any(axis=1), dtype=np.bool_)
    rough = sample_foot(posed, 8000, unseen_share=_UNSEEN_SHARE, faces=low)
    judged = judge(rough, feather.has_below(rough.xyz), top_line)
    share = seen_share(judged)
    if share < _LEAST_SHARE:
        raise QualityError(
            f"only {share:.0%} of the skin below the top line was seen; at least {_LEAST_SHARE:.0%} are needed to "
            "prove that the last holds the foot. Scan again with more of the foot in view."
        )
    samples = sample_foot(posed, int(SEEN_SAMPLES / float(judged.seen.mean())), unseen_share=_UNSEEN_SHARE, faces=low)
    return samples, judge(samples, feather.has_below(samples.xyz), top_line)


def run_out_places(posed: PosedFoot, top_line: TopLine) -> Floats:
    """Places `(n, 3)` of seen skin above the top line, beside which a change may run out."""
    height = top_line.height_mm(posed.shell.xyz)[posed.shell.faces]
    near = np.asarray((height.min(axis=1) > 0.0) & (height.max(axis=1) < RUN_OUT_MM), dtype=np.bool_)
    if not (near & posed.foot.face_seen).any():
        return np.zeros((0, 3))
    samples = sample_foot(posed, _RUN_OUT_SAMPLES, unseen_share=0.0, faces=near)
    return samples.xyz[samples.seen]
