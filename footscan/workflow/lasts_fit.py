"""Fitting lasts for a visit: a foot from disk, ranking, comparing, customising, and the files that leave."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, cast

import numpy as np

from footscan.config.toml_file import write_whole
from footscan.coordinates import Side
from footscan.errors import QualityError, StorageError
from footscan.foot.mesh_file import load_foot_mesh
from footscan.foot.shell import mesh_from_shell
from footscan.foot.surface_files import save_surface_stl
from footscan.shoelast.compare import Comparison
from footscan.shoelast.custom_last import CustomLast, Smoothing, Smoothness, held_json
from footscan.shoelast.handed import DATUM, mirrored, mirrored_mesh
from footscan.shoelast.nurbs_out import save_last_json
from footscan.shoelast.pitch_of_scan import wedge_mm
from footscan.shoelast.prepared_foot import PreparedFoot, prepare_foot
from footscan.shoelast.proof import LIMIT_MM, proof_json
from footscan.shoelast.rank import Ranked
from footscan.shoelast.top_line import FeatherLine, TopLine
from footscan.workflow.lasts_clearance import skin_clearance
from footscan.workflow.lasts_pictures import save_changed_picture, save_clearance_map, save_plan_picture
from footscan.workflow.stored_foot import stored_subject

UNSMOOTHED_FILE = "unsmoothed.json"
"""Only when smoothing was asked for."""
CUSTOM_FILES = (
    "custom.stl",
    "custom.json",
    "foot_in_last.stl",
    "proof.json",
    "plan.png",
    "clearance.png",
    "changed.png",
)


def load_foot(place: Path, unit: str, side: Side | None, wedge: float | None = None) -> PreparedFoot:
    """A foot from a mesh file or a folder made by `process`; the folder knows side, load, missing parts and wedge.

    Args:
        place: The file or folder.
        unit: Of a mesh file.
        side: None for the folder's or the shape's.
        wedge: Height (mm) of the wedge under the heel; None for the folder's word.

    Raises:
        MeshError: No foot.
        InputError: A damaged folder.
    """
    known = stored_subject(place)
    under = known.wedge if wedge is None else wedge
    return prepare_foot(load_foot_mesh(place, unit), side or known.side, known.load, known.absent, under)


def ranking_json(ranking: Sequence[Ranked]) -> dict[str, Any]:
    """What `lasts rank --json` prints."""
    return {"ranking": [ranked_json(one) for one in ranking]}


def ranked_json(one: Ranked) -> dict[str, Any]:
    """One place of a ranking."""
    entry = one.entry
    return {
        "id": entry.id,
        "name": entry.name,
        "score": round(one.score, 4),
        "side": entry.side,
        "size_eu": entry.size_eu,
        "fitting": entry.fitting,
        "style": entry.style,
        "pitch_mm": entry.pitch_mm,
        "parts": {name: round(value, 4) for name, value in one.parts.items()},
        "differences_mm": {name: round(value, 2) for name, value in one.differences_mm.items()},
        "reason": one.reason,
    }


def comparison_json(found: Comparison) -> dict[str, Any]:
    """What `lasts compare --json` prints."""
    lie = found.registration
    return {
        "regions": {name: vars(room) for name, room in found.regions.items()},
        "plantar": None if found.plantar is None else vars(found.plantar),
        "unseen": None if found.unseen is None else vars(found.unseen),
        "girths_mm": {
            name: {"foot": one.foot_mm, "last": one.last_mm, "difference": one.last_mm - one.foot_mm}
            for name, one in found.girths.items()
        },
        "registration": None if lie is None else vars(lie),
        "wedge_mm": None if found.posed is None else wedge_mm(found.posed.foot),
        "bend_changes": {} if found.posed is None else found.posed.changes,
        "remarks": list(found.remarks),
    }


@dataclass(frozen=True)
class SavedCustom:
    """Where a customised last was written, and the content of proof.json."""

    folder: Path
    proof: dict[str, Any]


def save_custom(custom: CustomLast, folder: Path) -> SavedCustom:
    """Write custom.stl, custom.json, foot_in_last.stl, proof.json and three pictures, in real handedness.

    Raises:
        StorageError: The folder cannot be written.
        QualityError: The last does not hold the foot; the files are there all the same, to see where.
    """
    side = custom.shoelast.side
    _empty(folder)
    save_surface_stl(mirrored_mesh(custom.skin.mesh(), side), folder / "custom.stl")
    save_last_json(custom.shoelast, folder / "custom.json")
    if custom.smoothing is not None:
        save_last_json(custom.smoothing.unsmoothed, folder / UNSMOOTHED_FILE)
    save_surface_stl(mirrored_mesh(mesh_from_shell(custom.posed.shell), side), folder / "foot_in_last.stl")
    content = custom_json(custom)
    write_whole(folder / "proof.json", (json.dumps(content, indent=1) + "\n").encode())
    _save_pictures(custom, folder)
    if not custom.proof.holds:
        raise QualityError(
            f"the last in {folder} does not hold the foot: {custom.proof.worst_violation_mm:.2f} mm of room is "
            f"missing (at most {LIMIT_MM} mm); see proof.json; grade it or take another."
        )
    return SavedCustom(folder, content)


def _empty(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name in (*CUSTOM_FILES, UNSMOOTHED_FILE):
            (folder / name).unlink(missing_ok=True)
    except OSError as err:
        raise StorageError(f"{folder} cannot be used for results ({err.strerror}); choose another place.") from err


def custom_json(custom: CustomLast) -> dict[str, Any]:
    """The content of proof.json: the proof, and what was done to the last; places in real handedness."""
    side = custom.shoelast.side
    line = custom.proof.top_line
    real = TopLine(mirrored(line.origin, side), mirrored(line.normal, side))
    content = proof_json(
        replace(custom.proof, top_line=real, worst_at=mirrored(custom.proof.worst_at, side)), held_json(custom)
    )
    smooth = _smoothness_json(custom.smoothness)
    return content | {
        "last": custom.original.name,
        "side": side,
        "profile": custom.profile.name,
        "transition_mm": custom.transition_mm,
        "rounds": custom.rounds,
        "datum": DATUM,
        "registration": vars(custom.registration),
        "insole_mm": vars(custom.posed.stack),
        "wedge_mm": wedge_mm(custom.posed.foot),
        "bend_changes": custom.posed.changes,
        "dimensions": _dimensions_json(custom.dimensions),
        "displacement_mm": {
            "least": float(custom.displacement_mm.min()),
            "most": float(custom.displacement_mm.max()),
            "changed_share": float(np.mean(custom.changed)),
        },
        "bottom_widened_mm": custom.widening_mm,
        "overshoot_mm": custom.overshoot_mm,
        "moved_outside_transition_mm": custom.outside_mm,
        "seen_share": custom.seen_share,
        "mesh": {"triangles": len(custom.skin.faces), "chord_error_mm": custom.chord_error_mm},
        "smoothness": smooth,
        "smoothing": None if custom.smoothing is None else _smoothing_json(custom.smoothing),
        "unmet": list(custom.unmet),
        "remarks": list(custom.remarks),
    }


def _dimensions_json(dimensions: Mapping[str, tuple[float, float, str]]) -> dict[str, Any]:
    return {
        name: {"before": before, "after": after, "unit": unit} for name, (before, after, unit) in dimensions.items()
    }


def _smoothness_json(smoothness: Smoothness) -> dict[str, Any]:
    return {name: _plain(one) for name, one in vars(smoothness).items()}


def _smoothing_json(smoothing: Smoothing) -> dict[str, Any]:
    return {
        "limit_mm": smoothing.limit_mm,
        "most_mm": smoothing.most_mm,
        "variation": list(smoothing.variation),
        "before": _smoothness_json(smoothing.before),
        "dimensions": _dimensions_json(smoothing.dimensions),
    }


def _plain(value: object) -> object:
    return list(cast("tuple[float, ...]", value)) if isinstance(value, tuple) else value


def _save_pictures(custom: CustomLast, folder: Path) -> None:
    side, title = custom.shoelast.side, f"{custom.original.name}, customised"
    shell = custom.posed.shell
    save_plan_picture(folder / "plan.png", custom.shoelast, shell.xyz, shell.faces, title)
    save_changed_picture(folder / "changed.png", custom.skin, custom.displacement_mm, side, title)
    feather = FeatherLine(custom.shoelast)
    clearance = skin_clearance(custom.skin, custom.posed, custom.proof.top_line, feather)
    save_clearance_map(folder / "clearance.png", shell.xyz, shell.faces, clearance, side, title)
