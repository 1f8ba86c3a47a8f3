"""The state of the page, in one place; only the desk's thread replaces it."""

from __future__ import annotations

from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from footscan.config.recording_file import Load, Surface
from footscan.coordinates import LaserName, Side
from footscan.gui.earlier import Earlier
from footscan.gui.last_choice import LastChoice
from footscan.gui.live_picture import Kind
from footscan.records import Foot, Patient, Take
from footscan.scanning.session.states import Finding

if TYPE_CHECKING:
    from footscan.devices.diagnosis import Finding as Examined
    from footscan.gui.inspected import TriedFoot
    from footscan.workflow.drill_result import DrillResult
    from footscan.workflow.guided_calibration import PlacementReport
    from footscan.workflow.scan import StoredScan

Step = Literal["idle", "checked", "result"]
"""Of the operator's scan; what is being done meanwhile is the running job's business."""
Shown = Literal["Shaded", "Seen / assumed", "Distance to points"]


@dataclass(frozen=True)
class Job:
    """Something that takes longer than a moment.

    Attributes:
        words: What it is.
        done: Of `total`.
        total: 0 while not known.
    """

    words: str
    done: int = 0
    total: int = 0


@dataclass(frozen=True)
class ScanChoice:
    """What the operator chose for the next scan."""

    side: Side = "left"
    load: Load = "bipedal"
    surface: Surface = "bare"
    profile: str = ""
    wedge_mm: float = 0.0


@dataclass(frozen=True)
class CameraChoice:
    """What the camera panel shows. `threshold` counts when `automatic` is off."""

    kind: Kind = "Overlay"
    automatic: bool = True
    threshold: int = 60
    row: int | None = None
    laser: LaserName = "right"

    @property
    def in_use(self) -> int | None:
        """None for the automatic one."""
        return None if self.automatic else self.threshold


@dataclass(frozen=True)
class InspectChoice:
    """What is looked at; `tried` is a filtered and smoothed copy that is shown instead."""

    take_id: int | None = None
    shown: Shown = "Shaded"
    beside: bool = False
    share: float = 0.5
    turn_deg: float = 0.0
    tilt_deg: float = 0.0
    tried: TriedFoot | None = None


@dataclass(frozen=True)
class CalibrationChoice:
    """Where the calibration of the machine has got to.

    Attributes:
        folder: Of the recording in the making or last finished.
        placements: What each placement of the board showed.
        expected: What a calibration from the recording so far would promise.
        advice: Where the board belongs next.
        good: Placements that count.
        enough: It would be good enough.
        recorded: The recording is finished and can be computed.
        made: Where a new calibration lies that is not in force.
        lines: What is said of it.
    """

    folder: Path | None = None
    placements: tuple[PlacementReport, ...] = ()
    expected: str = ""
    advice: str = ""
    good: int = 0
    enough: bool = False
    recorded: bool = False
    made: Path | None = None
    lines: tuple[str, ...] = ()


@dataclass(frozen=True)
class PageState:
    """Everything the page shows that is not the machine's own state.

    Attributes:
        operator: Who works here.
        found: Patients that fit what was typed.
        patient: Chosen.
        takes: Of the chosen patient, the latest visit first.
        feet: What is declared of the feet today.
        earlier: What an earlier visit says of them, and nobody has confirmed or dismissed today.
        scan: For the next scan.
        camera: Of the camera panel.
        step: Of the scan.
        findings: Of the last check.
        take: The scan just made.
        report: Its scan.json.
        inspect: Of the Inspect tab.
        last: Of the Last tab.
        job: What runs.
        note: The last thing said in the Scan tab.
        kept: Scans that were never filed.
        calibration: Of the Calibrate tab.
        examined: What the last look at all devices found.
        drilled: What the last drill of the machine measured.
        records_drill: What the last drill of the records found.
    """

    operator: str = ""
    found: tuple[Patient, ...] = ()
    patient: Patient | None = None
    takes: tuple[Take, ...] = ()
    feet: tuple[Foot, ...] = ()
    earlier: Earlier = field(default_factory=Earlier)
    scan: ScanChoice = field(default_factory=ScanChoice)
    camera: CameraChoice = field(default_factory=CameraChoice)
    step: Step = "idle"
    findings: tuple[Finding, ...] = ()
    take: Take | None = None
    report: dict[str, Any] | None = None
    inspect: InspectChoice = field(default_factory=InspectChoice)
    last: LastChoice = field(default_factory=LastChoice)
    job: Job | None = None
    note: str = ""
    kept: tuple[StoredScan, ...] = ()
    calibration: CalibrationChoice = field(default_factory=CalibrationChoice)
    examined: tuple[Examined, ...] = ()
    drilled: tuple[DrillResult, ...] = ()
    records_drill: str = ""

    @property
    def next_side(self) -> Side | None:
        """Left before right, then nothing: by today's takes that are in use, and feet that are not scanned today."""
        today = datetime.now(UTC).astimezone().date()
        done = {
            take.said.side for take in self.takes if take.in_use and take.said.recorded.astimezone().date() == today
        }
        done |= {foot.side for foot in self.feet if foot.facts.not_scanned}
        sides: tuple[Side, Side] = ("left", "right")
        return next((side for side in sides if side not in done), None)
