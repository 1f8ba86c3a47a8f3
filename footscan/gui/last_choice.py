"""What the Last tab has chosen and made; light, for the page's state holds it from the beginning."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from footscan.coordinates import Floats
    from footscan.shoelast.compare import Comparison
    from footscan.shoelast.custom_last import CustomLast
    from footscan.shoelast.model import Shoelast
    from footscan.shoelast.pins import Pin
    from footscan.shoelast.rank import Ranked
    from footscan.shoelast.skin import LastSkin

LastShown = Literal["Last round the foot", "Clearance map", "Changed areas"]


@dataclass(frozen=True)
class FittedLast:
    """A foot laid into a last.

    Attributes:
        last_id: In the library.
        shoelast: The last.
        skin: Its mesh, coarse enough for a browser.
        comparison: Room by region, girths.
        clearance_mm: `(n,)` at the vertices of the posed foot; NaN where nothing is judged.
    """

    last_id: str
    shoelast: Shoelast
    skin: LastSkin
    comparison: Comparison
    clearance_mm: Floats


@dataclass(frozen=True)
class LastChoice:
    """Where the Last tab has got to.

    Attributes:
        take_id: Of the foot; None for the one in use.
        profile: How much room.
        ranking: The best lasts, best first.
        last_id: Chosen.
        shown: What the 3-D view shows.
        fitted: The chosen last round the foot.
        pins: Spot allowances.
        custom: The customised last.
        hidden: The 3-D view shows the scan instead.
    """

    take_id: int | None = None
    profile: str = "therapeutic"
    ranking: tuple[Ranked, ...] = ()
    last_id: str = ""
    shown: LastShown = "Last round the foot"
    fitted: FittedLast | None = None
    pins: tuple[Pin, ...] = ()
    custom: CustomLast | None = None
    hidden: bool = False
    thumbnail: bytes = field(default=b"", repr=False)

    def without_last(self, **values: object) -> LastChoice:
        """The same foot and profile, nothing fitted or made yet."""
        return replace(self, fitted=None, custom=None, **values)  # type: ignore[arg-type]
