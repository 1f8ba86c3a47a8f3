"""Fifty seeded deformed feet, each against its best last: does the customised last hold every one of them?"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import trimesh

from footscan.coordinates import Floats
from footscan.errors import QualityError
from footscan.foot.shell import mesh_from_shell, moved
from footscan.foot.sole_bend import smooth_step
from footscan.geometry.rigid import inverse_rigid
from footscan.shoelast.custom_last import CustomLast
from footscan.shoelast.customise import CustomSettings, customise
from footscan.shoelast.last_library import LastEntry, LastLibrary
from footscan.shoelast.prepared_foot import PreparedFoot, prepare_foot
from footscan.shoelast.rank import rank
from footscan.sim.foot import FootShape, build_foot
from footscan.sim.surface import trimesh_from_surface

DEFORMITIES = ("hallux_valgus", "high_instep", "bunion", "oedema", "claw_toes")
_TRIED = 3
"""Lasts of the ranking that are tried one after the other when one is refused."""


@dataclass(frozen=True)
class StudyCase:
    """One deformed foot; `amount` 0.5 (slight) to 1 (strong)."""

    seed: int
    side: str
    size: float
    deformity: str
    amount: float


@dataclass(frozen=True)
class StudyOutcome:
    """What became of it; `custom` is None when every last was refused, with the reason of the last refusal."""

    case: StudyCase
    last_id: str
    custom: CustomLast | None
    reason: str = ""

    @property
    def well(self) -> bool:
        """Whether a last holds this foot."""
        return self.custom is not None and self.custom.proof.holds


def lasts_study_cases(count: int, seed: int = 0) -> tuple[StudyCase, ...]:
    """Feet of all sizes, sides and deformities in turn."""
    random = np.random.default_rng([seed, 0x1A57])
    return tuple(
        StudyCase(
            seed + k,
            "left" if random.random() < 0.5 else "right",
            float(random.uniform(0.88, 1.1)),
            DEFORMITIES[k % len(DEFORMITIES)],
            float(random.uniform(0.5, 1.0)),
        )
        for k in range(count)
    )


def deformed_foot(case: StudyCase) -> trimesh.Trimesh:
    """The built-in foot (mm, standing on z = 0), deformed."""
    valgus = np.radians(22.0) * case.amount if case.deformity == "hallux_valgus" else 0.0
    side = "left" if case.side == "left" else "right"
    mesh = trimesh_from_surface(build_foot(FootShape(side, round(case.size, 2), hallux_valgus_rad=valgus)))
    if case.deformity == "hallux_valgus":
        return mesh
    foot = prepare_foot(mesh, side)
    shell = foot.shell
    xyz = deformed(shell.xyz, foot, case.deformity, case.amount)
    bent = type(shell)(xyz, shell.faces, shell.origin)
    return mesh_from_shell(moved(bent, inverse_rigid(foot.measurements.foot_from_input)))


def deformed(xyz_foot: Floats, foot: PreparedFoot, deformity: str, amount: float) -> Floats:
    """Skin `(n, 3)` in the foot frame with one deformity."""
    length = foot.value("foot_length")
    x, y, z = xyz_foot.T / length
    medial, lateral = (foot.points[name] / length for name in ("metatarsale_tibiale", "metatarsale_fibulare"))
    up = smooth_step(z / 0.1)
    result = xyz_foot.copy()
    if deformity == "high_instep":
        result[:, 2] += amount * 9.0 * up * np.exp(-(((x - 0.5) / 0.13) ** 2))
    elif deformity == "bunion":
        bump = np.exp(-(((x - medial[0]) / 0.06) ** 2 + ((z - 0.07) / 0.05) ** 2))
        result[:, 1] += amount * 8.0 * bump * smooth_step((y - 0.5 * medial[1]) / (0.5 * medial[1]))
    elif deformity == "oedema":
        middle = 0.5 * (medial[1] + lateral[1])
        swell = 1.0 + 0.05 * amount
        result[:, 1] = length * (middle + swell * (y - middle))
        result[:, 2] = length * z * (1.0 + 0.06 * amount * smooth_step(z / 0.06))
    elif deformity == "claw_toes":
        across = smooth_step((medial[1] - y) / 0.06) * smooth_step((y - lateral[1]) / 0.06)
        result[:, 2] += amount * 9.0 * up * np.exp(-(((x - 0.86) / 0.055) ** 2)) * across
    return result


def run_lasts_study(
    cases: tuple[StudyCase, ...], library: LastLibrary, settings: CustomSettings
) -> Iterator[StudyOutcome]:
    """Customise the best therapeutic last for every foot."""
    entries = [entry for entry in library.entries() if entry.style == "therapeutic"]
    for case in cases:
        yield _outcome(case, entries, library, settings)


def outcome_json(outcome: StudyOutcome) -> dict[str, Any]:
    """One foot of `footscan study lasts --json`."""
    custom = outcome.custom
    found = {"last": outcome.last_id, "held": outcome.well, "refused": outcome.reason if custom is None else ""}
    if custom is not None:
        found |= {
            "worst_violation_mm": custom.proof.worst_violation_mm,
            "samples": custom.proof.samples,
            "most_mm": float(custom.displacement_mm.max()),
            "overshoot_mm": custom.overshoot_mm,
            "chord_error_mm": custom.chord_error_mm,
            "widening_mm": custom.widening_mm,
            "rounds": custom.rounds,
            "outside_mm": custom.outside_mm,
            "curvature_step_per_mm2": custom.smoothness.curvature_step_per_mm2[1],
            "ball_girth_mm": custom.dimensions["ball_girth"][:2],
        }
    return vars(outcome.case) | found


def _outcome(case: StudyCase, entries: list[LastEntry], library: LastLibrary, settings: CustomSettings) -> StudyOutcome:
    foot = prepare_foot(deformed_foot(case), "left" if case.side == "left" else "right")
    reason, last_id = "", ""
    for one in rank(entries, foot, "therapeutic")[:_TRIED]:
        last_id = one.entry.id
        try:
            return StudyOutcome(case, last_id, customise(library.load(last_id), foot, "therapeutic", settings))
        except QualityError as refusal:
            reason = str(refusal)
    return StudyOutcome(case, last_id, None, reason)
