"""How the head turns during a scan, and what the encoder says about it."""

from dataclasses import dataclass

import numpy as np

from footscan.coordinates import Floats, Ints
from footscan.errors import InputError
from footscan.optics import EncoderScale
from footscan.optics.scanner import Sweep

_GRID_S = 0.001


@dataclass(frozen=True)
class SweepPlan:
    """The plan of a scan: each sweep turns once around the foot while frames are taken at equal times.

    Attributes:
        frames_per_sweep: Pictures of one turn.
        frames_per_s: Of the camera.
        ramp_s: Time to reach speed, and to stop; no frames meanwhile.
        pause_s: At rest between the sweeps.
        ripple: Speed ripple relative to the speed (standard deviation).
        encoder_hz: Samples of the encoder per second.
        unlit_every: Every n-th frame is taken without a laser; 0 is none.
        alternating: One sweep, with the lasers in turn (right, left, right, ...), instead of a sweep for either.
    """

    frames_per_sweep: int = 240
    frames_per_s: float = 20.0
    ramp_s: float = 0.4
    pause_s: float = 0.6
    ripple: float = 0.01
    encoder_hz: float = 250.0
    unlit_every: int = 0
    alternating: bool = False


@dataclass(frozen=True)
class HeadMotion:
    """Head angle over time, known every millisecond, and the moments of exposure of each sweep.

    Attributes:
        time_s: `(n,)`.
        theta_rad: `(n,)`.
        exposure_s: Per sweep, `(frames,)` moments of exposure.
    """

    time_s: Floats
    theta_rad: Floats
    exposure_s: tuple[Floats, ...]

    def theta_at(self, time_s: Floats) -> Floats:
        """Head angles at some moments; the head rests before and after."""
        return np.interp(time_s, self.time_s, self.theta_rad)


def plan_motion(sweeps: tuple[Sweep, ...], plan: SweepPlan, seed: int) -> HeadMotion:
    """The head's way through some sweeps, one after the other; time 0 is the start of the first frame's interval.

    Raises:
        InputError: A plan that no machine can run.
    """
    _check(plan)
    random = np.random.default_rng([seed, 0x407104])
    turn_s = plan.frames_per_sweep / plan.frames_per_s
    speed = 2.0 * np.pi / turn_s
    sweep_s = turn_s + 2.0 * plan.ramp_s
    time_s = np.arange(-plan.ramp_s - 0.2, len(sweeps) * (sweep_s + plan.pause_s), _GRID_S)
    exposures: list[Floats] = []
    rate = np.zeros(len(time_s))
    for number, sweep in enumerate(sweeps):
        start = number * (sweep_s + plan.pause_s)
        sign = 1.0 if sweep == "ccw" else -1.0
        rate += sign * speed * speed_profile(time_s - start, turn_s, plan, random)
        exposures.append(start + (np.arange(plan.frames_per_sweep, dtype=np.float64) + 0.5) / plan.frames_per_s)
    way = np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1])) * _GRID_S])
    at_start = float(np.interp(0.0, time_s, way))
    first = 0.0 if sweeps[0] == "ccw" else 2.0 * np.pi
    return HeadMotion(time_s, way - at_start + first, tuple(exposures))


def sample_encoder(motion: HeadMotion, encoder: EncoderScale, plan: SweepPlan) -> tuple[Floats, Ints]:
    """The encoder's own samples over the whole motion: times `(n,)` (s) and counts `(n,)`."""
    time_s = np.arange(motion.time_s[0], motion.time_s[-1], 1.0 / plan.encoder_hz)
    return time_s, count_from_theta(motion.theta_at(time_s), encoder)


def count_from_theta(theta_rad: Floats, encoder: EncoderScale) -> Ints:
    """What the counter shows at some head angles: whole steps, the nearest; the disc's eccentricity included."""
    disc = theta_rad.copy()
    for _ in range(5):
        disc = theta_rad - encoder.eccentricity_rad * np.sin(disc - encoder.eccentricity_phase_rad)
    steps = encoder.direction * encoder.steps_per_rev * disc / (2.0 * np.pi)
    return encoder.zero_count + np.rint(steps).astype(np.int64)


def _check(plan: SweepPlan) -> None:
    if plan.frames_per_sweep < 1 or not 0.0 < plan.frames_per_s <= 1000.0:
        raise InputError(
            f"a sweep has at least 1 frame and at most 1000 a second, found {plan.frames_per_sweep} frames at "
            f"{plan.frames_per_s:g} a second."
        )
    if plan.unlit_every < 0 or plan.unlit_every == 1:
        raise InputError(
            f"every n-th frame is unlit, n at least 2 (0: none), found {plan.unlit_every}; 1 would leave no lit frame."
        )
    if not 0.0 <= plan.ripple <= 0.2:
        raise InputError(f"the speed ripple lies between 0 and 0.2 of the speed, found {plan.ripple:g}.")


def speed_profile(since_s: Floats, turn_s: float, plan: SweepPlan, random: np.random.Generator) -> Floats:
    """Speed relative to the nominal one: smooth ramps before and after the turn, and three sines of ripple."""
    up = np.clip((since_s + plan.ramp_s) / max(plan.ramp_s, _GRID_S), 0.0, 1.0)
    down = np.clip((turn_s + plan.ramp_s - since_s) / max(plan.ramp_s, _GRID_S), 0.0, 1.0)
    ramp = up * up * (3.0 - 2.0 * up) * down * down * (3.0 - 2.0 * down)
    hertz, phase = random.uniform(0.8, 6.0, 3), random.uniform(0.0, 2.0 * np.pi, 3)
    waves = np.sin(2.0 * np.pi * hertz * since_s[:, None] + phase).sum(axis=1)
    return ramp * (1.0 + plan.ripple * np.sqrt(2.0 / 3.0) * waves)
