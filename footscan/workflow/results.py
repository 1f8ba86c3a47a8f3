"""What a processed scan leaves in its folder; every file is there whole or not at all."""

import json
from pathlib import Path
from typing import Any

from footscan.config.toml_file import write_whole
from footscan.scanning.point_file import save_points
from footscan.workflow.preview import save_preview
from footscan.workflow.process import ProcessSettings, ScanResult, Stages, scan_report


def save_results(result: ScanResult, settings: ProcessSettings, folder: Path) -> dict[str, Any]:
    """Write points.ply, matrix.npz, preview.png and scan.json; returns the content of scan.json.

    Raises:
        StorageError: The folder cannot be written; files written before stay whole.
    """
    stages = Stages()
    with stages.stage("points.ply"):
        save_points(result.cloud, folder / "points.ply", "footscan, mm, world coordinates, laser 0 right 1 left")
    with stages.stage("matrix.npz"):
        result.sweep.matrix.save(folder / "matrix.npz")
    with stages.stage("preview.png"):
        save_preview(result, folder / "preview.png")
    report = scan_report(result, settings)
    report["seconds"] = result.seconds | stages.seconds
    write_whole(folder / "scan.json", (json.dumps(report, indent=1) + "\n").encode())
    return report
