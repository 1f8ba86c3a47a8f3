"""`footscan lasts rank | compare`."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from footscan.cli.console import STDOUT, print_json, progress_bar
from footscan.cli.lasts_library import opened_library
from footscan.cli.lasts_wishes import joints_from_texts, stack_from_text
from footscan.cli.records_options import DataOption, JsonOption
from footscan.coordinates import Side
from footscan.shoelast.compare import Comparison, compare, compare_lasts
from footscan.shoelast.pair_rank import rank_pair
from footscan.shoelast.profile import load_profile
from footscan.shoelast.rank import Ranked, rank
from footscan.workflow.lasts_fit import comparison_json, load_foot, ranking_json
from footscan.workflow.lasts_pair import pair_ranking_json

Unit = Literal["mm", "cm", "m", "in"]
FootArgument = Annotated[Path, typer.Argument(metavar="FOOT", help="A foot mesh, or a folder made by process.")]
UnitOption = Annotated[Unit, typer.Option(help="Unit of a mesh file.")]
SideOption = Annotated[Side | None, typer.Option(help="Side of the foot; a folder made by process knows it.")]
ProfileOption = Annotated[str, typer.Option(help="therapeutic, comfort or dress.")]
InsoleOption = Annotated[str, typer.Option(help="Insole in mm at heel, midfoot, ball and toes: 3,3,3,3.")]
WedgeOption = Annotated[
    float | None, typer.Option(help="Height in mm of the wedge under the heel in the scan; a folder knows it.")
]
JointOption = Annotated[
    list[str] | None, typer.Option(help="ankle, midfoot, mtp or hallux, such as mtp=limited or hallux=fused.")
]


def add_fit_commands(app: typer.Typer) -> None:
    """Register the commands of this file."""
    app.command("rank")(rank_command)
    app.command("compare")(compare_command)


def rank_command(
    foot: FootArgument,
    unit: UnitOption = "mm",
    side: SideOption = None,
    wedge: WedgeOption = None,
    profile: ProfileOption = "therapeutic",
    other: Annotated[Path | None, typer.Option(help="The other foot: pairs of lasts are ranked for both.")] = None,
    style: Annotated[str | None, typer.Option(help="Only this style.")] = None,
    most: Annotated[int, typer.Option(help="How many are shown; --json prints all.", min=1)] = 15,
    data: DataOption = None,
    json_only: JsonOption = False,
) -> None:
    """Rank the library's lasts for a foot by their dimensions: best first, a lower score is better."""
    load_profile(profile)
    with progress_bar("ranking", quiet=json_only):
        prepared = load_foot(foot, unit, side, wedge)
        entries = [entry for entry in opened_library(data).entries() if style in (None, entry.style)]
        if other is None:
            ranking, pairs = rank(entries, prepared, profile), None
        else:
            feet = sorted((prepared, load_foot(other, unit, None, wedge)), key=lambda one: one.side)
            ranking, pairs = [], rank_pair(entries, (feet[0], feet[1]), profile)
    if json_only:
        print_json(ranking_json(ranking) if pairs is None else pair_ranking_json(pairs))
        return
    for one in ranking[:most]:
        STDOUT.print(_row(one), soft_wrap=True)
    for pair in (pairs or ())[:most]:
        word = "alike" if pair.alike else f"unlike, which costs {pair.cost:g}"
        STDOUT.print(f"{pair.score:8.3f}  both feet, {word}")
        for one in (pair.left, pair.right):
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
    wedge: WedgeOption = None,
    profile: ProfileOption = "therapeutic",
    insole: InsoleOption = "3,3,3,3",
    joint: JointOption = None,
    data: DataOption = None,
    json_only: JsonOption = False,
) -> None:
    """Room between foot and last by region, and girths in the same planes; only seen skin counts."""
    library = opened_library(data)
    with progress_bar("comparing", quiet=json_only):
        shoelast = library.load(last)
        if not foot.exists() and str(foot) in {entry.id for entry in library.entries()}:
            found = compare_lasts(shoelast, library.load(str(foot)))
        else:
            prepared = load_foot(foot, unit, side, wedge)
            found = compare(
                shoelast, prepared, load_profile(profile), stack_from_text(insole), joints_from_texts(joint)
            )
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
