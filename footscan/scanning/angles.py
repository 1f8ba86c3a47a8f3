"""The head angle of every frame, from the encoder's own samples at the frame's time minus the latency."""

from dataclasses import dataclass

import numpy as np

from footscan.coordinates import Bools, Floats
from footscan.errors import RecordingError
from footscan.optics.calibration import EncoderScale, theta_from_encoder
from footscan.scanning.recording import EncoderTrack

FARTHEST_SAMPLE_S = 0.050
_FASTEST_REV_PER_S = 2.0
_TIMES_USUAL = 8.0  # a head does not turn this many times faster than it usually does
_SLACK_STEPS = 8.0
_FEWEST_RATES = 100
_STILL_STEPS = 2


@dataclass(frozen=True)
class FrameAngles:
    """`(n,)` head angles (rad) and whether each is known; an unknown one is NaN."""

    theta_rad: Floats
    known: Bools


def frame_angles(time_s: Floats, latency_s: float, track: EncoderTrack, encoder: EncoderScale) -> FrameAngles:
    """Interpolate the count at `(n,)` frame times minus the latency.

    A frame further than 50 ms from a sample on either side is unknown, except at a standstill: the same count on both
    sides of it. Gaps without frames do not matter.

    Raises:
        RecordingError: The count jumps faster than a head can turn.
    """
    _refuse_jumps(track, encoder)
    exposed_s = time_s - latency_s
    after = np.searchsorted(track.time_s, exposed_s, side="left")
    inside = (after > 0) & (after < len(track.time_s))
    low, high = np.clip(after - 1, 0, None), np.clip(after, None, len(track.time_s) - 1)
    exact = (after < len(track.time_s)) & (track.time_s[high] == exposed_s)
    near = (exposed_s - track.time_s[low] <= FARTHEST_SAMPLE_S) & (track.time_s[high] - exposed_s <= FARTHEST_SAMPLE_S)
    still = track.count[low] == track.count[high]
    known = exact | (inside & (near | still))
    theta_rad = theta_from_encoder(np.interp(exposed_s, track.time_s, track.count), encoder)
    return FrameAngles(np.where(known, theta_rad, np.nan), known)


def _refuse_jumps(track: EncoderTrack, encoder: EncoderScale) -> None:
    step, pause_s = np.abs(np.diff(track.count)), np.diff(track.time_s)
    rate = step[step > 0] / np.maximum(pause_s[step > 0], 0.001)
    usual = float(np.median(rate)) if len(rate) > _FEWEST_RATES else np.inf
    fastest = min(_FASTEST_REV_PER_S * encoder.steps_per_rev, _TIMES_USUAL * usual)
    limit = np.maximum(pause_s, 0.001) * fastest + _SLACK_STEPS
    jumps = np.flatnonzero((step > limit) & (pause_s <= FARTHEST_SAMPLE_S))
    if len(jumps):
        at = int(jumps[0])
        before, after = int(track.count[at]), int(track.count[at + 1])
        raise RecordingError(
            f"encoder.csv line {at + 3}: the count jumps from {before} to {after} within {1e3 * pause_s[at]:.1f} ms, "
            "faster than the head can turn. Check the encoder's cable and scan again."
        )


def refuse_silent_encoder(time_s: Floats, track: EncoderTrack, latency_s: float) -> None:
    """Refuse a moving sweep, `(n,)` frame times, during which the count stands still.

    Raises:
        RecordingError: The encoder was silent.
    """
    count = np.interp(time_s - latency_s, track.time_s, track.count)
    if len(count) > 1 and np.ptp(count) < _STILL_STEPS:
        raise RecordingError(
            f"the encoder is silent: its count stays at {count[0]:.0f} over {len(count)} frames of a moving sweep. "
            "Check its cable and supply and scan again."
        )
