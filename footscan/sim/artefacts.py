"""Artefacts of an acceptance test: spheres, a ball bar, a plane, in a size and at a place of one's choice.

The sizes follow VDI/VDE 2634 for a volume of 350 x 200 x 200 mm: spheres of 45 to 90 mm, a ball bar of at least 135 mm,
a plane of at least 225 x 50 mm. What would hold them is left out.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from footscan.config.toml_file import Table, toml_bytes, write_whole
from footscan.coordinates import WORKING_RADIUS_MM, WORKING_Z_MM, Floats
from footscan.errors import InputError
from footscan.geometry.rigid import rotation_z
from footscan.sim.bodies import build_plate, build_sphere
from footscan.sim.surface import Surface

ARTEFACT_NAMES = ("sphere", "ball-bar", "plane")
PLANE_WIDTH_MM = 60.0


@dataclass(frozen=True)
class ArtefactChoice:
    """Size and place; None is the usual one.

    Attributes:
        diameter_mm: Of the sphere (usually 60), or of either ball of the bar (50).
        spacing_mm: Between the centres of the balls (usually 200).
        length_mm: Of the plane (usually 230); it is 60 mm wide.
        centre_world: Middle, mm (usually on the axis, 60 mm up, the plane 100).
        heading_rad: Of the bar or of the plane's long side, counter-clockwise from X.
        tilt_rad: The bar's end in the heading goes up by this; the plane is turned about its long side (usually 35
            degrees).
    """

    diameter_mm: float | None = None
    spacing_mm: float | None = None
    length_mm: float | None = None
    centre_world: tuple[float, float, float] | None = None
    heading_rad: float = 0.0
    tilt_rad: float | None = None


USUAL_ARTEFACT = ArtefactChoice()


@dataclass(frozen=True)
class Artefact:
    """An artefact in the world, and what is known about it exactly."""

    kind: str
    surface: Surface
    diameters_mm: tuple[float, ...] = ()
    spacing_mm: float | None = None


def build_artefact(kind: str, choice: ArtefactChoice = USUAL_ARTEFACT) -> Artefact:
    """Put an artefact into the machine.

    Raises:
        InputError: No such artefact, or one that does not fit into the working volume.
    """
    match kind:
        case "sphere":
            artefact = _sphere(choice)
        case "ball-bar":
            artefact = _ball_bar(choice)
        case "plane":
            artefact = _plane(choice)
        case _:
            raise InputError(f"an artefact is one of {', '.join(ARTEFACT_NAMES)}; found {kind!r}.")
    _check(artefact)
    return artefact


def save_artefact(artefact: Artefact, folder: Path) -> None:
    """Write artefact.toml (`footscan-artefact/1`) beside a recording.

    Raises:
        StorageError: The place cannot be written.
    """
    table: Table = {"format": "footscan-artefact/1", "kind": artefact.kind}
    if artefact.diameters_mm:
        table["diameters_mm"] = list(artefact.diameters_mm)
    if artefact.spacing_mm is not None:
        table["spacing_mm"] = artefact.spacing_mm
    write_whole(folder / "artefact.toml", toml_bytes(table))


def _sphere(choice: ArtefactChoice) -> Artefact:
    diameter = _positive("diameter", choice.diameter_mm, 60.0)
    return Artefact("sphere", build_sphere(diameter / 2.0, _centre(choice, 60.0)), (diameter,))


def _ball_bar(choice: ArtefactChoice) -> Artefact:
    diameter = _positive("diameter", choice.diameter_mm, 50.0)
    spacing = _positive("spacing", choice.spacing_mm, 200.0)
    if spacing <= diameter:
        raise InputError(
            f"the balls of a bar stand apart: their spacing is above their diameter of {diameter:g} mm, "
            f"found {spacing:g}."
        )
    tilt = choice.tilt_rad or 0.0
    along = rotation_z(choice.heading_rad) @ np.array([np.cos(tilt), 0.0, np.sin(tilt)])
    centre = _centre(choice, 60.0)
    one, two = (build_sphere(diameter / 2.0, centre + end * 0.5 * spacing * along) for end in (-1.0, 1.0))
    faces = np.concatenate([one.faces, two.faces + len(one.xyz_world)])
    both = Surface(np.concatenate([one.xyz_world, two.xyz_world]), faces)
    return Artefact("ball-bar", both, (diameter, diameter), spacing)


def _plane(choice: ArtefactChoice) -> Artefact:
    length = _positive("length", choice.length_mm, 230.0)
    tilt = float(np.deg2rad(35.0)) if choice.tilt_rad is None else choice.tilt_rad
    turn = rotation_z(choice.heading_rad)
    along, normal = turn @ np.array([1.0, 0.0, 0.0]), turn @ np.array([0.0, -np.sin(tilt), np.cos(tilt)])
    plate = build_plate(_centre(choice, 100.0), normal, length / 2.0, along=along, half_across_mm=PLANE_WIDTH_MM / 2.0)
    return Artefact("plane", plate)


def _positive(what: str, given: float | None, usual: float) -> float:
    value = usual if given is None else given
    if not 5.0 <= value <= 400.0:
        raise InputError(f"the {what} of an artefact is 5 to 400 mm, found {value:g}; choose one in between.")
    return value


def _centre(choice: ArtefactChoice, height_mm: float) -> Floats:
    return np.array(choice.centre_world if choice.centre_world is not None else (0.0, 0.0, height_mm))


def _check(artefact: Artefact) -> None:
    xyz_world = artefact.surface.xyz_world
    reach = float(np.hypot(xyz_world[:, 0], xyz_world[:, 1]).max())
    low, high = float(xyz_world[:, 2].min()), float(xyz_world[:, 2].max())
    if reach > WORKING_RADIUS_MM or low < 0.0 or high > WORKING_Z_MM[1]:
        raise InputError(
            f"this {artefact.kind} reaches {reach:.0f} mm from the axis and from {low:.0f} to {high:.0f} mm above the "
            f"board; the machine measures up to {WORKING_RADIUS_MM:.0f} mm and from 0 to {WORKING_Z_MM[1]:.0f} mm: "
            "make it smaller or move it."
        )
