"""`footscan study ranking`: feet scaled up and down, and whether the first of the ranking follows the size rule."""

from pathlib import Path
from typing import Annotated, Any, Literal

import trimesh
import typer

from footscan.cli.console import STDERR, STDOUT, print_json
from footscan.coordinates import Side
from footscan.errors import InputError, QualityError
from footscan.foot.mesh_file import load_foot_mesh
from footscan.shoelast.last_library import family_entries
from footscan.workflow.lasts_ranking_study import (
    MOST_SIZES,
    MOST_WIDTHS,
    SCALES,
    RankingOutcome,
    run_ranking_study,
)
from footscan.workflow.stored_foot import stored_subject


def study_ranking(
    feet: Annotated[list[Path], typer.Argument(metavar="FOOT...", help="Foot meshes, or folders made by process.")],
    unit: Annotated[Literal["mm", "cm", "m", "in"], typer.Option(help="Unit of mesh files.")] = "mm",
    profile: Annotated[str, typer.Option(help="therapeutic, comfort or dress.")] = "therapeutic",
    scale: Annotated[list[float] | None, typer.Option(help="Times its size; may be repeated.")] = None,
    json_only: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Is the first last of each foot within half a size and one width of the size rule, and are wrong ones behind?"""
    scales = tuple(scale or SCALES)
    if not all(0.5 <= one <= 2.0 for one in scales):
        raise InputError(f"scales are 0.5 to 2, found {', '.join(f'{one:g}' for one in scales)}.")
    loaded: list[tuple[str, trimesh.Trimesh, Side | None]] = [
        (place.name, load_foot_mesh(place, unit), stored_subject(place).side) for place in feet
    ]
    outcomes: list[RankingOutcome] = []
    for outcome in run_ranking_study(loaded, list(family_entries()), scales, profile):
        outcomes.append(outcome)
        if not json_only:
            STDERR.print(_row(outcome), soft_wrap=True)
    well = sum(outcome.well for outcome in outcomes)
    if json_only:
        print_json({"feet": [_outcome_json(outcome) for outcome in outcomes], "well": well})
    else:
        STDOUT.print(
            f"{well} of {len(outcomes)} rankings begin within {MOST_SIZES:g} sizes and {MOST_WIDTHS:g} width of the "
            "size rule, with wrong lasts in the worse half"
        )
    if well < len(outcomes):
        raise QualityError(
            f"{len(outcomes) - well} of {len(outcomes)} rankings begin with a last beside the size rule."
        )


def _row(outcome: RankingOutcome) -> str:
    return (
        f"{outcome.name:20} x {outcome.scale:.2f} {outcome.side:5} length {outcome.foot_length_mm:5.1f} ball girth "
        f"{outcome.ball_girth_mm:5.1f}  {outcome.first.entry.id:42} {outcome.sizes_off:+.2f} sizes "
        f"{outcome.widths_off:+.2f} widths (best of its size {outcome.narrowest_off:.2f}) "
        f"{outcome.wrong_above_median} wrong above the median{'' if outcome.well else '  NOT AS THE RULE SAYS'}"
    )


def _outcome_json(outcome: RankingOutcome) -> dict[str, Any]:
    first = outcome.first
    return {
        **{name: value for name, value in vars(outcome).items() if name != "first"},
        "first": first.entry.id,
        "score": first.score,
        "differences_mm": dict(first.differences_mm),
        "well": outcome.well,
    }
