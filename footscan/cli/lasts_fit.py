"""`footscan lasts rank | compare | customise`."""

from pathlib import Path
from typing import Annotated, Literal, cast, get_args

import typer

from footscan.cli.console import STDOUT, print_json, progress_bar
from footscan.cli.records_options import DataOption, JsonOption
from footscan.coordinates import Side
from footscan.errors import InputError
from footscan.records import data_folder
from footscan.shoelast.compare import Comparison, compare, compare_lasts
from footscan.shoelast.custom_last import CustomLast, Smoothing
from footscan.shoelast.customise import CustomSettings, customise
from footscan.shoelast.fairing import MOST_SMOOTH_MM
from footscan.shoelast.foot_pose import InsoleStack
from footscan.shoelast.foot_pose_joints import Freedom, Joints
from footscan.shoelast.last_library import LastLibrary
from footscan.shoelast.pins import Pin
from footscan.shoelast.profile import load_profile
from footscan.shoelast.rank import Ranked, rank, rank_pair
from footscan.workflow.lasts_fit import (
    comparison_json,
    custom_json,
    customise_pair,
    load_foot,
    load_pair,
    pair_ranking_json,
    ranking_json,
    save_custom,
)

_STATED = 0.05
Unit = Literal["mm", "cm", "m", "in"]
FootArgument = Annotated[Path, typer.Argument(metavar="FOOT", help="A foot mesh, or a folder made by process.")]
UnitOption = Annotated[Unit, typer.Option(help="Unit of a mesh file.")]
SideOption = Annotated[Side | None, typer.Option(help="Side of the foot; a folder made by process knows it.")]
ProfileOption = Annotated[str, typer.Option(help="therapeutic, comfort or dress.")]
InsoleOption = Annotated[str, typer.Option(help="Insole in mm at heel, midfoot, ball and toes: 3,3,3,3.")]
JointOption = Annotated[
    list[str] | None, typer.Option(help="ankle, midfoot, mtp or hallux, such as mtp=limited or hallux=fused.")
]


def add_fit_commands(app: typer.Typer) -> None:
    """Register the commands of this file."""
    app.command("rank")(rank_command)
    app.command("compare")(compare_command)
    app.command("customise")(customise_command)


def _library(data: Path | None) -> LastLibrary:
    return LastLibrary(data_folder(data) / "lasts")


def rank_command(
    foot: FootArgument,
    unit: UnitOption = "mm",
    side: SideOption = None,
    profile: ProfileOption = "therapeutic",
    other: Annotated[Path | None, typer.Option(help="The other foot: lasts are ranked for both together.")] = None,
    style: Annotated[str | None, typer.Option(help="Only this style.")] = None,
    most: Annotated[int, typer.Option(help="How many are shown; --json prints all.", min=1)] = 15,
    data: DataOption = None,
    json_only: JsonOption = False,
) -> None:
    """Rank the library's lasts for a foot by their dimensions: best first, a lower score is better."""
    load_profile(profile)
    with progress_bar("ranking", quiet=json_only):
        prepared = load_foot(foot, unit, side)
        entries = [entry for entry in _library(data).entries() if style in (None, entry.style)]
        if other is None:
            ranking, pairs = rank(entries, prepared, profile), None
        else:
            feet = sorted((prepared, load_foot(other, unit, None)), key=lambda one: one.side)
            ranking, pairs = [], rank_pair(entries, (feet[0], feet[1]), profile)
    if json_only:
        print_json(ranking_json(ranking) if pairs is None else pair_ranking_json(pairs))
        return
    for one in ranking[:most]:
        STDOUT.print(_row(one), soft_wrap=True)
    for pair in (pairs or ())[:most]:
        STDOUT.print(f"{sum(one.score for one in pair):8.3f}  both feet")
        for one in pair:
            STDOUT.print(f"  {_row(one)}", soft_wrap=True)


def _row(one: Ranked) -> str:
    parts = "  ".join(_part(one, name) for name in one.parts)
    return f"{one.score:8.3f}  {one.entry.id:40} {parts}{'  ' + one.reason if one.reason else ''}"


def _part(one: Ranked, name: str) -> str:
    difference = f" {one.differences_mm[name]:+.1f}" if name in one.differences_mm else ""
    return f"{name}{difference} ({one.parts[name]:.2f})"


def compare_command(
    foot: Annotated[Path, typer.Argument(metavar="FOOT", help="A foot mesh, a folder, or the id of another last.")],
    last: Annotated[str, typer.Option("--last", metavar="ID", help="As `footscan lasts list` shows it.")],
    unit: UnitOption = "mm",
    side: SideOption = None,
    profile: ProfileOption = "therapeutic",
    insole: InsoleOption = "3,3,3,3",
    joint: JointOption = None,
    data: DataOption = None,
    json_only: JsonOption = False,
) -> None:
    """Room between foot and last by region, and girths in the same planes; only seen skin counts."""
    library = _library(data)
    with progress_bar("comparing", quiet=json_only):
        shoelast = library.load(last)
        if not foot.exists() and str(foot) in {entry.id for entry in library.entries()}:
            found = compare_lasts(shoelast, library.load(str(foot)))
        else:
            prepared = load_foot(foot, unit, side)
            found = compare(shoelast, prepared, load_profile(profile), _stack(insole), _joints(joint))
    if json_only:
        print_json(comparison_json(found))
        return
    _print_comparison(found)


def _print_comparison(found: Comparison) -> None:
    STDOUT.print("region       least   mean    5 %   95 %   outside  tight  loose  (mm, of seen skin)")
    rooms = [*found.regions.items(), ("plantar", found.plantar), ("unseen", found.unseen)]
    for name, room in rooms:
        if room is not None:
            shares = f"{room.outside_share:8.0%} {room.tight_share:6.0%} {room.loose_share:6.0%}"
            numbers = f"{room.min_mm:7.2f}{room.mean_mm:7.2f}{room.p5_mm:7.2f}{room.p95_mm:7.2f}"
            STDOUT.print(f"{name:10}{numbers} {shares}{'  (decides nothing)' if name == 'unseen' else ''}")
    for name, girth in found.girths.items():
        STDOUT.print(
            f"{name:18} foot {girth.foot_mm:6.1f}  last {girth.last_mm:6.1f}  {girth.last_mm - girth.foot_mm:+.1f}"
        )
    if found.registration is not None:
        lie = found.registration
        STDOUT.print(
            f"room behind the heel {lie.back_mm:.1f} mm, in front of the toes {lie.toe_mm:.1f} mm; "
            f"the foot's ball lies {lie.ball_mm:+.1f} mm from the last's"
        )
    for remark in found.remarks:
        STDOUT.print(f"Remark: {remark}", soft_wrap=True)


def customise_command(
    last: Annotated[str, typer.Option("--last", metavar="ID", help="As `footscan lasts list` shows it.")],
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Folder for the results.")],
    foot: Annotated[
        Path | None, typer.Argument(metavar="FOOT", help="A foot mesh, or a folder made by process.")
    ] = None,
    pair: Annotated[
        tuple[Path, Path] | None, typer.Option(metavar="LEFT RIGHT", help="Both feet: DIR gets left and right.")
    ] = None,
    unit: UnitOption = "mm",
    side: SideOption = None,
    profile: ProfileOption = "therapeutic",
    transition: Annotated[float, typer.Option(help="How far a change reaches, mm.", min=5.0, max=40.0)] = 10.0,
    insole: InsoleOption = "3,3,3,3",
    joint: JointOption = None,
    pin: Annotated[
        list[str] | None, typer.Option(help="Spot allowance x,y,z,radius,mm in the foot file's own coordinates (mm).")
    ] = None,
    girth: Annotated[list[str] | None, typer.Option(help="Wanted girth, such as ball_girth=245.")] = None,
    hold: Annotated[bool, typer.Option(help="Let heel sides, waist and instep lose material.")] = True,
    smooth: Annotated[
        float, typer.Option(help="Smooth the result, moving it by at most so many mm.", min=0.0, max=MOST_SMOOTH_MM)
    ] = 0.0,
    data: DataOption = None,
    json_only: JsonOption = False,
) -> None:
    """Change a last as smoothly as possible so that it holds the foot, and prove that it does."""
    load_profile(profile)
    settings = CustomSettings(
        transition_mm=transition,
        stack=_stack(insole),
        joints=_joints(joint),
        hold=hold,
        pins=tuple(map(_pin, pin or ())),
        girths_mm=dict(map(_girth, girth or ())),
        smooth_mm=smooth,
    )
    if (foot is None) == (pair is None):
        raise InputError("give one FOOT, or both feet with --pair LEFT RIGHT.")
    with progress_bar("customising", quiet=json_only):
        shoelast = _library(data).load(last)
        if pair is None:
            assert foot is not None
            made = {out: customise(shoelast, load_foot(foot, unit, side), profile, settings)}
        else:
            both = customise_pair(shoelast, load_pair(pair, unit), profile, settings)
            made = {out / "left": both[0], out / "right": both[1]}
    if json_only:
        print_json(
            {str(folder): custom_json(custom) for folder, custom in made.items()} if pair else custom_json(made[out])
        )
    for folder, custom in made.items():
        if not json_only:
            _print_custom(folder, custom)
        save_custom(custom, folder)


def _print_custom(folder: Path, custom: CustomLast) -> None:
    proof = custom.proof
    STDOUT.print(
        f"{folder}: {proof.samples} samples of seen skin, worst lack {proof.worst_violation_mm:.3f} mm "
        f"({'holds' if proof.holds else 'DOES NOT HOLD'}); {custom.changed.mean():.0%} of the surface changed, "
        f"{custom.displacement_mm.min():.1f} to {custom.displacement_mm.max():.1f} mm"
    )
    for name, one in custom.held.items():
        mark = "" if one.kept else "  NOT KEPT"
        STDOUT.print(f"held {name:18}{one.before:9.2f} -> {one.after:9.2f} {one.unit}{mark}")
    for name, (before, after, unit) in custom.dimensions.items():
        STDOUT.print(f"{name:23}{before:9.2f} -> {after:9.2f} {unit}")
    smooth = custom.smoothness
    STDOUT.print(
        f"bending energy {smooth.energy:.1f}; largest change of curvature {smooth.curvature_step_per_mm2[0]:.3f} -> "
        f"{smooth.curvature_step_per_mm2[1]:.3f} per mm2; feather edge at most {smooth.feather_deg[0]:.0f} -> "
        f"{smooth.feather_deg[1]:.0f} degrees; beyond the transition at most {custom.outside_mm:.4f} mm moved"
    )
    if custom.smoothing is not None:
        _print_smoothing(custom.smoothing, custom)
    if custom.widening_mm > 0.0:
        STDOUT.print(f"The bottom was widened by up to {custom.widening_mm:.1f} mm.")
    for text in (*(f"Not met: {one}" for one in custom.unmet), *(f"Remark: {one}" for one in custom.remarks)):
        STDOUT.print(text, soft_wrap=True)


def _print_smoothing(smoothing: Smoothing, custom: CustomLast) -> None:
    """Before and after smoothing; the proof above is about the smoothed last."""
    before, after = smoothing.before, custom.smoothness
    STDOUT.print(
        f"Smoothed within {smoothing.limit_mm:g} mm (moved by at most {smoothing.most_mm:.2f}): change of bends "
        f"{smoothing.variation[0]:.2f} -> {smoothing.variation[1]:.2f}, bending energy {before.energy:.1f} -> "
        f"{after.energy:.1f}, largest change of curvature {before.curvature_step_per_mm2[1]:.3f} -> "
        f"{after.curvature_step_per_mm2[1]:.3f} per mm2"
    )
    changed = [
        f"{name} {old:.1f} -> {new:.1f} {unit}"
        for name, (old, new, unit) in smoothing.dimensions.items()
        if abs(new - old) >= _STATED
    ]
    STDOUT.print(f"By smoothing: {', '.join(changed) or 'no dimension changed by 0.05'}", soft_wrap=True)


def _stack(text: str) -> InsoleStack:
    numbers = _numbers(text, 4, "--insole heel,midfoot,ball,toes")
    if min(numbers) < 0.0 or max(numbers) > 30.0:
        raise InputError(f"an insole of {text} mm was asked for, allowed are 0 to 30 mm.")
    return InsoleStack(*numbers)


def _joints(said: list[str] | None) -> Joints:
    chosen: dict[str, Freedom] = {}
    for text in said or ():
        name, _, freedom = text.partition("=")
        if name not in ("ankle", "midfoot", "mtp", "hallux") or freedom not in get_args(Freedom):
            raise InputError(f"joint {text!r}: give ankle, midfoot, mtp or hallux = free, limited or fused.")
        chosen[name] = cast("Freedom", freedom)
    return Joints(**chosen)


def _pin(text: str) -> Pin:
    x, y, z, radius, extra = _numbers(text, 5, "--pin x,y,z,radius,mm")
    return Pin((x, y, z), radius, extra)


def _girth(text: str) -> tuple[str, float]:
    name, _, value = text.partition("=")
    return name, _numbers(value, 1, "--girth name=mm")[0]


def _numbers(text: str, count: int, usage: str) -> list[float]:
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) != count:
        raise InputError(f"{text!r}: {usage} needs {count} numbers separated by commas.")
    return numbers
