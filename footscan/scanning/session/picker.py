"""Pictures at requested angles: of all frames the one nearest to each multiple of the angular step (paper, 3)."""

from dataclasses import dataclass
from typing import Generic, TypeVar

Item = TypeVar("Item")


@dataclass(frozen=True)
class RequestedAngles:
    """The multiples of `step_rad` from `sweep_rad[0]` to `sweep_rad[1]`; the run-up and the run-out ask for none."""

    step_rad: float
    sweep_rad: tuple[float, float]

    def nearest(self, theta_rad: float) -> int | None:
        """Which multiple lies nearest; None where that one is outside the sweep."""
        wanted = round(theta_rad / self.step_rad)
        low_rad, high_rad = self.sweep_rad
        return wanted if low_rad <= wanted * self.step_rad <= high_rad else None


class AnglePicker(Generic[Item]):
    """Takes frames in order and gives back those nearest to the requested angles; one picker per sweep and laser."""

    def __init__(self, requested: RequestedAngles) -> None:
        self._requested = requested
        self._best: tuple[int, float, Item] | None = None
        self.passed_over = 0

    def offer(self, theta_rad: float, item: Item) -> list[Item]:
        """One more frame; returns the frame picked for the requested angle that the head has now left, if any."""
        wanted = self._requested.nearest(theta_rad)
        if wanted is None:
            self.passed_over += 1
            return self.rest()
        off_rad = abs(theta_rad - wanted * self._requested.step_rad)
        best, self._best = self._best, (wanted, off_rad, item)
        if best is None:
            return []
        if best[0] != wanted:
            return [best[2]]
        self.passed_over += 1
        if best[1] <= off_rad:
            self._best = best
        return []

    def rest(self) -> list[Item]:
        """The frame picked for the last requested angle."""
        best, self._best = self._best, None
        return [] if best is None else [best[2]]
