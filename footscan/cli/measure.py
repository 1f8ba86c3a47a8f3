"""`footscan measure` and `footscan section`."""

from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import typer

from footscan.cli.console import STDOUT, print_json, progress_bar
from footscan.coordinates import Floats, Side
from footscan.foot.measurements import Measurement, measure, measurements_json
from footscan.foot.mesh_file import load_foot_mesh
from footscan.foot.repair import repair_mesh
from footscan.foot.sections import section
from footscan.foot.units import check_foot_length
from footscan.workflow.stored_foot import stored_subject

Unit = Literal["mm", "cm", "m", "in"]
Axis = Literal["A1", "A2", "A4", "A5"]
WedgeOption = Annotated[
    float | None,
    typer.Option(help="Height in mm of the wedge under the middle of the heel; a folder made by process knows it."),
]


def measure_command(
    foot: Annotated[Path, typer.Argument(metavar="MESH_OR_DIR", help="A foot mesh, or a folder made by process.")],
    unit: Annotated[Unit, typer.Option(help="Unit of the mesh.")] = "mm",
    side: Annotated[Side | None, typer.Option(help="Side of the foot; without it the shape decides and asks.")] = None,
    axis: Annotated[Axis, typer.Option(help="Foot axis: A2 heel to mid-ball, A1, A4, A5.")] = "A2",
    wedge: WedgeOption = None,
    json_only: Annotated[bool, typer.Option("--json", help="Print measurements.json and nothing else.")] = False,
) -> None:
    """Measure any foot mesh: lengths, breadths, tape girths with intervals, heights, angles."""
    known = stored_subject(foot)
    with progress_bar("measuring", quiet=json_only):
        mesh = load_foot_mesh(foot, unit)
        under = known.wedge if wedge is None else wedge
        result = measure(mesh, side or known.side, axis=axis, load=known.load, absent=known.absent, wedge=under)
    if json_only:
        print_json(measurements_json(result))
        return
    STDOUT.print(f"{result.side} foot, axis {result.axis}, load {result.load}")
    for name, value in result.measurements.items():
        STDOUT.print(_row(name, value), soft_wrap=True)
    for remark in (*result.questions, *result.remarks):
        STDOUT.print(f"Remark: {remark}", soft_wrap=True)


def _row(name: str, value: Measurement) -> str:
    number = "-" if value.value is None else f"{value.value:.2f}"
    interval = "" if value.interval is None else f"{value.interval[0]:.1f} .. {value.interval[1]:.1f}"
    mark = "" if value.reliable else "not reliable: "
    unusual = f" (unusual: {value.unusual})" if value.unusual else ""
    return f"{name:28}{number:>9} {value.unit:4}{interval:>18}  {mark}{value.reason}{unusual}"


def parse_triple(text: str, name: str) -> Floats:
    """Three numbers with commas between them.

    Raises:
        typer.BadParameter: Anything else.
    """
    try:
        values = np.array([float(part) for part in text.split(",")])
    except ValueError:
        values = np.empty(0)
    if values.shape != (3,) or not np.isfinite(values).all():
        raise typer.BadParameter(f"{name} is {text!r}; three numbers x,y,z are needed, such as 0,0,50.")
    return values


def section_command(
    foot: Annotated[Path, typer.Argument(metavar="MESH_OR_DIR", help="A foot mesh, or a folder made by process.")],
    origin: Annotated[str, typer.Option(help="A point of the plane, x,y,z in mm.")],
    normal: Annotated[str, typer.Option(help="Its normal, x,y,z, any length.")],
    unit: Annotated[Unit, typer.Option(help="Unit of the mesh.")] = "mm",
    json_only: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Cut a foot by a plane: area, perimeter, tape girth, width, height, and the share never seen."""
    point, direction = parse_triple(origin, "--origin"), parse_triple(normal, "--normal")
    with progress_bar("cutting", quiet=json_only):
        whole = repair_mesh(load_foot_mesh(foot, unit))
        check_foot_length(float(np.ptp(whole.mesh.vertices, axis=0)[:2].max()), unit)
        cut = section(whole.mesh, point, direction)
    content: dict[str, Any] = {
        "area_mm2": cut.area_mm2,
        "perimeter_mm": cut.perimeter_mm,
        "hull_perimeter_mm": cut.hull_perimeter_mm,
        "width_mm": cut.width_mm,
        "height_mm": cut.height_mm,
        "unseen_share": cut.unseen_share,
        "hull_unseen_share": cut.hull_unseen_share,
        "centroid_mm": [float(x) for x in cut.centroid],
        "closed": cut.closed,
        "curves": len(cut.polylines),
        "remarks": list(whole.remarks),
    }
    if json_only:
        print_json(content)
        return
    for name, value in content.items():
        if name != "remarks":
            STDOUT.print(f"{name:20} {'unknown' if value is None else value}")
    for remark in whole.remarks:
        STDOUT.print(f"Remark: {remark}")
