"""The turning head over time: a motor with limited acceleration and speed ripple, known every millisecond."""

import numpy as np

from footscan.coordinates import Floats

STEP_S = 0.001
_KEPT_STEPS = 8000


class HeadDrive:
    """Head angle over time, in steps of a millisecond; the last eight seconds at least are remembered."""

    def __init__(self, theta_rad: float, acceleration_rad_s2: float, ripple: float, seed: int, start_s: float) -> None:
        random = np.random.default_rng([seed, 0x407104])
        self._hertz, self._phase = random.uniform(0.8, 6.0, 3), random.uniform(0.0, 2.0 * np.pi, 3)
        self._acceleration, self._ripple = acceleration_rad_s2, ripple
        self._speed = self._rate = 0.0
        self._time_s, self._theta_rad = np.array([start_s]), np.array([theta_rad])
        self.blocked = False

    @property
    def now_s(self) -> float:
        """Up to where the way is known."""
        return float(self._time_s[-1])

    @property
    def theta_rad(self) -> float:
        """The newest angle."""
        return float(self._theta_rad[-1])

    @property
    def turning(self) -> bool:
        """The head moves."""
        return self._speed != 0.0

    def theta_at(self, time_s: Floats) -> Floats:
        """Angles at some remembered moments, and up to a step after the newest: the head goes on as it does."""
        ahead_s = np.clip(time_s - self.now_s, 0.0, STEP_S)
        return np.interp(time_s, self._time_s, self._theta_rad) + self._rate * ahead_s

    def turn_until(self, time_s: float, target_rad_s: float) -> None:
        """Let time pass with the motor at one command."""
        steps = int(np.floor((time_s - self.now_s) / STEP_S + 1e-6))
        if steps < 1:
            return
        if self.blocked:
            target_rad_s = self._speed = 0.0
        moments = self.now_s + STEP_S * np.arange(1, steps + 1)
        change = np.sign(target_rad_s - self._speed) * self._acceleration * STEP_S * np.arange(steps + 1)
        low, high = sorted((self._speed, target_rad_s))
        speed = np.clip(self._speed + change, low, high)
        waves = np.sin(2.0 * np.pi * self._hertz * moments[:, None] + self._phase).sum(axis=1)
        rate = 0.5 * (speed[1:] + speed[:-1]) * (1.0 + self._ripple * np.sqrt(2.0 / 3.0) * waves)
        self._speed, self._rate = float(speed[-1]), float(rate[-1])
        self._time_s = np.concatenate([self._time_s, moments])[-2 * _KEPT_STEPS :]
        self._theta_rad = np.concatenate([self._theta_rad, self.theta_rad + np.cumsum(rate) * STEP_S])[
            -2 * _KEPT_STEPS :
        ]
