"""The figures of an acceptance test in sentences, for the screen and for the sheet."""

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from footscan.workflow.accept import Acceptance


def sheet_lines(acceptance: "Acceptance") -> list[str]:
    """What the sheet says below its pictures: what was scanned and with what, every figure, every limit."""
    report, artefact = acceptance.report, acceptance.artefact
    limits = report["limits"]
    sizes = [f"diameters {' and '.join(f'{d:.3f}' for d in artefact.diameters_mm)} mm"] if artefact.diameters_mm else []
    sizes += [f"spacing {artefact.spacing_mm:.3f} mm"] if artefact.spacing_mm is not None else []
    form = "D95 of a plane" if artefact.kind == "plane" else "D95"
    form_mm = limits["flatness_d95_mm"] if artefact.kind == "plane" else limits["form_d95_mm"]
    return [
        f"Test body: {', '.join([acceptance.of_what, *sizes])}",
        f"Calibration {report['calibration_sha256'][:12]}; checked {report['made_at']} by footscan {report['version']}",
        "",
        *summary_lines(acceptance)[:-1],
        "",
        f"Limits (internal, no standard's): PS {limits['size_mm']:g} mm; {form} {form_mm:g} mm; SD "
        f"{limits['spacing_mm_per_300']:g} mm per 300 mm; lasers {limits['lasers_apart_mm']:g} mm apart; a sphere's "
        f"cap at least {limits['least_coverage_deg']:g} degrees",
        "PF and F compare at equal N only; D95 decides. N: points; sigma: standard deviation of the residuals.",
        *(f"NOT kept: {word}" for word in acceptance.broken),
        "",
        "Technician: ______________________________    Date: ________________",
    ]


def summary_lines(acceptance: "Acceptance") -> list[str]:
    """The figures in sentences, for the screen and the page."""
    lines: list[str] = []
    for part in acceptance.parts:
        for which, f in part.figures.items():
            size = "" if np.isnan(f.size_error_mm) else f"PS {f.size_error_mm:+.3f}  cap {f.coverage_deg:.0f} deg  "
            form = "F" if np.isnan(f.size_error_mm) else "PF"
            lines.append(
                f"{part.name:9} {which:5}  N {f.points:6d}  {size}{form} {f.form_mm:.3f}  D95 {f.d95_mm:.3f}  "
                f"sigma {f.sigma_mm:.3f} mm"
            )
    for which, error in acceptance.spacing_error_mm.items():
        lines.append(f"spacing   {which:5}  SD {error:+.3f} mm of {acceptance.artefact.spacing_mm:g} mm")
    if acceptance.lasers_apart_mm is not None:
        lines.append(f"right and left laser see it {acceptance.lasers_apart_mm:.3f} mm apart")
    verdict = "accepted" if not acceptance.broken else "NOT accepted: " + "; ".join(acceptance.broken)
    return [*lines, f"{acceptance.of_what}: {verdict} (internal limits, no standard's)"]
