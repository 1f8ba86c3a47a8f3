"""What stands on the board over time: somebody who moves or a thing that does not, and what else is in the way."""

import numpy as np

from footscan.coordinates import Floats
from footscan.sim.board import PrintedBoard
from footscan.sim.machine import TrueMachine, world_from_board
from footscan.sim.person import STATUE, Person, PersonSettings
from footscan.sim.surface import Surface


class Standing:
    """A body on a machine's own, slightly leaning board, with obstacles that stand still."""

    def __init__(
        self,
        body: Surface,
        machine: TrueMachine,
        person: PersonSettings | None = None,
        seed: int = 0,
        obstacles: tuple[Surface, ...] = (),
    ) -> None:
        """Take over a body and obstacles that stand on z = 0; without a person nothing moves."""
        self._lay = world_from_board(machine.calibration.floor)
        self._person = None if person is None or person == STATUE else Person(body, person, seed)
        still = [obstacle.moved(self._lay) for obstacle in obstacles]
        self.body = body.moved(self._lay)
        self.printed: PrintedBoard | None = None
        self._obstacles = np.concatenate([np.empty((0, 3)), *(part.xyz_world for part in still)])
        self.surface = _joined([self.body, *still])

    def xyz_world_at(self, time_s: float) -> Floats | None:
        """`(n, 3)` vertices of `surface` at a moment since the scan's start (s); None if nothing ever moves."""
        if self._person is None:
            return None
        body = self._person.xyz_world_at(time_s) @ self._lay[:3, :3].T + self._lay[:3, 3]
        return np.concatenate([body, self._obstacles]) if len(self._obstacles) else body


class BoardStanding(Standing):
    """A printed board at a placement, or nothing at all on the footboard."""

    def __init__(self, board: PrintedBoard | None, machine: TrueMachine) -> None:
        nothing = Surface(np.empty((0, 3)), np.empty((0, 3), dtype=np.int64))
        super().__init__(nothing, machine)
        self.printed = board
        if board is not None:
            self.body = self.surface = board.surface


def _joined(parts: list[Surface]) -> Surface:
    if len(parts) == 1:
        return parts[0]
    first = np.cumsum([0, *(len(part.xyz_world) for part in parts[:-1])])
    faces = np.concatenate([part.faces + start for part, start in zip(parts, first, strict=True)])
    return Surface(np.concatenate([part.xyz_world for part in parts]), faces, all(part.closed for part in parts))
