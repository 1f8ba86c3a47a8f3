"""What is usual: shoe sizes for a foot length, and the norm a measurement is compared with. All numbers are in
norms.json."""

import json
from collections.abc import Mapping
from functools import lru_cache
from importlib.resources import files
from typing import Any, Literal, get_args

Norm = Literal["adult", "men", "women", "none"]
NORMS: tuple[Norm, ...] = get_args(Norm)


@lru_cache(maxsize=1)
def _norms() -> Mapping[str, Any]:
    return json.loads(files("footscan.foot").joinpath("norms.json").read_text(encoding="utf-8"))


def suggest_sizes(foot_length_mm: float) -> dict[str, float | str]:
    """Shoe sizes for a foot length, system -> size, with a `note` that they are indicative.

    A system that has no size so small is left out.
    """
    sizes = _norms()["sizes"]
    result: dict[str, float | str] = {}
    for system in sizes["systems"]:
        exact = system["per_mm"] * foot_length_mm + system["offset"]
        size = round(exact / system["step"]) * system["step"]
        if size > 0 and not (system["name"] == "uk_child" and size > 13.5):
            result[system["name"]] = size
    result["note"] = sizes["note"]
    return result


def unusual_remark(name: str, value: float, foot_length_mm: float, norm: Norm) -> str | None:
    """Words when a value lies outside what the norm leads one to expect for the foot's length; None otherwise.

    Args:
        name: A measurement; only some have a norm.
        value: Its value (mm).
        foot_length_mm: The foot's length; outside the norm's own range there is no remark.
        norm: men, women, adult (unusual for both), or none (children, declared deformities).
    """
    norms = _norms()
    low, high = norms["foot_length_mm"]
    regressions = norms["regressions"].get(name)
    if norm == "none" or regressions is None or not low <= foot_length_mm <= high:
        return None
    chosen = ("men", "women") if norm == "adult" else (norm,)
    scores = [(value - a - b * foot_length_mm) / sd for a, b, sd in (regressions[sex] for sex in chosen)]
    nearest = min(scores, key=abs)
    if abs(nearest) <= norms["limit_sd"]:
        return None
    side = "above" if nearest > 0 else "below"
    who = "men or women" if norm == "adult" else norm
    return f"{abs(nearest):.1f} SD {side} the ANSUR II regression on foot length ({who})"
