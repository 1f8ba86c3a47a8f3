"""What a processed scan leaves in its folder; every file is there whole or not at all."""

import json
from pathlib import Path
from typing import Any

from footscan.config.toml_file import write_whole
from footscan.coordinates import Side
from footscan.errors import EmptyScanError, FootscanError, MeshError, QualityError, StorageError
from footscan.scanning.point_file import save_bare_board, save_points
from footscan.workflow.foot import foot_report, measure_scan, save_foot
from footscan.workflow.lasts_scan import LAST_REMARKS, last_report, save_last, scanned_last
from footscan.workflow.on_wedge import wedge_report
from footscan.workflow.preview import save_preview
from footscan.workflow.process import ProcessSettings, ScanResult, Stages, known_subject, scan_report, scan_verdict
from footscan.workflow.texture import save_texture
from footscan.workflow.verdict import verdict_lines, verdict_report

FOOT_FILES = (
    "surface.stl",
    "surface.ply",
    "surface.json",
    "measurements.json",
    "report.png",
    "sections.csv",
    "sections.dxf",
    "texture.ply",
)
LEAST_SEEN, USUALLY_SEEN = 0.1, 0.4
_SECOND_BODY = 0.1  # of the foot's points; specks and reflections are less
RESULT_FILES = ("points.ply", "board.npy", "matrix.npz", "preview.png", "scan.json", *FOOT_FILES)


def save_results(result: ScanResult, settings: ProcessSettings, folder: Path) -> dict[str, Any]:
    """Write points.ply, matrix.npz, preview.png, of a foot surface.*, measurements.json and report.png, and scan.json.

    Returns:
        The content of scan.json.

    Raises:
        StorageError: The folder cannot be written; files written before stay whole.
        MeshError: The points are no foot that can be measured; points, pictures and scan.json are there all the same.
        QualityError: Too little skin was seen; the same holds.
    """
    _remove_old(folder)
    stages = Stages()
    with stages.stage("points.ply"):
        save_points(result.cloud, folder / "points.ply", "footscan, mm, world coordinates, laser 0 right 1 left")
        save_bare_board(result.xy_board, folder / "board.npy")
    with stages.stage("matrix.npz"):
        result.sweep.matrix.save(folder / "matrix.npz")
    with stages.stage("preview.png"):
        save_preview(result, folder / "preview.png")
    report = scan_report(result, settings)
    if settings.kind == "last":
        refusal = _add_last(result, folder, report, stages)
    else:
        refusal = _add_foot(result, settings, folder, report, stages)
    report["seconds"] = result.seconds | stages.seconds
    write_whole(folder / "scan.json", (json.dumps(report, indent=1) + "\n").encode())
    if refusal is not None:
        raise refusal
    return report


def check_alone(result: ScanResult) -> None:
    """Refuse a scan in which a second body of some size was taken away as not belonging to the foot.

    Raises:
        MeshError: Saying how much of the skin it is.
    """
    other = result.removed["other body"]
    if other > _SECOND_BODY * len(result.cloud):
        raise MeshError(
            f"a second body stands apart from the foot ({other} points beside {len(result.cloud)}): two feet, or "
            "something else on the board? One foot at a time can be measured; remove the other and scan again."
        )


def _remove_old(folder: Path) -> None:
    """Take away what an earlier run left here: results of two scans must never lie side by side."""
    try:
        for name in RESULT_FILES:
            (folder / name).unlink(missing_ok=True)
    except OSError as err:
        raise StorageError(f"{folder} cannot be used for results ({err.strerror}); choose another place.") from err


def _add_last(result: ScanResult, folder: Path, report: dict[str, Any], stages: Stages) -> FootscanError | None:
    """Close and save the skin of a last; a refusal is noted in the report and returned."""
    try:
        with stages.stage("surface"):
            surface, mesh = scanned_last(result.cloud)
    except (MeshError, EmptyScanError) as refusal:
        report["last"] = {"refused": str(refusal)}
        return refusal
    report["last"] = last_report(surface, mesh)
    report["remarks"] += LAST_REMARKS
    with stages.stage("surface files"):
        save_last(surface, mesh, folder)
    return None


def _add_foot(
    result: ScanResult, settings: ProcessSettings, folder: Path, report: dict[str, Any], stages: Stages
) -> FootscanError | None:
    """Fit, measure and save the foot; a refusal is noted in the report and returned."""
    info = result.recording.info
    side: Side | None = settings.side or (None if info.side == "none" else info.side)
    subject = known_subject(result, settings)
    try:
        check_alone(result)
        if result.ground.refusal is not None:
            raise result.ground.refusal
        with stages.stage("surface and measurements"):
            place = settings.landmarks, result.xy_board, result.ground.wedge
            foot = measure_scan(result.cloud, side, subject, settings.foot, *place)
    except (MeshError, EmptyScanError) as refusal:
        report["foot"] = {"refused": str(refusal)}
        return refusal
    report["foot"] = foot_report(foot)
    report["wedge"] = wedge_report(foot.measurements.wedge)
    verdict = scan_verdict(result, foot)
    report["verdict"] = verdict_report(verdict)
    seen = report["foot"]["skin"]["seen"]
    if seen < LEAST_SEEN:
        refusal = QualityError(
            f"only {seen:.0%} of the skin was seen, at least {LEAST_SEEN:.0%} make a foot that can be measured; "
            "look at scan.json for rejected frames, and scan again."
        )
        report["foot"]["refused"] = str(refusal)
        return refusal
    if seen < USUALLY_SEEN:
        report["remarks"].append(f"only {seen:.0%} of the skin was seen, usual are 60 %: take more frames per turn")
    with stages.stage("surface files and report.png"):
        save_foot(foot, folder, result.recording.folder.name, verdict_lines(verdict, result.motion))
    with stages.stage("texture"):
        report["foot"]["texture"] = save_texture(result, foot.mesh, folder / "texture.ply")
    return None
