"""What the paper's own model makes of the same recording, to compare with: never what is saved.

Part I knows one angle per sheet: both stand upright on the footboard and pass through the axis. Part II knows one view
of coplanar points. What either cannot see stays as designed, and is said.
"""

from dataclasses import dataclass, replace

import numpy as np

from footscan.calibration.estimate import CAMERA, HEAD, sheet_from_angles
from footscan.calibration.joint import JointFit
from footscan.calibration.monoview import HELD, fit_monoview
from footscan.calibration.solve import Fit, fit_estimate
from footscan.calibration.uncertainty import machine_difference_mm
from footscan.calibration.unknowns import Unknowns
from footscan.coordinates import LaserName
from footscan.geometry.plane import Plane
from footscan.optics import Calibration, LightPlane
from footscan.optics.scanner import calibration_from_design
from footscan.optics.sheet import alpha_from_sheet

ONE_ANGLE_HELD = ("lean and offset of both sheets", "slope of the footboard", "eccentricity", "K2")
"""What the model of Part I has no unknown for."""
_ONE_ANGLE = Unknowns(
    (*(name for name in CAMERA if name != "k2_per_mm4"), *HEAD, "right_azimuth_rad", "left_azimuth_rad", "latency_s")
)


@dataclass(frozen=True)
class PaperMode:
    """The paper's way beside the joint estimate.

    Attributes:
        off_mm: RMS distance in the working volume between both, per laser, with one angle per sheet.
        misfit_px: RMS of corners and stripe places that one angle per sheet leaves; that of the joint estimate.
        frame: The one view of Part II: the frame in which most corners were found.
        corners: In it.
        focal_length_mm: What that view says; what the joint estimate says.
    """

    off_mm: dict[LaserName, float]
    misfit_px: tuple[float, float]
    frame: int
    corners: int
    focal_length_mm: tuple[float, float]

    def lines(self) -> list[str]:
        """For the screen."""
        off = ", ".join(f"{name} {mm:.2f} mm" for name, mm in self.off_mm.items())
        return [
            f"Paper, Part I (one angle per sheet; held: {', '.join(ONE_ANGLE_HELD)}): {off} RMS from this calibration "
            f"in the working volume; it leaves {self.misfit_px[0]:.2f} px RMS instead of {self.misfit_px[1]:.2f}",
            f"Paper, Part II (one view, frame {self.frame}, {self.corners} corners; held: {', '.join(HELD)}): focal "
            f"length {self.focal_length_mm[0]:.3f} mm, this calibration {self.focal_length_mm[1]:.3f} mm",
        ]


def compare_with_paper(joint: JointFit) -> PaperMode:
    """Fit the paper's models to what a joint estimate was fitted to."""
    machine = joint.fit.estimate.machine
    one_angle = fit_estimate(replace(joint.fit.estimate, machine=upright(machine)), joint.sightings, _ONE_ANGLE)
    off = machine_difference_mm(one_angle.estimate.machine, machine)
    frame, corners, focal_mm = _one_view(joint)
    return PaperMode(
        {name: float(np.sqrt(np.mean(mm**2))) for name, mm in off.items()},
        (_misfit_px(one_angle), _misfit_px(joint.fit)),
        frame,
        corners,
        (focal_mm, machine.camera.focal_length_mm),
    )


def upright(machine: Calibration) -> Calibration:
    """The machine as Part I knows one: sheets through the axis, everything square, the disc centred."""
    right, left = (_through_axis(sheet) for sheet in machine.lasers)
    encoder = replace(machine.encoder, eccentricity_rad=0.0)
    return replace(machine, lasers=(right, left), floor=Plane((0.0, 0.0, 1.0), 0.0), encoder=encoder)


def _through_axis(sheet: LightPlane) -> LightPlane:
    return sheet_from_angles(sheet, alpha_from_sheet(sheet), 0.0, 0.0)


def _misfit_px(fit: Fit) -> float:
    """RMS of all residuals, each counted up to 3 px."""
    return float(np.sqrt(np.mean(np.minimum(np.abs(np.nan_to_num(fit.residual_px, nan=3.0)), 3.0) ** 2)))


def _one_view(joint: JointFit) -> tuple[int, int, float]:
    """Number, corners and focal length of the view with most corners."""
    corners = joint.intake.corners.kept(~joint.intake.corners.moving)
    frames, count = np.unique(corners.frame, return_counts=True)
    best = int(frames[np.argmax(count)])
    own = corners.kept(corners.frame == best)
    recording = joint.intake.recording
    view = fit_monoview(calibration_from_design(recording.scanner), own.xy_board, own.yz_pixel)
    return recording.frames[best].frame, len(own), view.fit.estimate.machine.camera.focal_length_mm
