"""Pictures at requested angles: of all frames the one nearest to each multiple of the angular step (paper, 3)."""

from typing import Generic, TypeVar

Item = TypeVar("Item")


class AnglePicker(Generic[Item]):
    """Takes frames in order and gives back those nearest to k * step; one picker per sweep and laser."""

    def __init__(self, step_rad: float) -> None:
        self._step_rad = step_rad
        self._best: tuple[int, float, Item] | None = None
        self.passed_over = 0

    def offer(self, theta_rad: float, item: Item) -> list[Item]:
        """One more frame; returns the frame picked for the requested angle that the head has now left, if any."""
        wanted = round(theta_rad / self._step_rad)
        off_rad = abs(theta_rad - wanted * self._step_rad)
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
