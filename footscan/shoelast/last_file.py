"""A last as one file of the library: control nets, knots, lines, points and attachments, with what is known of it."""

import io
import json
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

import numpy as np
import trimesh

from footscan.coordinates import Floats, Side
from footscan.errors import InputError
from footscan.foot.nurbs import SplineTube
from footscan.shoelast.dimensions import dimensions
from footscan.shoelast.model import Attachment, Shoelast
from footscan.shoelast.patches import ChordDisc

FORMAT = "footscan-last/1"
_ABOUT = "about"
_LINE, _POINT, _PART = "line ", "point ", "part "


def about_shoelast(shoelast: Shoelast, **more: object) -> dict[str, Any]:
    """What an index says of a last: names, side, size, dimensions (mm; cm3), and anything `more`."""
    found = {name: round(value.value, 3) for name, value in dimensions(shoelast).items()}
    return {
        "format": FORMAT,
        "name": shoelast.name,
        "side": shoelast.side,
        "style": shoelast.style,
        "size_eu": shoelast.size_eu,
        "fitting": shoelast.fitting,
        "dimensions": found,
        "remarks": list(shoelast.remarks),
        **more,
    }


def shoelast_bytes(shoelast: Shoelast, about: Mapping[str, Any]) -> bytes:
    """The file's content (NumPy's zip of arrays; the texts are JSON in the array `about`)."""
    arrays: dict[str, Any] = {
        "upper": shoelast.upper.net_mm,
        "upper_v": shoelast.upper.knots_v,
        "bottom": shoelast.bottom.net_mm,
        "bottom_t": shoelast.bottom.knots_t,
        "bottom_s": shoelast.bottom.knots_s,
        "cone": shoelast.cone_top.net_mm,
        "cone_t": shoelast.cone_top.knots_t,
        "cone_s": shoelast.cone_top.knots_s,
    }
    arrays |= {_LINE + name: xyz for name, xyz in shoelast.lines.items()}
    arrays |= {_POINT + name: xyz for name, xyz in shoelast.points.items()}
    for number, part in enumerate(shoelast.attachments):
        arrays[f"{_PART}{number} {part.kind} xyz"] = np.asarray(part.mesh.vertices)
        arrays[f"{_PART}{number} {part.kind} faces"] = np.asarray(part.mesh.faces)
    text = np.frombuffer(json.dumps(dict(about)).encode(), dtype=np.uint8)
    stream = io.BytesIO()
    np.savez_compressed(stream, **{_ABOUT: text}, **arrays)
    return stream.getvalue()


def load_about(path: Path) -> dict[str, Any]:
    """Only the texts and dimensions of a stored last.

    Raises:
        InputError: No such file, or no last of this format.
    """
    try:
        with np.load(path, allow_pickle=False) as arrays:
            about = json.loads(bytes(arrays[_ABOUT]))
    except (OSError, ValueError, KeyError, zipfile.BadZipFile) as err:
        raise InputError(f"{path} is no stored last ({err}); add the last again with `footscan lasts add`.") from err
    if about.get("format") != FORMAT:
        raise InputError(
            f"{path} has the format {about.get('format')!r}, this program reads {FORMAT}; update footscan."
        )
    return about


def load_shoelast(path: Path) -> Shoelast:
    """A stored last.

    Raises:
        InputError: No such file, or no last of this format.
    """
    about = load_about(path)
    try:
        with np.load(path, allow_pickle=False) as stored:
            arrays = {name: cast("Floats", stored[name]) for name in stored.files if name != _ABOUT}
    except (OSError, ValueError, zipfile.BadZipFile) as err:
        raise InputError(f"{path} is damaged ({err}); add the last again with `footscan lasts add`.") from err
    return Shoelast(
        name=str(about["name"]),
        side=cast("Side", about["side"]),
        upper=SplineTube(arrays["upper"], arrays["upper_v"]),
        bottom=ChordDisc(arrays["bottom"], arrays["bottom_s"], arrays["bottom_t"]),
        cone_top=ChordDisc(arrays["cone"], arrays["cone_s"], arrays["cone_t"]),
        style=str(about["style"]),
        size_eu=about["size_eu"],
        fitting=str(about["fitting"]),
        lines=_named(arrays, _LINE),
        points=_named(arrays, _POINT),
        attachments=_attachments(arrays),
        remarks=tuple(about["remarks"]),
    )


def _named(arrays: Mapping[str, Floats], prefix: str) -> dict[str, Floats]:
    return {name.removeprefix(prefix): xyz for name, xyz in arrays.items() if name.startswith(prefix)}


def _attachments(arrays: Mapping[str, Floats]) -> tuple[Attachment, ...]:
    names = sorted(name for name in arrays if name.startswith(_PART) and name.endswith(" xyz"))
    return tuple(
        Attachment(
            name.split(" ")[2],
            trimesh.Trimesh(arrays[name], arrays[name.removesuffix("xyz") + "faces"], process=False),
        )
        for name in names
    )
