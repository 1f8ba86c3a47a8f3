"""`footscan study lasts`: deformed feet, each against its best last."""

import tempfile
from pathlib import Path
from typing import Annotated

import typer

from footscan.cli.console import STDERR, STDOUT, print_json
from footscan.errors import QualityError
from footscan.shoelast.customise import CustomSettings
from footscan.shoelast.last_library import LastLibrary
from footscan.workflow.lasts_study import StudyOutcome, lasts_study_cases, outcome_json, run_lasts_study


def study_lasts(
    feet: Annotated[int, typer.Option(help="How many deformed feet.", min=1, max=1000)] = 50,
    first: Annotated[int, typer.Option(help="Number of the first of them, to look at all in pieces.", min=0)] = 0,
    seed: Annotated[int, typer.Option(help="Of feet and deformities.", min=0, max=10**6)] = 0,
    transition: Annotated[float, typer.Option(help="Transition length, mm.", min=5.0, max=40.0)] = 10.0,
    json_only: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Hallux valgus, high instep, bunion, oedema, claw toes: does the customised last hold every foot?"""
    outcomes: list[StudyOutcome] = []
    with tempfile.TemporaryDirectory(prefix="footscan-lasts-") as folder:
        library, settings = LastLibrary(Path(folder)), CustomSettings(transition_mm=transition)
        for outcome in run_lasts_study(lasts_study_cases(first + feet, seed)[first:], library, settings):
            outcomes.append(outcome)
            if not json_only:
                STDERR.print(_row(outcome))
    well = sum(outcome.well for outcome in outcomes)
    if json_only:
        print_json({"feet": [outcome_json(outcome) for outcome in outcomes], "held": well})
    else:
        worst = max((one.custom.proof.worst_violation_mm for one in outcomes if one.custom), default=float("nan"))
        STDOUT.print(
            f"{well} of {len(outcomes)} feet held by their customised last; worst lack {worst:.3f} mm (limit 0.05)"
        )
    if well < len(outcomes):
        raise QualityError(
            f"{len(outcomes) - well} of {len(outcomes)} deformed feet are not held by a customised last."
        )


def _row(outcome: StudyOutcome) -> str:
    case, custom = outcome.case, outcome.custom
    head = (
        f"{case.seed:4} {case.side:5} size {case.size:.2f} {case.deformity:14} {case.amount:.2f}  {outcome.last_id:42}"
    )
    if custom is None:
        return f"{head} REFUSED: {outcome.reason}"
    proof = custom.proof
    mark = "" if proof.holds else "  DOES NOT HOLD"
    return (
        f"{head} lack {proof.worst_violation_mm:7.3f} of {proof.samples}, out {custom.displacement_mm.max():5.1f} mm "
        f"({custom.overshoot_mm:.1f} more than asked near), "
        f"bottom +{custom.widening_mm:.1f} mm, {custom.rounds} rounds, moved beyond {custom.outside_mm:.4f} mm, "
        f"curvature step {custom.smoothness.curvature_step_per_mm2[1]:.2f} per mm2{mark}"
    )
