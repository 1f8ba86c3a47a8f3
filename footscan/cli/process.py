"""`footscan process`."""

from pathlib import Path
from typing import Annotated, Any

import typer

from footscan.cli.console import STDOUT, print_json, progress_bar
from footscan.config import load_calibration
from footscan.config.recording_file import Load
from footscan.config.recording_file import Surface as CoverKind
from footscan.coordinates import Side
from footscan.scanning.filters import FilterKind, FilterSettings
from footscan.scanning.recording import open_recording
from footscan.scanning.sweep import SweepSettings
from footscan.workflow.foot import FootSettings
from footscan.workflow.process import ObjectKind, ProcessSettings, process_recording
from footscan.workflow.results import save_results


def parse_threshold(text: str) -> int | None:
    """`auto` or a grey value from 0 to 255.

    Raises:
        typer.BadParameter: Anything else.
    """
    if text == "auto":
        return None
    if text.isdecimal() and 0 <= int(text) <= 255:
        return int(text)
    raise typer.BadParameter(f"the threshold is {text!r}; allowed are auto or a grey value from 0 to 255.")


def process(
    recording: Annotated[Path, typer.Argument(help="Folder of a scan recording.")],
    calibration: Annotated[Path, typer.Option(help="calibration.toml of the machine.")],
    out: Annotated[Path, typer.Option(help="Folder for the results; made if it does not exist.")],
    threshold: Annotated[str, typer.Option(help="auto, or a grey value: a pixel counts when above it.")] = "auto",
    picture_filter: Annotated[
        FilterKind, typer.Option("--filter", help="Filter on the pictures before the stripe is looked for.")
    ] = "off",
    filter_size: Annotated[int, typer.Option(help="Median filter: 3 or 5 px.")] = 3,
    filter_sigma: Annotated[float, typer.Option(help="Gaussian filter: 0.3 to 3 px.")] = 0.8,
    side: Annotated[Side | None, typer.Option(help="Side of the foot; default: the recording's.")] = None,
    load: Annotated[Load | None, typer.Option(help="Load on the foot; default: the recording's.")] = None,
    surface: Annotated[CoverKind | None, typer.Option(help="What covers the skin; default: the recording's.")] = None,
    wedge: Annotated[
        float | None,
        typer.Option(help="Height in mm of the wedge under the middle of the heel; default: the recording's."),
    ] = None,
    cloud_filter: Annotated[float, typer.Option(help="Numerical filtering of the points, 0 (off) to 1.")] = 0.0,
    smooth: Annotated[float, typer.Option(help="Geometrical smoothing of the foot, mm, 0 is off.")] = 0.0,
    kind: Annotated[ObjectKind, typer.Option("--object", help="What stands on the board.")] = "foot",
    one_laser: Annotated[
        bool, typer.Option("--one-laser", help="Accept a scan of which one laser is missing.")
    ] = False,
    json_only: Annotated[bool, typer.Option("--json", help="Print scan.json and nothing else.")] = False,
) -> None:
    """Turn a recording into a measured foot: points, closed surface, measurements, pictures."""
    sweep = SweepSettings(parse_threshold(threshold), FilterSettings(picture_filter, filter_size, filter_sigma))
    settings = ProcessSettings(
        sweep, kind, side, one_laser, load, surface, FootSettings(cloud_filter, smooth), wedge_mm=wedge
    )
    machine = load_calibration(calibration)
    with progress_bar("frames", quiet=json_only) as progress:
        result = process_recording(open_recording(recording), machine, settings, progress)
        report = save_results(result, settings, out)
    if json_only:
        print_json(report)
    else:
        tell_results(report, out)


def tell_results(report: dict[str, Any], out: Path) -> None:
    """The result in a few lines, for people."""
    frames, points = report["frames"], report["points"]
    rejected = "".join(f", {count} rejected: {reason}" for reason, count in frames["rejected"].items())
    STDOUT.print(f"{frames['seen']} frames, {frames['used']} used{rejected}; threshold {report['threshold']}")
    STDOUT.print(f"{points['kept']} points kept ({points['kept_right']} right laser, {points['kept_left']} left laser)")
    for zone in report["agreement"]:
        if zone["median_mm"] is not None:
            STDOUT.print(
                f"  {zone['zone']:8} right minus left {zone['median_mm']:+.3f} mm median, "
                f"{zone['rms_mm']:.3f} mm RMS over {zone['overlap_area_mm2'] / 100:.0f} cm2"
            )
    _tell_verdict(report["verdict"], report["motion"])
    for remark in report["remarks"]:
        STDOUT.print(f"Remark: {remark}")
    if "foot" in report:
        _tell_foot(report["foot"])
    first = "report.png" if "foot" in report else "preview.png"
    STDOUT.print(f"Results in {out}, start with {first} ({sum(report['seconds'].values()):.1f} s)")


def _tell_verdict(verdict: dict[str, Any], motion: dict[str, Any]) -> None:
    for zone in motion["zones"]:
        if zone["moved"] is None:
            STDOUT.print(f"  {zone['zone']:8} motion not judged")
        else:
            size, sigma = zone["displacement_mm"], zone["sigma_mm"]
            STDOUT.print(f"  {zone['zone']:8} {'MOVED' if zone['moved'] else 'still'}: {size:.2f} mm (+- {sigma:.2f})")
    STDOUT.print(f"Verdict: {verdict['grade']}: {verdict['finding']}")
    if verdict["kind"] != "none":
        STDOUT.print(f"  Do: {verdict['action']}")
    if verdict["spoiled"]:
        STDOUT.print(f"  Do not use: {', '.join(verdict['spoiled'])}")


def _tell_foot(foot: dict[str, Any]) -> None:
    skin = ", ".join(f"{100 * share:.0f} % {kind.replace('_', ' ')}" for kind, share in foot["skin"].items())
    STDOUT.print(f"Foot: {foot['volume_cm3']:.0f} cm3 up to {foot['cut_height_mm']:.0f} mm, skin {skin}")
    price = foot["filtering_and_smoothing"]
    for name, before in price.get("before", {}).items():
        after = price["after"].get(name, before)
        STDOUT.print(f"  {name:18} {before:10.3f} before, {after:10.3f} after filtering and smoothing")
    for question in foot["questions"]:
        STDOUT.print(f"Question: {question}")
