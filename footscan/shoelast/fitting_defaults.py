"""What a fitting starts from; light, for the page shows it before anything of a last is loaded."""

import json
from collections.abc import Mapping
from functools import lru_cache
from importlib.resources import files
from typing import Any

TRANSITION_MM = 10.0
"""How far a change of a last reaches beyond the skin that asks for it, unless somebody says otherwise."""


@lru_cache(maxsize=1)
def profile_data() -> Mapping[str, Any]:
    """The content of profiles.json."""
    return json.loads(files("footscan.shoelast").joinpath("profiles.json").read_text(encoding="utf-8"))


def profile_names() -> tuple[str, ...]:
    """The profiles there are."""
    return tuple(profile_data()["profiles"])
