"""The alignment view: how far lasers, focus and exposure are from where they should be, and which way to turn.

It comes before a calibration, while lasers still sit loose on their guides: one placement of the board, near the
axis and almost upright, and the bare footboard are enough.
"""

from dataclasses import dataclass

import numpy as np

from footscan.calibration.charuco import BoardFinder
from footscan.calibration.intake import Intake
from footscan.calibration.misfit import head_angles, stripe_points_head, stripe_scale_mm_per_px
from footscan.calibration.one_placement import fit_roughly
from footscan.calibration.picture_figures import SATURATED, BoardFigures, StripeFigures, board_figures, stripe_figures
from footscan.calibration.sightings import Sightings, StripePoints
from footscan.calibration.solve import Fit
from footscan.calibration.stripes import assign_stripes, lit_stripe
from footscan.coordinates import LASER_NAMES, Floats, LaserName, uv_from_pixel
from footscan.optics import Calibration
from footscan.optics.scanner import calibration_from_design
from footscan.optics.sheet import alpha_from_sheet
from footscan.scanning.frames import read_frame

ZONES_MM: dict[str, tuple[float, float]] = {"near": (-170.0, -55.0), "middle": (-55.0, 55.0), "far": (55.0, 170.0)}
"""Along x_L: near the laser, about the axis, beyond it."""
GOOD_OFFSET_MM = 0.5
GOOD_LEAN_DEG = 0.15
GOOD_TURN_DEG = 1.0
WIDTH_PX = (1.5, 7.0)
"""Full width at half maximum: places scatter by 0.005 px between 1.5 and 4 px, by twice that at 1.3 px."""
MOST_BLUR_PX = 1.3
WHITE_GREY = (70.0, 245.0)
PEAK_GREY = (30.0, 250.0)
_BRIGHTEST = 4


@dataclass(frozen=True)
class SheetAlignment:
    """One laser.

    Attributes:
        laser: Which.
        offset_mm: Of its sheet from the axis, to the right as seen from the laser.
        lean_deg: Out of the vertical; its top to the left as seen from the laser.
        turned_deg: About the vertical from its designed direction, counter-clockwise from above.
        width_px: Full width at half maximum near, about and beyond the axis; NaN where nothing was seen.
        width_mm: The same on the surface.
        peak_grey: Median of the stripe's peaks on boards.
        saturated: Share of them at the top of the grey scale.
    """

    laser: LaserName
    offset_mm: float
    lean_deg: float
    turned_deg: float
    width_px: dict[str, float]
    width_mm: dict[str, float]
    peak_grey: float
    saturated: float

    def advice(self) -> list[str]:
        """What to turn, and which way; empty when nothing has to be."""
        said: list[str] = []
        if abs(self.offset_mm) > GOOD_OFFSET_MM:
            side = "left" if self.offset_mm > 0.0 else "right"
            said.append(f"shift it by {abs(self.offset_mm):.1f} mm to the {side}, as seen from the laser")
        if abs(self.lean_deg) > GOOD_LEAN_DEG:
            way = "clockwise" if self.lean_deg > 0.0 else "counter-clockwise"
            said.append(f"turn it about its beam by {abs(self.lean_deg):.2f} degrees {way}, as seen from the laser")
        if abs(self.turned_deg) > GOOD_TURN_DEG:
            way = "clockwise" if self.turned_deg > 0.0 else "counter-clockwise"
            said.append(f"swing it about the axis by {abs(self.turned_deg):.1f} degrees {way}, as seen from above")
        return [*said, *self._light()]

    def _light(self) -> list[str]:
        said: list[str] = []
        seen = {zone: width for zone, width in self.width_px.items() if np.isfinite(width)}
        if seen and max(seen.values()) > WIDTH_PX[1]:
            worst = max(seen, key=lambda zone: seen[zone])
            said.append(f"focus its line: {seen[worst]:.1f} px wide {_where(worst)}, at most {WIDTH_PX[1]:g}")
        if seen and min(seen.values()) < WIDTH_PX[0]:
            worst = min(seen, key=lambda zone: seen[zone])
            said.append(
                f"defocus its line a little: {seen[worst]:.1f} px wide {_where(worst)}, at least {WIDTH_PX[0]:g}"
            )
        if self.saturated > 0.3 or self.peak_grey > PEAK_GREY[1]:
            said.append(
                f"{100 * self.saturated:.0f} % of its peaks are saturated: shorten the exposure, close the lens"
            )
        if self.peak_grey < PEAK_GREY[0]:
            said.append(
                f"its peaks reach grey {self.peak_grey:.0f}, below {PEAK_GREY[0]:g}: expose longer, open the lens"
            )
        return said


def _where(zone: str) -> str:
    return {"near": "between laser and axis", "middle": "about the axis", "far": "beyond the axis"}[zone]


@dataclass(frozen=True)
class Alignment:
    """Both lasers, and the camera's own picture: blur of the board's edges (sigma, px), grey of white and black."""

    sheets: tuple[SheetAlignment, SheetAlignment]
    blur_px: float
    white_grey: float
    black_grey: float

    def advice(self) -> list[str]:
        """Everything to do, in the order in which to do it: light first, then the lasers."""
        said: list[str] = []
        if self.blur_px > MOST_BLUR_PX:
            said.append(f"camera: edges are blurred by {self.blur_px:.2f} px, at most {MOST_BLUR_PX:g}: focus the lens")
        if self.white_grey < WHITE_GREY[0]:
            said.append(f"camera: white paper has grey {self.white_grey:.0f}, below {WHITE_GREY[0]:g}: light the board")
        if self.white_grey > WHITE_GREY[1]:
            said.append(f"camera: white paper has grey {self.white_grey:.0f}, above {WHITE_GREY[1]:g}: less light")
        return said + [f"{sheet.laser} laser: {word}" for sheet in self.sheets for word in sheet.advice()]


def measure_alignment(intake: Intake, raw: StripePoints, machine: Calibration | None = None) -> Alignment:
    """Where both sheets are, and how the pictures look.

    Args:
        intake: Of a recording with one placement or more, and the bare footboard.
        raw: Its stripe places.
        machine: Where to start; default: the design.

    Raises:
        PoorFitError: A laser left too few stripe places.
    """
    fit = fit_roughly(intake, raw, machine or calibration_from_design(intake.recording.scanner))
    figures = _board_figures(intake)
    right, left = (_sheet(intake, raw, fit, code) for code in range(2))
    return Alignment(
        (right, left),
        float(np.nanmedian([f.blur_px for f in figures])),
        float(np.nanmedian([f.white_grey for f in figures])),
        float(np.nanmedian([f.black_grey for f in figures])),
    )


def _board_figures(intake: Intake) -> list[BoardFigures]:
    """From the frames with most corners, where the board faces the camera."""
    frames, count = np.unique(intake.corners.frame[~intake.corners.moving], return_counts=True)
    finder, columns = BoardFinder(intake.board), intake.board.squares_x - 1
    result: list[BoardFigures] = []
    for k in frames[np.argsort(-count, kind="stable")][:_BRIGHTEST]:
        record = intake.recording.frames[int(k)]
        frame = read_frame(intake.recording.path(record), intake.recording.scanner.camera)
        found = finder.find(frame)
        if found is not None:
            result.append(board_figures(frame, found.uv, found.number, columns))
    return result


def _sheet(intake: Intake, raw: StripePoints, fit: Fit, code: int) -> SheetAlignment:
    sheet = fit.estimate.machine.lasers[code]
    planned = intake.recording.scanner.lasers[code].alpha_rad
    n_x, n_y, n_z = sheet.normal
    own = assign_stripes(raw.kept(raw.laser == code), fit.estimate, intake)
    place, figures, mm_per_px = _along(intake, own, fit)
    # along the sheet, from the laser through the axis: n turned by a right angle about the vertical
    x_light = place @ np.array([-n_y, n_x, 0.0]) / np.hypot(n_x, n_y)
    zones = {zone: (x_light >= low) & (x_light < high) for zone, (low, high) in ZONES_MM.items()}
    on_board = own.placement >= 0
    peaks = figures.peak_grey[on_board & np.isfinite(figures.peak_grey)]
    return SheetAlignment(
        LASER_NAMES[code],
        sheet.offset_mm,
        float(np.degrees(np.arcsin(n_z))),
        float(np.degrees(alpha_from_sheet(sheet) - planned)),
        {zone: _median(figures.width_px[where]) for zone, where in zones.items()},
        {zone: _median((figures.width_px * mm_per_px)[where]) for zone, where in zones.items()},
        _median(peaks),
        float(np.mean(peaks >= SATURATED)) if len(peaks) else float("nan"),
    )


def _median(values: Floats) -> float:
    seen = values[np.isfinite(values)]
    return float(np.median(seen)) if len(seen) >= 10 else float("nan")


def _along(intake: Intake, own: StripePoints, fit: Fit) -> tuple[Floats, StripeFigures, Floats]:
    """Of every stripe place: where it lies in the head's W, its width and peak, and mm per px across it."""
    width, peak = np.full(len(own), np.nan), np.full(len(own), np.nan)
    partner = dict(intake.pairs)
    height_px = intake.recording.scanner.camera.height_px
    for lit in np.unique(own.frame):
        here = own.frame == lit
        stripe_only = lit_stripe(intake, int(lit), partner[int(lit)])
        if stripe_only is not None:
            found = stripe_figures(stripe_only, uv_from_pixel(own.yz_pixel[here], height_px))
            width[here], peak[here] = found.width_px, found.peak_grey
    sightings = Sightings(intake.times, intake.corners, own, intake.placement_names)
    theta_rad = head_angles(fit.estimate, sightings)
    place = stripe_points_head(fit.estimate, own, theta_rad)
    return place, StripeFigures(width, peak), stripe_scale_mm_per_px(fit.estimate, own, theta_rad)
