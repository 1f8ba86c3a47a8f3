"""From somebody else's mesh of a last to patches in the frame: what was changed is told in the remarks."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from footscan.coordinates import Bools, Floats, Ints, Side
from footscan.errors import MeshError, QualityError
from footscan.geometry.nearest import PointTree
from footscan.shoelast.bridged_edge import edges_across_holes
from footscan.shoelast.dimensions import with_points_and_lines
from footscan.shoelast.hole_caps import with_caps
from footscan.shoelast.import_chart import chart_upper, loop_shares, smoothed_loop
from footscan.shoelast.import_curves import EDGES, dense_curve, drawn_to_curves, place_on_loop
from footscan.shoelast.import_edges import SHARP_RAD, Regions, find_regions
from footscan.shoelast.import_fit import EdgeLine, FittedUpper, fit_disc, fit_upper
from footscan.shoelast.import_knobs import turned_attachments, without_attachments
from footscan.shoelast.import_pose import (
    check_length,
    check_whole,
    heading_of,
    rough_frame,
)
from footscan.shoelast.import_repair import RepairedLast, check_crossings, repair_last, without_holes
from footscan.shoelast.model import Shoelast
from footscan.shoelast.pose import levelled, moved, settled
from footscan.shoelast.source import LastSource
from footscan.shoelast.split_faces import with_short_edges

FIT_LIMIT_MM, EDGE_LIMIT_MM = 0.05, 0.15
"""What an import is meant to reach (RMS); what it did reach is in the remarks, and far beyond it is refused."""
_REFUSED_MM = 0.5
_STRAIGHT_MM = 4.0
_QUIET_MM = 1.0
"""Noise of an edge is smoothed over so much of it before its halves are paired; at its ends noise would decide."""
_EDGE_SAMPLES = 60000
_ANOTHER_PLACE_MM = 15.0
"""A datum of the file that lays the last further from where its shape would is not that of this last."""


@dataclass(frozen=True)
class ImportFit:
    """How well the patches follow the mesh (mm): RMS of all, of the feather edge, and the largest."""

    rms_mm: float
    edge_rms_mm: float
    largest_mm: float


def shoelast_from_mesh(
    source: LastSource, side: Side, name: str, unit: str = "mm", pitch_mm: float | None = None, *, scanned: bool = False
) -> tuple[Shoelast, ImportFit]:
    """Import a last.

    Args:
        source: Mesh in mm, and named curves where the file brought some.
        side: As said; the shape must not speak against it.
        name: For people.
        unit: Of the file, for messages.
        pitch_mm: Heel height at which the last stands; None levels its bottom under the ball.
        scanned: On the machine: bottom and feather edge are assumed.

    Returns:
        The last with points, lines, attachments and remarks, and how well it fits.

    Raises:
        MeshError: No last, half a last, no sole, several lasts, a wrong unit, or the other side.
        QualityError: The patches do not follow the mesh.
    """
    extent = _extent(np.asarray(source.mesh.vertices, dtype=np.float64))
    check_length(extent, unit, stated=source.states_unit)
    repaired = repair_last(source.mesh)
    frame = rough_frame(repaired.xyz, repaired.faces, side)
    laid = _laid(repaired, frame)
    trimmed = without_attachments(laid.xyz, laid.faces, laid.bodies)
    closed, faces, rims = without_holes(trimmed.xyz, trimmed.faces)
    words = check_whole(closed, faces, rims) + check_crossings(trimmed.xyz, trimmed.faces)
    closed, faces, added = with_caps(*with_short_edges(trimmed.xyz, trimmed.faces))
    measured = np.arange(len(closed)) < len(closed) - added
    given = {name: line @ frame[:3, :3].T + frame[:3, 3] for name, line in source.lines.items()}
    curves = {name: dense_curve(given[name]) for name in EDGES if name in given}
    regions = find_regions(closed, faces, edge_seen=not scanned, curves=curves)
    loops = {"feather_edge": regions.feather_loop, "cone_edge": regions.cone_loop}
    closed, bridged = _bridged(closed, faces, measured, loops)
    closed, taken = drawn_to_curves(closed, loops, curves)
    turn = heading_of(closed[regions.feather_loop])
    closed = closed @ turn[:3, :3].T
    lines = {name: line @ turn[:3, :3].T for name, line in given.items() if name not in EDGES}
    shoelast, fit = _fitted(closed, faces, measured, regions, lines)
    attachments = turned_attachments(trimmed.attachments, turn)
    shoelast = replace(shoelast, name=name, side=side, attachments=attachments, lines=lines)
    shoelast, stands = _standing(shoelast, turn @ frame, source.frame if pitch_mm is None else None, pitch_mm)
    shoelast = _with_given_lines(with_points_and_lines(shoelast), shoelast.lines)
    check_side_of_shape(shoelast, side)
    remarks = (
        *source.remarks,
        *repaired.remarks,
        *trimmed.remarks,
        *words,
        *bridged,
        *taken,
        *stands,
        *_edge_words(regions),
        _fit_words(fit),
    )
    return replace(shoelast, remarks=remarks), fit


def _bridged(xyz: Floats, faces: Ints, measured: Bools, loops: Mapping[str, Ints]) -> tuple[Floats, tuple[str, ...]]:
    """Edges led across the holes that interrupt them, and words on it."""
    at_hole = np.zeros(len(xyz), dtype=np.bool_)
    at_hole[faces[~measured[faces].all(axis=1)]] = True
    words = list[str]()
    for name, loop in loops.items():
        xyz, length = edges_across_holes(xyz, loop, at_hole)
        if length > 0.0:
            words.append(f"{length:.0f} mm of the {name.replace('_', ' ')} lie in holes and were bridged")
    return xyz, tuple(words)


def _standing(
    shoelast: Shoelast, here_from_file: Floats, datum_from_file: Floats | None, pitch_mm: float | None
) -> tuple[Shoelast, tuple[str, ...]]:
    """The last in its frame: that of the file's datum, where it brings one that fits; else by its shape."""
    by_shape = levelled(settled(shoelast), pitch_mm)
    if datum_from_file is None:
        return by_shape, ()
    to_memory = np.diag([1.0, -1.0 if shoelast.side == "left" else 1.0, 1.0, 1.0])
    kept = moved(shoelast, to_memory @ datum_from_file @ np.linalg.inv(here_from_file))
    apart = float(np.linalg.norm(kept.upper.net_mm - by_shape.upper.net_mm, axis=-1).max())
    if apart > _ANOTHER_PLACE_MM:
        return by_shape, (
            f"the file's datum stands {apart:.0f} mm off the last, as if left behind when the last was moved; the last "
            "stands as its shape says",
        )
    return kept, ("it stands as the file's datum says",)


def _with_given_lines(shoelast: Shoelast, given: Mapping[str, Floats]) -> Shoelast:
    """Lines that the file brought stand before those that were found."""
    return replace(shoelast, lines={**shoelast.lines, **given})


def _extent(xyz: Floats) -> float:
    finite = xyz[np.isfinite(xyz).all(axis=1)]
    if len(finite) < 4:
        raise MeshError("the mesh has no finite corners; export the last again.")
    centred = finite - finite.mean(axis=0)
    axes = np.linalg.eigh(centred.T @ centred)[1]
    return float(np.ptp(centred @ axes, axis=0).max())


def _laid(last: RepairedLast, frame: Floats) -> RepairedLast:
    """The body in the rough frame; a reflection turns the faces to stay outward."""
    flip = np.linalg.det(frame[:3, :3]) < 0
    bodies = tuple(body.copy().apply_transform(frame) for body in last.bodies)
    xyz = last.xyz @ frame[:3, :3].T + frame[:3, 3]
    faces = np.ascontiguousarray(last.faces[:, ::-1]) if flip else last.faces
    return RepairedLast(xyz, faces, bodies, last.remarks)


def _fitted(
    xyz: Floats, faces: Ints, measured: Bools, regions: Regions, lines: Mapping[str, Floats]
) -> tuple[Shoelast, ImportFit]:
    feather, cone = (_from_heel(xyz, loop, lines) for loop in (regions.feather_loop, regions.cone_loop))
    chart = chart_upper(xyz, faces[regions.upper], feather[0], feather[1].u, cone[0], cone[1].u)
    upper = fit_upper(xyz, chart, measured, feather[1], cone[1])
    tube = upper.tube
    inside = [
        np.setdiff1d(np.unique(faces[region]), loop)
        for region, loop in ((regions.bottom, regions.feather_loop), (regions.cone_top, regions.cone_loop))
    ]
    places = [xyz[at[measured[at]]] for at in inside]
    bottom = fit_disc(places[0], tube.net_mm[0], tube, 0.0)
    top = fit_disc(places[1], tube.net_mm[-1], tube, 1.0)
    fit = _goodness(upper, feather[1], bottom.deviation_mm, top.deviation_mm)
    return Shoelast("", "right", tube, bottom.disc, top.disc), fit


def _from_heel(xyz: Floats, loop: Ints, lines: Mapping[str, Floats]) -> tuple[Ints, EdgeLine]:
    """An edge's vertices and their u, from its heel end along the medial side to its toe end.

    Back and front line of the file say where these ends are; without them they are its rearmost and foremost places.
    """
    places = xyz[loop]
    area = np.sum(places[:, 0] * np.roll(places[:, 1], -1) - np.roll(places[:, 0], -1) * places[:, 1])
    if area > 0:
        loop, places = loop[::-1], places[::-1]
    quiet = smoothed_loop(places, _QUIET_MM)
    ends = [
        place_on_loop(places, lines.get(name), found)
        for name, found in (("back_line", int(quiet[:, 0].argmin())), ("front_line", int(quiet[:, 0].argmax())))
    ]
    return loop, EdgeLine(places, loop_shares(quiet, *ends))


def _goodness(upper: FittedUpper, feather: EdgeLine, bottom: Floats, top: Floats) -> ImportFit:
    dense = feather.dense()
    line = upper.tube.grid(np.arange(_EDGE_SAMPLES) / _EDGE_SAMPLES, np.array([0.0]))[0]
    edge = PointTree(line).nearest(dense.xyz, 1)[0]
    every = np.concatenate([upper.deviation_mm, bottom, top])
    return ImportFit(_rms(every), _rms(edge), float(np.abs(every).max()))


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2))) if len(values) else 0.0


def check_side_of_shape(shoelast: Shoelast, side: Side) -> None:
    """The ball runs back from medial to lateral; a last whose ball runs the other way is of the other side.

    Raises:
        MeshError: Clearly the other side.
    """
    other = "left" if side == "right" else "right"
    if _slant_mm(shoelast) < -_STRAIGHT_MM:
        raise MeshError(f"said to be a {side} last, its shape is that of a {other} one; pass --side {other} if it is.")


def _slant_mm(shoelast: Shoelast) -> float:
    """How much further forward the outline is widest on the medial than on the lateral side, within one band."""
    u = np.linspace(0.0, 0.5, 400)[1:-1]
    edge = shoelast.upper.grid(np.concatenate([u, 1.0 - u]), np.array([0.0]))[0]
    medial, lateral = edge[: len(u)], edge[len(u) :]
    stick = float(np.ptp(edge[:, 0]))

    def widest(line: Floats, sign: float) -> float:
        band = line[(line[:, 0] > 0.5 * stick) & (line[:, 0] < 0.85 * stick)]
        return float(band[(sign * band[:, 1]).argmax(), 0])

    return widest(medial, 1.0) - widest(lateral, -1.0)


def _edge_words(regions: Regions) -> tuple[str, ...]:
    words = [
        f"{name}: {np.degrees(np.median(turn)):.0f} degrees sharp, {np.mean(turn > SHARP_RAD):.0%} of it above "
        f"{np.degrees(SHARP_RAD):.0f}"
        for name, turn in (("feather edge", regions.feather_turn_rad), ("cone edge", regions.cone_turn_rad))
    ]
    return tuple(words)


def _fit_words(fit: ImportFit) -> str:
    if fit.rms_mm > _REFUSED_MM:
        raise QualityError(
            f"the patches miss the mesh by {fit.rms_mm:.2f} mm RMS, at most {_REFUSED_MM} mm: the mesh crosses itself "
            "or is no last; repair it and export it again."
        )
    met = fit.rms_mm <= FIT_LIMIT_MM and fit.edge_rms_mm <= EDGE_LIMIT_MM
    return (
        f"patches within {fit.rms_mm:.3f} mm RMS of the mesh, feather edge {fit.edge_rms_mm:.3f} mm, largest "
        f"{fit.largest_mm:.2f} mm" + ("" if met else f" (meant are {FIT_LIMIT_MM} and {EDGE_LIMIT_MM})")
    )
