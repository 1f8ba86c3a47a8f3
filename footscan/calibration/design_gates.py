"""Is it the machine of scanner.toml at all? Limits on how far a workshop builds from the design."""

import numpy as np

from footscan.calibration.gate import Gate
from footscan.optics import Calibration
from footscan.optics.scanner import Scanner, calibration_from_design
from footscan.optics.sheet import alpha_from_sheet

_OTHER_MACHINE = (
    "No workshop is so far off: scanner.toml or the frames belong to another machine, or the lens was exchanged. "
    "Correct scanner.toml and try again."
)


def design_gates(machine: Calibration, scanner: Scanner) -> list[Gate]:
    """How far the machine is from its design: further than any workshop builds means frames of another machine."""
    design = calibration_from_design(scanner)
    floor_lean_deg = float(np.degrees(np.arccos(min(1.0, machine.floor.normal[2]))))
    gates = [*camera_gates(machine, scanner), Gate("floor_lean_deg", floor_lean_deg, 1.5, "", _OTHER_MACHINE)]
    for built, planned in zip(machine.lasers, design.lasers, strict=True):
        turn = np.degrees(_apart_rad(alpha_from_sheet(built), alpha_from_sheet(planned)))
        lean = abs(np.degrees(np.arcsin(built.normal[2])))
        where = f"{built.name} laser"
        gates += [
            Gate("sheet_turned_deg", float(turn), 4.0, where, _swapped(machine, design) or _OTHER_MACHINE),
            Gate("sheet_leans_deg", float(lean), 2.0, where, _OTHER_MACHINE),
            Gate("sheet_off_axis_mm", abs(built.offset_mm), 6.0, where, _OTHER_MACHINE),
        ]
    return gates


def camera_gates(machine: Calibration, scanner: Scanner) -> list[Gate]:
    """The part of `design_gates` that corners alone show: lens, camera and how late frames are stamped."""
    design = calibration_from_design(scanner)
    own, made = machine.camera, design.camera
    shift = np.subtract(own.principal_point_px, made.principal_point_px)
    moved = np.subtract(machine.pose.translation_mm, design.pose.translation_mm)
    figures = {
        "focal_length_off_percent": (100.0 * abs(own.focal_length_mm / made.focal_length_mm - 1.0), 6.0),
        "principal_point_off_percent": (100.0 * float(np.hypot(*shift)) / made.width_px, 8.0),
        "phi_off_deg": (abs(np.degrees(machine.pose.phi_rad - design.pose.phi_rad)), 4.0),
        "sigma_off_deg": (abs(np.degrees(machine.pose.sigma_rad - design.pose.sigma_rad)), 3.0),
        "camera_off_mm": (float(np.linalg.norm(moved)), 45.0),
        "latency_s": (abs(machine.latency_s), 0.2),
    }
    return [Gate(name, float(value), limit, "", _OTHER_MACHINE) for name, (value, limit) in figures.items()]


def _swapped(machine: Calibration, design: Calibration) -> str:
    """What to say when each sheet stands where the other one should."""
    right, left = (alpha_from_sheet(sheet) for sheet in machine.lasers)
    wanted_right, wanted_left = (alpha_from_sheet(sheet) for sheet in design.lasers)
    right_is_left = _apart_rad(right, wanted_left) < _apart_rad(right, wanted_right)
    if right_is_left and _apart_rad(left, wanted_right) < _apart_rad(left, wanted_left):
        return (
            "The lasers are mislabelled: what is called right stands where the left one should, and vice versa. "
            "Exchange their outputs in the rig file and record again."
        )
    return ""


def _apart_rad(one: float, other: float) -> float:
    """Angle between two upright sheets, whichever way their normals point."""
    return float(abs((one - other + 0.5 * np.pi) % np.pi - 0.5 * np.pi))
