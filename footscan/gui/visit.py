"""What the operator does with patients: find, enter, choose. Every method runs on the desk's thread."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, date, datetime
from typing import TYPE_CHECKING

from footscan.coordinates import Side
from footscan.errors import DuplicatePatientError, FootscanError
from footscan.gui import texts
from footscan.gui.desk import Command, Desk, Progress
from footscan.gui.earlier import Earlier, find_earlier
from footscan.gui.last_choice import LastChoice
from footscan.gui.state import PageState, ScanChoice
from footscan.gui.station import Station
from footscan.records import Correction, Foot, FootFacts, NewPatient, Patient, Take
from footscan.records.spelling import born_from_text

if TYPE_CHECKING:
    from footscan.workflow.scan import StoredScan

MOST_SHOWN = 20


class PatientWork:
    """Patients on the page."""

    def __init__(self, desk: Desk, station: Station) -> None:
        self._desk, self._station = desk, station
        self._dismissed: set[tuple[int, date]] = set()

    def set_operator(self, name: str) -> None:
        """Who works here."""
        self._desk.change(operator=name.strip())

    def find(self, typed: str) -> None:
        """Show who fits what was typed."""
        self._desk.change(found=tuple(self._station.store.find_patients(typed, MOST_SHOWN)))

    def choose(self, patient_id: int) -> None:
        """Work with this patient.

        Raises:
            InputError: There is no such patient.
        """
        state = self._desk.state
        if state.job is not None:
            self._desk.say(texts.WORKING, texts.BUSY, wrong=True)
            return
        patient = self._station.store.patient(patient_id)
        takes = takes_of(self._station, patient_id)
        in_use = next((take.id for take in takes if take.in_use), takes[0].id if takes else None)
        feet = feet_today(self._station, patient_id)
        changed = replace(state, patient=patient, takes=takes, feet=feet)
        scan = ScanChoice(changed.next_side or "left", profile=state.scan.profile)  # not the load of somebody else
        self._desk.change(
            patient=patient,
            takes=takes,
            feet=feet,
            kept=kept_scans(self._station),
            step="idle",
            findings=(),
            take=None,
            report=None,
            note="",
            scan=scan,
            earlier=self._earlier(patient_id, scan),
            inspect=replace(state.inspect, take_id=in_use, tried=None),
            last=LastChoice(profile=state.last.profile),  # not the last of somebody else
        )

    def enter(self, name: str, born: str, number: str, *, force: bool = False) -> bool:
        """Enter a patient and work with them; False when a person of the same name is there and somebody must decide.

        Raises:
            InputError: An impossible name or date, a number that is taken.
        """
        if not self._desk.state.operator:
            self._desk.say(texts.FAILED, texts.NO_OPERATOR, wrong=True)
            return True
        new = NewPatient(name, born_from_text(born.strip()) if born.strip() else None, number.strip() or None)
        try:
            patient = self._station.store.add_patient(new, self._desk.state.operator, force=force)
        except DuplicatePatientError as err:
            self._desk.say(texts.NAMESAKE_TITLE, str(err), wrong=True)
            return False
        self.find(patient.name)
        self.choose(patient.id)
        self._desk.say(texts.ENTERED, patient.name)
        return True

    def correct(self, take_id: int, right: Correction, reason: str, then: Command) -> None:
        """Put a take where it belongs, and measure again what no longer fits; `then` is called when it is done."""
        state = self._desk.state
        if not state.operator or not reason.strip():
            why = texts.CORRECT_REASON_HINT if state.operator else texts.NO_OPERATOR
            self._desk.say(texts.FAILED, why, wrong=True)
            return

        from footscan.workflow.visit import correct_take

        def done(take: Take) -> None:
            self.refresh()
            then()
            self._desk.say(texts.CORRECTED, corrected_words(take, self._station.store.patient(take.patient_id)))

        def failed(err: FootscanError) -> None:
            self.refresh()  # the correction may stand although the take could not be measured again
            self._desk.say(texts.FAILED, str(err), wrong=True)

        self._desk.job(
            texts.JOB_CORRECT,
            lambda progress: correct_take(self._station.store, take_id, right, reason, state.operator, progress),
            done,
            failed,
        )

    def declare(self, side: Side, facts: FootFacts) -> None:
        """Say what is missing, dressed or deformed on a foot today, or why it is not scanned.

        Raises:
            InputError: Text with control characters.
        """
        state, store = self._desk.state, self._station.store
        if state.patient is None or not state.operator:
            self._desk.say(texts.FAILED, texts.NO_OPERATOR if state.patient else texts.PATIENT_NONE, wrong=True)
            return
        patient, by = state.patient, state.operator

        def work(progress: Progress) -> Foot:
            from footscan.workflow.visit import declare_foot

            return declare_foot(store, store.open_visit(patient.id, by).id, side, facts, by, progress)

        def done(foot: Foot) -> None:
            self.refresh()
            self._desk.say(texts.DECLARED, facts_words(foot))

        def failed(err: FootscanError) -> None:
            self.refresh()  # the declaration stands although a take could not be measured again
            self._desk.say(texts.FAILED, str(err), wrong=True)

        self._desk.job(texts.JOB_DECLARE, work, done, failed)

    def confirm_earlier(self) -> None:
        """What an earlier visit says of the feet holds today as well: declare it, and choose load and skin so."""
        state, store = self._desk.state, self._station.store
        if state.patient is None or not state.operator:
            self._desk.say(texts.FAILED, texts.NO_OPERATOR if state.patient else texts.PATIENT_NONE, wrong=True)
            return
        patient, by, earlier = state.patient, state.operator, state.earlier

        def work(progress: Progress) -> None:
            from footscan.workflow.visit import declare_foot

            visit = store.open_visit(patient.id, by)
            for foot in earlier.feet:
                declare_foot(store, visit.id, foot.side, foot.facts, by, progress)

        def done(_: None) -> None:
            scan = self._desk.state.scan
            load, surface = earlier.load or scan.load, earlier.surface or scan.surface
            self._desk.change(scan=replace(scan, load=load, surface=surface), step="idle", findings=())
            self._dismissed.add((patient.id, _today()))
            self.refresh()
            self._desk.say(texts.EARLIER_DONE, "")

        def failed(err: FootscanError) -> None:
            self.refresh()  # what was declared stands although a take could not be measured again
            self._desk.say(texts.FAILED, str(err), wrong=True)

        self._desk.job(texts.JOB_DECLARE, work, done, failed)

    def dismiss_earlier(self) -> None:
        """It does not hold: ask no more today."""
        patient = self._desk.state.patient
        if patient is not None:
            self._dismissed.add((patient.id, _today()))
        self._desk.change(earlier=Earlier())

    def _earlier(self, patient_id: int, scan: ScanChoice) -> Earlier:
        today = _today()
        if (patient_id, today) in self._dismissed:
            return Earlier()
        return find_earlier(self._station.store, patient_id, today, scan.load, scan.surface)

    def refresh(self) -> None:
        """Read the chosen patient's takes again."""
        state = self._desk.state
        if state.patient is not None:
            number = state.patient.id
            self._desk.change(
                takes=takes_of(self._station, number),
                feet=feet_today(self._station, number),
                earlier=self._earlier(number, state.scan),
            )


def corrected_words(take: Take, patient: Patient) -> str:
    """Where a take belongs now."""
    side, load = texts.SIDES[take.said.side], texts.LOADS[take.said.load]
    return texts.CORRECTED_WORDS.format(take=take.id, patient=patient.name, side=side, load=load)


def takes_of(station: Station, patient_id: int) -> tuple[Take, ...]:
    """All takes of a patient, the latest visit first, and in it the latest take first."""
    visits = station.store.visits(patient_id)
    return tuple(take for visit in visits for take in sorted(station.store.takes(visit.id), key=lambda t: -t.id))


def _today() -> date:
    return datetime.now(UTC).astimezone().date()


def feet_today(station: Station, patient_id: int) -> tuple[Foot, ...]:
    """Feet of which something was said today."""
    today = _today()
    visit = next((visit for visit in station.store.visits(patient_id) if visit.day == today), None)
    return () if visit is None else tuple(station.store.feet(visit.id))


def facts_words(foot: Foot) -> str:
    """What is declared of a foot, in words."""
    facts = foot.facts
    said = [texts.DECLARE_PARTS.get(part, part).lower() for part in facts.missing]
    for label, value in (
        (texts.DRESSINGS, facts.dressings), (texts.DEFORMITY, facts.deformity), (texts.NOT_SCANNED, facts.not_scanned),
    ):  # fmt: skip
        said += [f"{label.lower()}: {value}"] if value else []
    words = "; ".join(said) or texts.DECLARED_NOTHING
    return texts.DECLARED_WORDS.format(side=texts.SIDES[foot.side], facts=words)


def kept_scans(station: Station) -> tuple[StoredScan, ...]:
    """Scans that belong to nobody yet, the newest first."""
    from footscan.workflow.scan import find_scans

    return tuple(scan for scan in reversed(find_scans(station.scans)) if scan.frames)


def patient_words(patient: Patient) -> str:
    """A patient in a list; the number at the end makes it unique."""
    born = f", born {patient.born.isoformat()}" if patient.born else ""
    own = f", {patient.number}" if patient.number else ""
    return f"{patient.name}{born}{own}  #{patient.id}"


def chosen_from(words: str, state: PageState) -> Patient | None:
    """The patient behind a line of `patient_words`."""
    return next((patient for patient in state.found if patient_words(patient) == words), None)
