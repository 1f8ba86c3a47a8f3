"""The patches of a last as clamped NURBS of the real last, normals outward, and the JSON that geomdl reads.

The upper is periodic round; knots are inserted exactly at u = 0 (the heel back), so that CAD, which wants clamped
surfaces, gets the same surface to rounding. The discs are clamped already.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from scipy.interpolate import BSpline

from footscan.config.toml_file import write_whole
from footscan.coordinates import Floats, Side
from footscan.errors import MeshError
from footscan.foot.nurbs import DEGREE, SplineTube
from footscan.foot.surface_files import clamped_net
from footscan.shoelast.handed import DATUM, mirrored, mirrored_mesh
from footscan.shoelast.model import Attachment, Shoelast
from footscan.shoelast.patches import ChordDisc

FORMAT = "footscan-last-surfaces/1"
PATCHES = ("upper", "bottom", "cone_top")
_DELTA = 0.02  # geomdl's default step of evaluation


@dataclass(frozen=True)
class NurbsPatch:
    """A bicubic clamped surface of the real last with unit weights; du x dv points outward.

    Attributes:
        name: upper, bottom or cone_top.
        net_mm: `(n_u, n_v, 3)` control points.
        knots_u: `(n_u + 4,)` from 0 to 1.
        knots_v: `(n_v + 4,)` from 0 to 1.
    """

    name: str
    net_mm: Floats
    knots_u: Floats
    knots_v: Floats

    def grid(self, u: Floats, v: Floats) -> Floats:
        """Evaluate on a grid `(m,)` x `(k,)`: `(m, k, 3)` mm."""
        along = BSpline(self.knots_u, self.net_mm, DEGREE, axis=0)(u)
        return BSpline(self.knots_v, along, DEGREE, axis=1)(v)


def clamped_patches(shoelast: Shoelast) -> tuple[NurbsPatch, NurbsPatch, NurbsPatch]:
    """Upper, bottom and cone top of the real last.

    The upper's u goes round from the heel back (right last: along the lateral side first, left last: along the medial
    side first), v from the feather edge to the cone edge; the discs' u goes from heel to toe.
    """
    net, knots_u = clamped_net(shoelast.upper)
    upper = NurbsPatch("upper", net.transpose(1, 0, 2), knots_u, shoelast.upper.knots_v)
    bottom = _patch_of_disc("bottom", shoelast.bottom)
    cone_top = _patch_of_disc("cone_top", shoelast.cone_top)
    side = shoelast.side
    return _real(upper, side, "u"), _real(bottom, side, "v"), _real(cone_top, side, "")


def _patch_of_disc(name: str, disc: ChordDisc) -> NurbsPatch:
    return NurbsPatch(name, disc.net_mm, disc.knots_s, disc.knots_t)


def _real(patch: NurbsPatch, side: Side, inward: str) -> NurbsPatch:
    """Mirrored for a left last; `inward` names the parameter to turn round where the right last's normal looks in."""
    turned = inward if side == "right" else ("" if inward else "v")
    net, knots_u, knots_v = mirrored(patch.net_mm, side), patch.knots_u, patch.knots_v
    if turned == "u":
        net, knots_u = net[::-1], 1.0 - knots_u[::-1]
    if turned == "v":
        net, knots_v = net[:, ::-1], 1.0 - knots_v[::-1]
    return NurbsPatch(patch.name, np.ascontiguousarray(net), knots_u, knots_v)


def last_document(shoelast: Shoelast) -> dict[str, Any]:
    """What the JSON file holds: who it is, lines and points, and `shape` as `geomdl.exchange.import_json` reads it."""
    side = shoelast.side
    return {
        "format": FORMAT,
        "name": shoelast.name,
        "side": side,
        "style": shoelast.style,
        "size_eu": shoelast.size_eu,
        "fitting": shoelast.fitting,
        "datum": DATUM,
        "remarks": list(shoelast.remarks),
        "lines": {name: mirrored(line, side).tolist() for name, line in shoelast.lines.items()},
        "points": {name: mirrored(point, side).tolist() for name, point in shoelast.points.items()},
        "attachments": [_attachment_json(each, side) for each in shoelast.attachments],
        "shape": {"type": "surface", "count": 3, "data": [_surface(patch) for patch in clamped_patches(shoelast)]},
    }


def _attachment_json(attachment: Attachment, side: Side) -> dict[str, Any]:
    mesh = mirrored_mesh(attachment.mesh, side)
    return {"kind": attachment.kind, "xyz": mesh.vertices.tolist(), "faces": mesh.faces.tolist()}


def save_last_json(shoelast: Shoelast, path: Path) -> None:
    """Write a last as JSON: three NURBS surfaces that geomdl reads; its names, lines, points, stub and toe centre.

    Raises:
        StorageError: The place cannot be written.
    """
    write_whole(path, json.dumps(last_document(shoelast)).encode())


def _surface(patch: NurbsPatch) -> dict[str, Any]:
    points = patch.net_mm.reshape(-1, 3)
    return {
        "type": "spline",
        "name": patch.name,
        "rational": True,
        "dimension": 3,
        "degree_u": DEGREE,
        "degree_v": DEGREE,
        "knotvector_u": patch.knots_u.tolist(),
        "knotvector_v": patch.knots_v.tolist(),
        "size_u": patch.net_mm.shape[0],
        "size_v": patch.net_mm.shape[1],
        "control_points": {"points": points.tolist(), "weights": [1.0] * len(points)},
        "delta": [_DELTA, _DELTA],
    }


def load_last_json(path: Path) -> Shoelast:
    """Read what `save_last_json` wrote; the upper is periodic again, the same surface to rounding.

    Raises:
        MeshError: Missing, no last of footscan, or damaged.
    """
    try:
        document = json.loads(path.read_bytes())
    except (OSError, ValueError) as err:
        raise MeshError(f"{path} cannot be read as a last ({err}); customise or export it again.") from err
    found = document.get("format") if isinstance(document, dict) else None
    if found != FORMAT:
        raise MeshError(f"{path}: format is {found!r}, allowed is {FORMAT!r}; give a custom.json made by `customise`.")
    try:
        return _last_of(document)
    except (KeyError, TypeError, ValueError) as err:
        raise MeshError(f"{path} is damaged ({type(err).__name__}: {err}); customise or export it again.") from err


def shoelast_of_patches(patches: Mapping[str, NurbsPatch], name: str, side: Side) -> Shoelast:
    """The inverse of `clamped_patches`: the upper is periodic again, the same surface to rounding.

    Raises:
        KeyError: Not all of upper, bottom, cone_top.
        ValueError: The upper's knots around are not uniform.
    """
    upper, bottom, cone_top = (patches[each] for each in PATCHES)
    return Shoelast(
        name=name,
        side=side,
        upper=_periodic_tube(_real(upper, side, "u")),
        bottom=_disc_of_patch(_real(bottom, side, "v")),
        cone_top=_disc_of_patch(_real(cone_top, side, "")),
    )


def _last_of(document: Mapping[str, Any]) -> Shoelast:
    side = _side(document["side"])
    nets = {surface["name"]: _patch_of_surface(surface) for surface in document["shape"]["data"]}
    size = document["size_eu"]
    return replace(
        shoelast_of_patches(nets, str(document["name"]), side),
        style=str(document["style"]),
        size_eu=None if size is None else float(size),
        fitting=str(document["fitting"]),
        lines={name: mirrored(_points(line), side) for name, line in document["lines"].items()},
        points={name: mirrored(_points([point])[0], side) for name, point in document["points"].items()},
        attachments=tuple(_attachment(each, side) for each in document["attachments"]),
        remarks=tuple(str(remark) for remark in document["remarks"]),
    )


def _attachment(content: Mapping[str, Any], side: Side) -> Attachment:
    faces = np.asarray(content["faces"], dtype=np.int64).reshape(-1, 3)
    mesh = trimesh.Trimesh(_points(content["xyz"]), faces, process=False)
    return Attachment(str(content["kind"]), mirrored_mesh(mesh, side))


def _side(word: object) -> Side:
    if word == "right":
        return "right"
    if word == "left":
        return "left"
    raise ValueError(f"side {word!r}, allowed are right and left")


def _points(rows: Any) -> Floats:
    xyz = np.asarray(rows, dtype=np.float64)
    if xyz.ndim != 2 or xyz.shape[1] != 3 or not np.isfinite(xyz).all():
        raise ValueError(f"points of shape {xyz.shape}, allowed are rows of three finite numbers")
    return xyz


def _patch_of_surface(surface: Mapping[str, Any]) -> NurbsPatch:
    net = _points(surface["control_points"]["points"]).reshape(surface["size_u"], surface["size_v"], 3)
    return NurbsPatch(surface["name"], net, _knots(surface, "u", net.shape[0]), _knots(surface, "v", net.shape[1]))


def _knots(surface: Mapping[str, Any], way: str, count: int) -> Floats:
    knots = np.asarray(surface[f"knotvector_{way}"], dtype=np.float64)
    if surface[f"degree_{way}"] != DEGREE or knots.shape != (count + DEGREE + 1,) or np.any(np.diff(knots) < 0):
        raise ValueError(f"knots in {way} do not fit {count} control points of degree {DEGREE}")
    return knots


def _disc_of_patch(patch: NurbsPatch) -> ChordDisc:
    return ChordDisc(patch.net_mm, patch.knots_u, patch.knots_v)


def _periodic_tube(patch: NurbsPatch) -> SplineTube:
    """Take the knots out again that `clamped_net` inserted."""
    net, count = patch.net_mm, len(patch.net_mm) - DEGREE
    spacing = np.diff(patch.knots_u[DEGREE:-DEGREE])
    if np.abs(spacing - 1.0 / count).max() > 1e-9:
        raise ValueError("the upper's knots around are not uniform")
    first = net[count]
    second = (DEGREE * net[count + 1] - first) / 2.0
    around = np.concatenate([first[None], second[None], net[2:count]])
    return SplineTube(around.transpose(1, 0, 2), patch.knots_v)
