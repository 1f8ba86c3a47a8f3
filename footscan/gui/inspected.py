"""A foot as the Inspect tab looks at it: mesh with its classes, shell for cuts, axis, measurements, files."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from footscan.config.recording_file import Subject
from footscan.coordinates import Floats
from footscan.errors import InputError
from footscan.gui import texts
from footscan.gui.station import Station
from footscan.records import Take

if TYPE_CHECKING:
    import trimesh

    from footscan.foot.sections import Section
    from footscan.foot.shell import Shell
    from footscan.foot.wedge import Wedge
    from footscan.workflow.foot import FootSettings

_HEIGHT_MM = 30.0
"""Above the board: where a tilted plane turns about."""
_SIDE_PX, _FLOOR_PX = 44, 24
_LINES = ('stroke="#c00078" stroke-width="1.8"', 'stroke="#0060a8" stroke-width="1.6" stroke-dasharray="5 3"')
"""Of the chosen foot, and of the other one."""


@dataclass(frozen=True)
class InspectedFoot:
    """One measured foot.

    Attributes:
        take: Whose.
        folder: Of its files; never to be written to.
        mesh: World mm, with `origin`, `sheets`, `residual_mm` per vertex.
        shell: For cuts.
        foot_from_world: 4x4, x from heel to toe; a reflection for a left foot.
        length_mm: Of the foot.
        measurements: As in measurements.json.
        wedge: On which the foot stood; None for the flat board.
    """

    take: Take
    folder: Path
    mesh: trimesh.Trimesh
    shell: Shell
    foot_from_world: Floats
    length_mm: float
    measurements: dict[str, Any]
    wedge: Wedge | None = None


@dataclass(frozen=True)
class TriedFoot:
    """A foot measured again with filtering and smoothing, on a copy.

    Attributes:
        take_id: Of the take.
        foot: The copy.
        words: What was tried.
        price: `before` and `after`: name -> value.
    """

    take_id: int
    foot: InspectedFoot
    words: str
    price: dict[str, dict[str, float]]


def open_foot(station: Station, take: Take) -> InspectedFoot:
    """Read the foot of a take.

    Raises:
        InputError: It has no measured foot, or its files are damaged.
    """
    from footscan.foot.shell import shell_from_mesh
    from footscan.foot.surface_files import load_surface_ply
    from footscan.foot.wedge import wedge_from_json

    if take.result is None or take.result.refused:
        raise InputError(f"take {take.id} has no measured foot; measure it again, or choose another take.")
    folder = station.store.results_folder(take.result.id)
    mesh = load_surface_ply(folder / "surface.ply")
    try:
        content = json.loads((folder / "measurements.json").read_text(encoding="utf-8"))
        foot_from_world = np.array(content["foot_from_input"], dtype=np.float64)
        length_mm = float(content["measurements"]["foot_length"]["value"])
        wedge = wedge_from_json(content.get("wedge"))
    except (OSError, ValueError, KeyError, TypeError) as err:
        raise InputError(f"{folder} holds no complete measurements ({err!r}); measure the take again.") from err
    skin = shell_from_mesh(mesh)
    return InspectedFoot(take, folder, mesh, skin, foot_from_world, length_mm, content["measurements"], wedge)


def try_smoothing(foot: InspectedFoot, settings: FootSettings) -> TriedFoot:
    """Measure the stored points of a take again, filtered and smoothed; nothing is kept.

    Raises:
        InputError: The files of the take are damaged.
        MeshError: The points are no foot any more.
    """
    from footscan.foot.measurements import measurements_json
    from footscan.foot.shell import shell_from_mesh
    from footscan.scanning.point_file import load_bare_board, load_points
    from footscan.workflow.foot import measure_scan
    from footscan.workflow.stored_foot import stored_subject

    take = foot.take
    assert take.result is not None
    cloud = load_points(foot.folder / "points.ply")
    subject = Subject(load=take.said.load, absent=take.missing)
    marks = {mark.name: mark.xyz_world for mark in take.landmarks}
    board, under = load_bare_board(foot.folder / "board.npy"), stored_subject(foot.folder).placed
    made = measure_scan(cloud, take.said.side, subject, settings, marks, board, under)
    values = measurements_json(made.measurements)
    copy = InspectedFoot(
        take,
        foot.folder,
        made.mesh,
        shell_from_mesh(made.mesh),
        made.measurements.foot_from_input,
        float(made.measurements["foot_length"].value or foot.length_mm),
        cast("dict[str, Any]", values["measurements"]),
        made.measurements.wedge,
    )
    words = texts.SMOOTH_TRIED.format(filter=settings.filter_strength, smooth=settings.smooth_mm)
    return TriedFoot(take.id, copy, words, made.price)


def cut_at(foot: InspectedFoot, share: float, turn_deg: float, tilt_deg: float) -> Section:
    """Cut a foot.

    Args:
        foot: The foot.
        share: Where on its axis, 0 at the heel and 1 at the longest toe.
        turn_deg: Around the vertical, 0 cuts across the foot.
        tilt_deg: 0 is upright, 90 is level; it turns about a point 30 mm above the board.

    Raises:
        MeshError: The plane misses the foot.
    """
    from footscan.foot.foot_frame import FootFrame
    from footscan.foot.sections import measure_cut

    turn, tilt = np.deg2rad([turn_deg, tilt_deg])
    normal_foot = np.array([np.cos(tilt) * np.cos(turn), np.cos(tilt) * np.sin(turn), np.sin(tilt)])
    point_foot = np.array([share * foot.length_mm, 0.0, _HEIGHT_MM])
    return measure_cut(foot.shell, *FootFrame(foot.foot_from_world, foot.wedge).plane_to_input(point_foot, normal_foot))


def outlines_svg(cuts: Sequence[tuple[InspectedFoot, Section]], width_px: int = 340, height_px: int = 200) -> str:
    """Cuts as a drawing, to scale, with a bar of 20 mm and where the inner side, the toes or up are.

    Both feet are drawn as if they were right ones, so that their shapes can be compared.
    """
    from footscan.foot.sections import plane_axes

    foot, cut = cuts[0]
    u_foot, v_foot = plane_axes(foot.foot_from_world[:3, :3] @ cut.normal)
    axes_foot = np.stack([u_foot, v_foot], axis=1)
    drawn = [[(_in_foot(each, line) - _in_foot(each, one.origin)) @ axes_foot for line in one.polylines]
             for each, one in cuts]  # fmt: skip
    everything = np.concatenate([line for lines in drawn for line in lines])
    low, size = everything.min(axis=0), np.maximum(np.ptp(everything, axis=0), 1.0)
    scale = min((width_px - 2 * _SIDE_PX) / size[0], (height_px - _FLOOR_PX - 18) / size[1])
    shift = np.array([(width_px - size[0] * scale) / 2, _FLOOR_PX])
    paths = "".join(
        _path((line - low) * scale + shift, height_px, style)
        for lines, style in zip(drawn, _LINES, strict=False)
        for line in lines
    )
    words = _words_at(_named(-u_foot), 4, height_px / 2, "start") + _words_at(
        _named(u_foot), width_px - 4, height_px / 2, "end"
    )
    words += _words_at(_named(v_foot), width_px / 2, 13, "middle")
    return (
        f'<svg width="{width_px}" height="{height_px}" role="img" aria-label="section" '
        f'style="background:#fafafa;border:1px solid #ddd">{paths}{words}{_bar(20.0 * scale, height_px)}</svg>'
    )


def _in_foot(foot: InspectedFoot, xyz_world: Floats) -> Floats:
    return xyz_world @ foot.foot_from_world[:3, :3].T + foot.foot_from_world[:3, 3]


def _named(axis_foot: Floats) -> str:
    """What lies that way of a foot: x points to the toes, y to the inner side, z up."""
    along = int(np.argmax(np.abs(axis_foot)))
    return texts.WAYS[along][0 if axis_foot[along] > 0 else 1]


def _words_at(words: str, x_px: float, y_px: float, anchor: str) -> str:
    return f'<text x="{x_px:.0f}" y="{y_px:.0f}" font-size="11" fill="#555" text-anchor="{anchor}">{words}</text>'


def _bar(length_px: float, height_px: int) -> str:
    return (
        f'<line x1="10" y1="{height_px - 8}" x2="{10 + length_px:.0f}" y2="{height_px - 8}" stroke="#333" '
        f'stroke-width="2"/><text x="{14 + length_px:.0f}" y="{height_px - 4}" font-size="11">20 mm</text>'
    )


def _path(uv_px: Floats, height_px: int, style: str) -> str:
    points = " ".join(f"{u:.1f},{height_px - v:.1f}" for u, v in uv_px)
    return f'<polyline points="{points}" fill="none" {style}/>'
