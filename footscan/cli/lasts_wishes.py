"""What people say on the command line about a last they want, as values."""

from collections.abc import Sequence
from typing import cast, get_args

from footscan.coordinates import Side
from footscan.errors import InputError
from footscan.shoelast.foot_pose import InsoleStack
from footscan.shoelast.foot_pose_joints import Freedom, Joints
from footscan.shoelast.pins import Pin


def of_side(said: Sequence[str] | None, side: Side) -> list[str]:
    """Wishes for one foot of a pair: those that begin with `left:` or `right:` are for that foot alone."""
    parts = [text.rpartition(":") for text in said or ()]
    return [wish for for_side, _, wish in parts if for_side in ("", side)]


def check_sides(said: Sequence[str] | None, *, each_needs_one: bool) -> None:
    """Refuse wishes for a foot that is neither left nor right.

    Raises:
        InputError: Another word before the colon, or none where a place on one foot was named.
    """
    for text in said or ():
        side = text.rpartition(":")[0]
        if side not in ("left", "right") and (side or each_needs_one):
            raise InputError(f"{text!r}: with --pair write left:{text} or right:{text}, the foot it is for.")


def stack_from_text(text: str) -> InsoleStack:
    """An insole from `heel,midfoot,ball,toes`.

    Raises:
        InputError: Not four thicknesses of 0 to 30 mm.
    """
    numbers = _numbers(text, 4, "--insole heel,midfoot,ball,toes")
    if min(numbers) < 0.0 or max(numbers) > 30.0:
        raise InputError(f"an insole of {text} mm was asked for, allowed are 0 to 30 mm.")
    return InsoleStack(*numbers)


def joints_from_texts(said: list[str] | None) -> Joints:
    """Joints from texts such as `mtp=limited`.

    Raises:
        InputError: No such joint, or no such freedom.
    """
    chosen: dict[str, Freedom] = {}
    for text in said or ():
        name, _, freedom = text.partition("=")
        if name not in ("ankle", "midfoot", "mtp", "hallux") or freedom not in get_args(Freedom):
            raise InputError(f"joint {text!r}: give ankle, midfoot, mtp or hallux = free, limited or fused.")
        chosen[name] = cast("Freedom", freedom)
    return Joints(**chosen)


def pin_from_text(text: str) -> Pin:
    """A spot allowance from `x,y,z,radius,mm`.

    Raises:
        InputError: Not five numbers.
    """
    x, y, z, radius, extra = _numbers(text, 5, "--pin x,y,z,radius,mm")
    return Pin((x, y, z), radius, extra)


def girth_from_text(text: str) -> tuple[str, float]:
    """A wanted girth from `name=mm`.

    Raises:
        InputError: No number.
    """
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
