"""`footscan lasts customise`: one last, or both of a pair."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

import typer

from footscan.cli.console import STDOUT, print_json, progress_bar
from footscan.cli.lasts_fit import InsoleOption, JointOption, ProfileOption, SideOption, UnitOption, WedgeOption
from footscan.cli.lasts_library import opened_library
from footscan.cli.lasts_wishes import (
    check_sides,
    girth_from_text,
    joints_from_texts,
    of_side,
    pin_from_text,
    stack_from_text,
)
from footscan.cli.records_options import DataOption, JsonOption
from footscan.errors import InputError
from footscan.shoelast.custom_last import CustomLast, Smoothing
from footscan.shoelast.customise import CustomSettings, customise
from footscan.shoelast.fairing import MOST_SMOOTH_MM
from footscan.shoelast.last_library import LastLibrary
from footscan.shoelast.model import Shoelast
from footscan.shoelast.prepared_foot import PreparedFoot
from footscan.shoelast.profile import load_profile
from footscan.workflow.lasts_fit import custom_json, load_foot, save_custom
from footscan.workflow.lasts_pair import (
    SIDES,
    CustomPair,
    choose_pair,
    customise_pair,
    load_pair,
    pair_json,
    save_pair,
)

_STATED = 0.05


def add_customise_command(app: typer.Typer) -> None:
    """Register the command of this file."""
    app.command("customise")(customise_command)


def customise_command(
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Folder for the results.")],
    last: Annotated[
        str | None,
        typer.Option("--last", metavar="ID", help="As `footscan lasts list` shows it; with --pair for both feet."),
    ] = None,
    foot: Annotated[
        Path | None, typer.Argument(metavar="FOOT", help="A foot mesh, or a folder made by process.")
    ] = None,
    pair: Annotated[
        tuple[Path, Path] | None,
        typer.Option(
            metavar="LEFT RIGHT", help="Both feet: DIR gets left and right. Without --last the best two are taken."
        ),
    ] = None,
    last_right: Annotated[
        str | None, typer.Option(metavar="ID", help="With --pair: the right foot's last; --last is then the left's.")
    ] = None,
    style: Annotated[str | None, typer.Option(help="With --pair and without --last: only this style.")] = None,
    unit: UnitOption = "mm",
    side: SideOption = None,
    wedge: WedgeOption = None,
    profile: ProfileOption = "therapeutic",
    transition: Annotated[float, typer.Option(help="How far a change reaches, mm.", min=5.0, max=40.0)] = 10.0,
    insole: InsoleOption = "3,3,3,3",
    joint: JointOption = None,
    pin: Annotated[
        list[str] | None,
        typer.Option(
            help="Spot allowance x,y,z,radius,mm in the foot file's own coordinates (mm); with --pair left:x,... or "
            "right:x,..."
        ),
    ] = None,
    girth: Annotated[
        list[str] | None, typer.Option(help="Wanted girth, such as ball_girth=245; with --pair also left:ball_...")
    ] = None,
    hold: Annotated[bool, typer.Option(help="Let heel sides, waist and instep lose material.")] = True,
    smooth: Annotated[
        float, typer.Option(help="Smooth the result, moving it by at most so many mm.", min=0.0, max=MOST_SMOOTH_MM)
    ] = 0.0,
    data: DataOption = None,
    json_only: JsonOption = False,
) -> None:
    """Change a last as smoothly as possible so that it holds the foot, and prove that it does."""
    load_profile(profile)
    plain = CustomSettings(
        transition_mm=transition,
        stack=stack_from_text(insole),
        joints=joints_from_texts(joint),
        hold=hold,
        smooth_mm=smooth,
    )
    lasts = LastsAsked(opened_library(data), last, last_right, style)
    if pair is not None and foot is None and side is None:
        settings = _settings_of_both(plain, pin, girth)
        with progress_bar("customising", quiet=json_only):
            feet = load_pair(pair, unit)
            both = customise_pair(lasts.of_both(feet, profile), feet, profile, settings)
        _tell_pair(both, out, json_only=json_only)
    elif pair is None and foot is not None and lasts.is_one:
        wishes = replace(plain, pins=tuple(map(pin_from_text, pin or ())), girths_mm=_girths(girth or ()))
        with progress_bar("customising", quiet=json_only):
            made = customise(lasts.one(), load_foot(foot, unit, side), profile, wishes)
        _tell_one(made, out, json_only=json_only)
    else:
        raise InputError(_USAGE)


_USAGE = (
    "give one FOOT with its --last, or both feet with --pair LEFT RIGHT (with --last for both, with --last and "
    "--last-right, or with neither: the best pair, of one --style if you wish)."
)


@dataclass(frozen=True)
class LastsAsked:
    """Which lasts were asked for, by name or by style."""

    stock: LastLibrary
    last: str | None
    last_right: str | None
    style: str | None

    @property
    def is_one(self) -> bool:
        """Whether one last was named and nothing else."""
        return self.last is not None and self.last_right is None and self.style is None

    def one(self) -> Shoelast:
        """The last that was named."""
        if self.last is None:
            raise InputError(_USAGE)
        return self.stock.load(self.last)

    def of_both(self, feet: tuple[PreparedFoot, PreparedFoot], profile: str) -> tuple[Shoelast, Shoelast]:
        """The lasts that were named, or the best two."""
        if self.last is None and self.last_right is None:
            return choose_pair(self.stock, feet, profile, self.style)
        if self.last is None or self.style is not None:
            raise InputError(
                "--last-right needs --last for the left foot, and --style needs neither: name both, or none."
            )
        left = self.one()
        return left, left if self.last_right is None else self.stock.load(self.last_right)


def _settings_of_both(
    plain: CustomSettings, pin: list[str] | None, girth: list[str] | None
) -> tuple[CustomSettings, CustomSettings]:
    check_sides(pin, each_needs_one=True)
    check_sides(girth, each_needs_one=False)
    left, right = (
        replace(plain, pins=tuple(map(pin_from_text, of_side(pin, side))), girths_mm=_girths(of_side(girth, side)))
        for side in SIDES
    )
    return left, right


def _girths(said: Sequence[str]) -> dict[str, float]:
    return dict(map(girth_from_text, said))


def _tell_one(custom: CustomLast, out: Path, *, json_only: bool) -> None:
    if json_only:
        print_json(custom_json(custom))
    else:
        _print_custom(out, custom)
    save_custom(custom, out)


def _tell_pair(pair: CustomPair, out: Path, *, json_only: bool) -> None:
    """Both are written, also when one does not hold its foot."""
    folders = {out / side: custom for side, custom in pair.both}
    if json_only:
        print_json({str(place): custom_json(custom) for place, custom in folders.items()} | {"pair": pair_json(pair)})
    else:
        for place, custom in folders.items():
            _print_custom(place, custom)
        _print_pair(pair)
    save_pair(pair, out)


def _print_pair(pair: CustomPair) -> None:
    for (side, custom), raised in zip(pair.both, pair.cone_raised_mm, strict=True):
        cone = f"; its cone was raised by {raised:.1f} mm" if raised > 0.0 else ""
        STDOUT.print(f"{side:5} {custom.original.name}{cone}", soft_wrap=True)
    for name, one in pair.agreements.items():
        limit = "stated only" if one.limit is None else f"at most {one.limit:g} {one.unit} apart"
        mark = "" if one.kept else "  NOT EQUAL"
        STDOUT.print(f"pair {name:18}{one.left:9.2f} and {one.right:9.2f} {one.unit} ({limit}){mark}")


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
