"""What was said of a patient's feet at an earlier visit, proposed for today; it holds when a person says so."""

from dataclasses import dataclass, replace
from datetime import date

from footscan.config.recording_file import Load, Surface
from footscan.coordinates import Side
from footscan.records import Foot, FootFacts, RecordStore, Take, Visit

_SIDES: tuple[Side, ...] = ("left", "right")


@dataclass(frozen=True)
class Earlier:
    """What is proposed; nothing of it holds before somebody says so.

    Attributes:
        feet: What was last declared of a foot and is not declared today.
        days: When that was, per foot.
        load: Of the last visit's take in use, when it is another than is chosen now; None otherwise.
        surface: The same for what covered the skin.
    """

    feet: tuple[Foot, ...] = ()
    days: tuple[date, ...] = ()
    load: Load | None = None
    surface: Surface | None = None

    def __bool__(self) -> bool:
        """Something is proposed."""
        return bool(self.feet) or self.load is not None or self.surface is not None


def find_earlier(store: RecordStore, patient_id: int, today: date, load: Load, surface: Surface) -> Earlier:
    """What earlier visits propose for today.

    Args:
        store: The records.
        patient_id: The patient.
        today: Visits before it count.
        load: Chosen for the next scan.
        surface: Chosen for the next scan.
    """
    visits = store.visits(patient_id)  # the latest first
    before = [visit for visit in visits if visit.day < today]
    declared = {foot.side for visit in visits if visit.day >= today for foot in store.feet(visit.id) if _special(foot)}
    found = [last for side in _SIDES if side not in declared and (last := _last_declared(store, before, side))]
    take = _last_take(store, before)
    other_load = take.said.load if take is not None and take.said.load not in ("unknown", load) else None
    other_surface = take.said.surface if take is not None and take.said.surface not in ("unknown", surface) else None
    return Earlier(tuple(foot for foot, _ in found), tuple(day for _, day in found), other_load, other_surface)


def _special(foot: Foot) -> bool:
    return foot.facts != FootFacts()


def _last_declared(store: RecordStore, visits: list[Visit], side: Side) -> tuple[Foot, date] | None:
    """Why a foot was not scanned held on its day alone."""
    for visit in visits:
        for foot in store.feet(visit.id):
            lasting = replace(foot, facts=replace(foot.facts, not_scanned=""))
            if foot.side == side and _special(lasting):
                return lasting, visit.day
    return None


def _last_take(store: RecordStore, visits: list[Visit]) -> Take | None:
    for visit in visits:
        takes = sorted(store.takes(visit.id), key=lambda take: (take.in_use, take.id), reverse=True)
        if takes:
            return takes[0]
    return None
