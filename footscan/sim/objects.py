"""Things to put on the board: the built-in foot, artefacts, bodies with an exact formula, and meshes from files."""

from pathlib import Path

import numpy as np

from footscan.coordinates import WORKING_RADIUS_MM, Side
from footscan.errors import InputError
from footscan.sim.artefacts import ARTEFACT_NAMES, build_artefact
from footscan.sim.bodies import build_cylinder, build_plate, build_sphere
from footscan.sim.foot import FootShape, build_foot
from footscan.sim.surface import Surface, load_surface, stand_on_board

__all__ = ["OBJECT_NAMES", "build_cylinder", "build_object", "build_plate", "build_sphere"]

OBJECT_NAMES = ("foot", *ARTEFACT_NAMES, "cylinder")


def build_object(
    name: str, unit: str = "mm", side: Side = "left", size: float = 1.0, shape: FootShape | None = None
) -> Surface:
    """A named object, or a mesh file put on the board with the middle of its outline on the axis.

    Args:
        name: One of `OBJECT_NAMES`, or the path of a mesh file.
        unit: Of the file: mm, cm or m.
        side: Of the built-in foot.
        size: Of the built-in foot.
        shape: Of the built-in foot, instead of side and size: arch and deformities too.

    Raises:
        InputError: No such object or file, or a size or unit that does not fit.
    """
    match name:
        case "foot":
            return build_foot(shape or FootShape(side, size))
        case _ if name in ARTEFACT_NAMES:
            return build_artefact(name).surface
        case "cylinder":
            return build_cylinder(40.0, 120.0)
        case _ if not Path(name).suffix and not Path(name).exists():
            raise InputError(f"there is no object {name!r}; give {', '.join(OBJECT_NAMES)}, or a mesh file.")
        case _:
            return _within_reach(stand_on_board(load_surface(Path(name), unit)), name)


def _within_reach(surface: Surface, name: str) -> Surface:
    reach_mm = float(np.hypot(surface.xyz_world[:, 0], surface.xyz_world[:, 1]).max())
    if reach_mm > WORKING_RADIUS_MM:
        raise InputError(
            f"{name} spans {reach_mm:.0f} mm from the axis; at most {WORKING_RADIUS_MM:.0f} mm is seen; check --unit."
        )
    return surface
