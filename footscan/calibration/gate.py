"""One gate of a calibration: a figure against its limit, and how it is told."""

from dataclasses import dataclass

from footscan.errors import PoorFitError

_WORDS = {
    "board_bent_mm": ("the board's middle stands out", " mm"),
    "board_of_other_size": ("a board differs in size from the others by a share", ""),
    "boards_spread_deg": ("largest angle between two placements", " degrees"),
    "camera_off_mm": ("the camera is away from its designed place", " mm"),
    "condition": ("condition number of the estimate", ""),
    "corner_scatter_px": ("scatter of all corners", " px"),
    "expected_error_mm": ("expected error", " mm"),
    "floor_lean_deg": ("the footboard leans", " degrees"),
    "focal_length_off_percent": ("the focal length is off its design", " %"),
    "footboard_off_mm": ("the footboard is off", " mm"),
    "height_coverage": ("share of the height that stripes on boards span", ""),
    "holdout_corners_px": ("corners of a placement that the fit never saw", " px"),
    "holdout_sheet_mm": ("stripes of a placement that the fit never saw", " mm"),
    "image_coverage": ("share of the picture that was used", ""),
    "latency_s": ("frames are stamped late", " s"),
    "phi_off_deg": ("the camera's tilt phi is off its design", " degrees"),
    "picture_jump_of_allowed": ("the picture jumps, relative to what is allowed", ""),
    "placement_corners_px": ("corners fit the others", " px RMS"),
    "placement_rejected_corners": ("share of corners that fit nothing", ""),
    "principal_point_off_percent": ("the principal point is off its design", " % of the width"),
    "print_scale_unequal": ("print scale unequal, x against y, by a share", ""),
    "rejected_stripe_places": ("share of stripe places that fit nothing", ""),
    "sheet_leans_deg": ("the sheet leans", " degrees"),
    "sheet_of_halves_mm": ("two halves of the data differ", " mm"),
    "sheet_off_axis_mm": ("the sheet misses the axis", " mm"),
    "sheet_off_board_mm": ("the sheet lies off the boards", " mm"),
    "sheet_turned_deg": ("the sheet is turned off its design", " degrees"),
    "sheets_disagree_mm": ("both sheets see one board at different places", " mm"),
    "sigma_off_deg": ("the camera's roll sigma is off its design", " degrees"),
    "stripe_lopsided_share": ("far-off stripe places lie on one side, by a share", ""),
    "stripe_scatter_px": ("scatter of stripe places", " px"),
}
"""What each figure is called, and its unit, as a technician reads it."""


@dataclass(frozen=True)
class Reason:
    """Why a calibration is refused.

    Attributes:
        sentence: What was found, what is allowed, what to do.
        repeat: The placement whose repetition is enough; empty where that does not help.
        more: More placements may be enough.
    """

    sentence: str
    repeat: str = ""
    more: bool = False

    def refusal(self) -> PoorFitError:
        """The error to raise."""
        return PoorFitError(f"no calibration: {self.sentence} The calibration in force stays.", self.repeat, self.more)


@dataclass(frozen=True)
class Gate:
    """One figure against its limit.

    Attributes:
        name: What it is, with its unit; one of those that have words.
        value: The worst one found.
        limit: The largest one allowed (the smallest where `least` holds).
        where: The placement, laser or zone of the worst one; empty where there is none.
        advice: What is wrong if it fails, and what to do.
        least: The limit is a least one.
        repeat: The placement whose repetition is enough if it fails; empty where that does not help.
        more: More placements may be enough if it fails.
    """

    name: str
    value: float
    limit: float
    where: str
    advice: str
    least: bool = False
    repeat: str = ""
    more: bool = False

    @property
    def passed(self) -> bool:
        """Whether the figure keeps its limit; NaN does not."""
        return self.value >= self.limit if self.least else self.value <= self.limit

    def finding(self) -> str:
        """What was found and what is allowed, in words and units."""
        words, unit = _WORDS[self.name]
        where = f" ({self.where})" if self.where else ""
        bound = "at least" if self.least else "at most"
        return f"{words}{where}: {self.value:.3g}{unit}, allowed {bound} {self.limit:g}{unit}"

    def sentence(self) -> str:
        """What was found, what is allowed, what to do."""
        return f"{self.finding()}. {self.advice}"

    def reason(self) -> Reason:
        """Why it refuses, if it fails."""
        return Reason(self.sentence(), self.repeat, self.more)
