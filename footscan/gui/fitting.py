"""What the Last tab works with: lasts ranked for a foot, one laid round it, one customised; no browser here."""

from pathlib import Path

from footscan.coordinates import Floats
from footscan.errors import InputError
from footscan.gui.inspected import InspectedFoot
from footscan.gui.last_choice import FittedLast
from footscan.scanning.sweep import Progress
from footscan.shoelast.compare import compare
from footscan.shoelast.custom_last import CustomLast
from footscan.shoelast.customise import CustomSettings, customise
from footscan.shoelast.last_library import LastLibrary
from footscan.shoelast.pins import Pin
from footscan.shoelast.prepared_foot import PreparedFoot, prepare_foot
from footscan.shoelast.rank import Ranked, rank
from footscan.shoelast.skin import Sampling, skin_of
from footscan.shoelast.top_line import FeatherLine
from footscan.workflow.lasts_clearance import skin_clearance
from footscan.workflow.stored_foot import stored_subject

LASTS = "lasts"
BEST = 12
"""So many of a ranking are shown."""
_SHOWN_SAMPLING = Sampling(240, 80, 20)


class Fitting:
    """Lasts for the feet of one data folder; prepared feet are kept."""

    def __init__(self, data: Path) -> None:
        self.shelf = LastLibrary(data / LASTS)
        self._prepared: dict[int, PreparedFoot] = {}

    def prepared(self, foot: InspectedFoot) -> PreparedFoot:
        """The foot of a take, measured for fitting.

        Raises:
            MeshError: It is no foot.
        """
        result = foot.take.result
        key = -1 if result is None else result.id
        if key not in self._prepared:
            take = foot.take
            self._prepared[key] = prepare_foot(
                foot.mesh, take.said.side, take.said.load, take.missing, stored_subject(foot.folder).wedge
            )
        return self._prepared[key]

    def ranking(self, foot: InspectedFoot, profile: str) -> tuple[Ranked, ...]:
        """The best lasts of the foot's side, best first.

        Raises:
            InputError: The library holds no last of that side.
        """
        prepared = self.prepared(foot)
        entries = [entry for entry in self.shelf.entries() if entry.side == prepared.side]
        return tuple(rank(entries, prepared, profile)[:BEST])

    def fitted(self, foot: InspectedFoot, last_id: str, profile: str) -> FittedLast:
        """Lay the foot into a last.

        Raises:
            InputError: No such last, or the wrong side.
            QualityError: The last's pitch is more than a scan can be bent to.
        """
        shoelast = self.shelf.load(last_id)
        found = compare(shoelast, self.prepared(foot), profile)
        if found.posed is None or found.top_line is None:
            raise InputError(f"{last_id} could not be laid round the foot; choose another last.")
        skin = skin_of(shoelast, _SHOWN_SAMPLING)
        clearance = skin_clearance(skin, found.posed, found.top_line, FeatherLine(shoelast))
        return FittedLast(last_id, shoelast, skin, found, clearance)

    def customised(
        self, foot: InspectedFoot, last_id: str, profile: str, settings: CustomSettings, progress: Progress
    ) -> CustomLast:
        """Change the last so that it holds the foot; it can be cancelled at any time.

        Raises:
            InputError: No such last, or the wrong side.
            QualityError: The last is too small, or no change meets all that is asked.
            CancelledError: Somebody cancelled.
        """
        progress(0, 3)
        prepared = self.prepared(foot)
        progress(1, 3)
        shoelast = self.shelf.load(last_id)
        progress(2, 3)
        made = customise(shoelast, prepared, profile, settings, lambda: progress(2, 3))
        progress(3, 3)
        return made

    def pin_at(self, foot: InspectedFoot, landmark: str, radius_mm: float, extra_mm: float, why: str) -> Pin:
        """A spot allowance at a landmark; `why` names it for people.

        Raises:
            InputError: No such landmark, or numbers outside what is allowed.
        """
        prepared = self.prepared(foot)
        if landmark not in prepared.points:
            raise InputError(f"{why} was not found on this foot; choose another place.")
        x, y, z = prepared.frame.to_input(prepared.points[landmark][None])[0].tolist()
        return Pin((x, y, z), radius_mm, extra_mm, why)


def custom_clearance(custom: CustomLast) -> Floats:
    """Room of a customised last at the vertices of the posed foot, `(n,)`."""
    return skin_clearance(custom.skin, custom.posed, custom.proof.top_line, FeatherLine(custom.shoelast))
