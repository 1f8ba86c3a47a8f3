"""The proof: no seen skin stands out of the last that was made. Unseen skin is told apart and decides nothing."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from footscan.coordinates import Bools, Floats
from footscan.shoelast.foot_samples import FootSamples
from footscan.shoelast.profile import REGIONS, region_of
from footscan.shoelast.top_line import TopLine

LIMIT_MM = 0.05
LEAST_SAMPLES = 100_000


@dataclass(frozen=True)
class Judged:
    """Which samples are judged.

    Attributes:
        seen: Seen skin above the feather line and below the top line: what the proof is about.
        unseen: The other skin there: bridged or assumed.
        sole: Skin below the feather line, seen or not.
    """

    seen: Bools
    unseen: Bools
    sole: Bools


@dataclass(frozen=True)
class Proof:
    """Samples of the foot against the final mesh.

    Attributes:
        samples: Seen ones.
        worst_violation_mm: Largest lack of clearance beyond the allowance; 0 or less when nothing lacks.
        worst_at: `(3,)` where, in the last's frame.
        outside_mm: How far the seen skin stands out of the mesh at most; negative when all of it lies inside.
        allowances_mm: Region -> least and largest clearance asked for.
        clearance_mm: Region -> least, mean, 5 % and 95 % of the clearance found.
        unseen: The same of skin that was not seen; it decides nothing.
        top_line: Up to where.
    """

    samples: int
    worst_violation_mm: float
    worst_at: Floats
    outside_mm: float
    allowances_mm: dict[str, tuple[float, float]]
    clearance_mm: dict[str, dict[str, float]]
    unseen: dict[str, dict[str, float]]
    top_line: TopLine

    @property
    def holds(self) -> bool:
        """Whether the last holds the foot."""
        return self.samples >= LEAST_SAMPLES and self.worst_violation_mm <= LIMIT_MM


def judge(samples: FootSamples, above: Bools, top_line: TopLine) -> Judged:
    """Sort samples, given which of them lie above the feather line `(n,)`."""
    below = top_line.below(samples.xyz)
    return Judged(samples.seen & below & above, ~samples.seen & below & above, below & ~above)


def prove(samples: FootSamples, judged: Judged, least_mm: Floats, signed_mm: Floats, top_line: TopLine) -> Proof:
    """Judge samples by their signed distances from the final mesh.

    Args:
        samples: Of the posed and registered foot.
        judged: Which of them count.
        least_mm: `(n,)` least clearance.
        signed_mm: `(n,)` signed distances, negative inside.
        top_line: Up to where the last has to hold the foot.
    """
    seen = judged.seen
    lack = np.where(seen, signed_mm + least_mm, -np.inf)
    worst = int(lack.argmax())
    region = region_of(samples.place)
    allowances: dict[str, tuple[float, float]] = {}
    clearance: dict[str, dict[str, float]] = {}
    for number, name in enumerate(REGIONS):
        here = seen & (region == number)
        if here.any():
            allowances[name] = (float(least_mm[here].min()), float(least_mm[here].max()))
            clearance[name] = spread(-signed_mm[here])
    return Proof(
        samples=int(seen.sum()),
        worst_violation_mm=float(lack[worst]),
        worst_at=samples.xyz[worst],
        outside_mm=float(signed_mm[seen].max(initial=-np.inf)),
        allowances_mm=allowances,
        clearance_mm=clearance,
        unseen={
            name: {"samples": float(mask.sum()), **(spread(-signed_mm[mask]) if mask.any() else {})}
            for name, mask in (("bridged_or_assumed", judged.unseen), ("sole", judged.sole))
        },
        top_line=top_line,
    )


def spread(clearance_mm: Floats) -> dict[str, float]:
    """Least, mean, 5 % and 95 % of some clearances."""
    low, high = np.percentile(clearance_mm, [5.0, 95.0])
    return {
        "min_mm": float(clearance_mm.min()),
        "mean_mm": float(clearance_mm.mean()),
        "p5_mm": float(low),
        "p95_mm": float(high),
    }


def proof_json(proof: Proof, held: dict[str, Any]) -> dict[str, Any]:
    """The content of proof.json, in the last's frame as held in memory (y medial)."""
    return {
        "format": "footscan-last-proof/1",
        "samples": proof.samples,
        "worst_violation_mm": proof.worst_violation_mm,
        "limit_mm": LIMIT_MM,
        "outside_mm": proof.outside_mm,
        "worst_at": proof.worst_at.tolist(),
        "allowances_mm": {name: list(pair) for name, pair in proof.allowances_mm.items()},
        "clearance_mm": proof.clearance_mm,
        "held": held,
        "top_line": {"origin": proof.top_line.origin.tolist(), "normal": proof.top_line.normal.tolist()},
        "unseen": proof.unseen,
        "holds": proof.holds,
    }
