"""Draw the laser's light into the picture: short strokes of each light curve as blurred Gaussian spots.

A sheet of finite width is several thin sheets beside each other (the layers); each is cut, shadowed and drawn on its
own, so that edges, curvature and silhouettes shape the stripe as they do in reality. The blur of the lens is added to
each spot's covariance, which is exact for Gaussian blur.
"""

import numpy as np

from footscan.compiled import compiled, compiled_inline
from footscan.coordinates import Floats, Floats32
from footscan.sim.board_print import Print, laser_share
from footscan.sim.depth import is_seen
from footscan.sim.optics_loops import project
from footscan.sim.shadow import is_lit

STROKE_PX = 0.5
"""Longest stroke; below the blur's sigma, so that a row of spots is smooth."""
MOST_STROKES, BESIDE_PX = 20_000.0, 200.0
"""More than any picture is wide, for pieces just in front of the lens; and how far beside it nothing is drawn."""
SHALLOWEST = 0.05
"""Smallest sine between surface and sheet for which the stripe still widens."""
WIDEST_PX = 12.0
_REACH_SIGMAS = 3.4
_PROBE_MM = 0.02

# Indices of the numbers that describe the light for the loops.
LASER_X, LASER_Y, GREY, LAYER_SIGMA, BLUR_PX, SPREAD_SHARE, SPREAD_MM, TWO_SIDED = range(8)
NUMBERS = 8


@compiled
def draw_light(
    pieces: Floats,
    tone: Floats,
    begin: int,
    end: int,
    z_light: float,
    numbers: Floats,
    eye: Floats,
    floor: Floats,
    camera_from_light: Floats,
    lens: Floats,
    nearest_to_laser: Floats,
    nearest_to_camera: Floats32,
    printed: Print,
    picture: Floats32,
) -> None:
    """Add the light of one layer of the sheet on some pieces of its curve.

    Args:
        pieces: `(n, 7)` of `cut.Cut`.
        tone: `(n,)` light that comes back from each piece, relative to the grey value of its surface.
        begin: First piece to draw.
        end: One after the last.
        z_light: Distance of the layer from the middle of the sheet, mm.
        numbers: `(NUMBERS,)`: laser place (mm), grey value of a surface facing the laser at the axis, sigma of the
            layer (mm), sigma of the blur (px), share and sigma (mm) of light spread inside the skin, 1 for an open
            surface.
        eye: `(3,)` optical centre in the light system.
        floor: `(4,)` plane of the board in the light system; what lies below is not drawn.
        camera_from_light: 4x4.
        lens: `lens_numbers`.
        nearest_to_laser: `find_nearest` of this layer.
        nearest_to_camera: Depth picture.
        printed: What is printed on the surface; its matrix comes from the light system.
        picture: `(height, width)` grey values, changed.
    """
    laser_x, laser_y, spread = numbers[LASER_X], numbers[LASER_Y], numbers[SPREAD_SHARE]
    has_print, eye_x, eye_z = printed[1].size > 0, 0.0, 0.0
    if has_print:
        m = printed[0]
        eye_x = m[0, 0] * eye[0] + m[0, 1] * eye[1] + m[0, 2] * eye[2] + m[0, 3]
        eye_z = m[2, 0] * eye[0] + m[2, 1] * eye[1] + m[2, 2] * eye[2] + m[2, 3]
    for i in range(begin, end):
        piece = pieces[i]
        grey = tone[i] * _grey_of_surface(piece, z_light, numbers, eye)
        if grey <= 0.0:
            continue
        strokes, light, uu, uv, vv, wide = find_strokes(
            piece, z_light, grey, numbers, camera_from_light, lens, picture.shape[0], picture.shape[1]
        )
        for k in range(strokes):
            t = (k + 0.5) / strokes
            x, y = piece[0] + t * (piece[2] - piece[0]), piece[1] + t * (piece[3] - piece[1])
            if floor[0] * x + floor[1] * y + floor[2] * z_light < floor[3]:
                continue
            if not is_lit(x, y, laser_x, laser_y, nearest_to_laser):
                continue
            u, v, inverse = project(x, y, z_light, camera_from_light, lens)
            if is_seen(u, v, inverse, nearest_to_camera):
                here = light * laser_share(x, y, z_light, eye_x, eye_z, printed) if has_print else light
                add_spot(picture, u, v, here * (1.0 - spread), uu, uv, vv)
                if spread > 0.0:
                    add_spot(picture, u, v, here * spread, uu + wide, uv, vv + wide)


@compiled_inline
def _beside(begin_px: float, end_px: float, size_px: int) -> bool:
    """A piece lies wholly and well beside the picture; one just in front of the lens is millions of pixels long."""
    return max(begin_px, end_px) < -BESIDE_PX or min(begin_px, end_px) > size_px + BESIDE_PX


@compiled
def find_strokes(
    piece: Floats,
    z_light: float,
    grey: float,
    numbers: Floats,
    camera_from_light: Floats,
    lens: Floats,
    height: int,
    width: int,
) -> tuple[int, float, float, float, float, float]:
    """How a piece is drawn: number of strokes (0 behind the lens and beside the picture), light of each, covariance
    (uu, uv, vv) of its spot and what the spread inside the skin adds to it (px^2)."""
    x, y = 0.5 * (piece[0] + piece[2]), 0.5 * (piece[1] + piece[3])
    nx, ny, nz = piece[4], piece[5], piece[6]
    u0, v0, inverse0 = project(piece[0], piece[1], z_light, camera_from_light, lens)
    u1, v1, inverse1 = project(piece[2], piece[3], z_light, camera_from_light, lens)
    if inverse0 <= 0.0 or inverse1 <= 0.0:
        return 0, 0.0, 0.0, 0.0, 0.0, 0.0
    if _beside(u0, u1, width) or _beside(v0, v1, height):
        return 0, 0.0, 0.0, 0.0, 0.0, 0.0
    sine = np.sqrt(max(1.0 - nz * nz, 1e-12))
    probe = _PROBE_MM / sine
    u, v, inverse = project(x, y, z_light, camera_from_light, lens)
    au, av, _ = project(
        x - nz * nx * probe, y - nz * ny * probe, z_light + sine * sine * probe, camera_from_light, lens
    )
    sigma_mm = numbers[LAYER_SIGMA] / max(sine, SHALLOWEST)
    across_u, across_v = _limited((au - u) / _PROBE_MM, (av - v) / _PROBE_MM, sigma_mm)
    count = max(int(np.ceil(min(np.hypot(u1 - u0, v1 - v0) / STROKE_PX, MOST_STROKES))), 1)
    along_u, along_v = (u1 - u0) / count, (v1 - v0) / count
    light = grey * np.sqrt(2.0 * np.pi) * abs(along_u * across_v - along_v * across_u)
    blur2 = numbers[BLUR_PX] * numbers[BLUR_PX]
    uu = across_u * across_u + along_u * along_u / 12.0 + blur2
    uv = across_u * across_v + along_u * along_v / 12.0
    vv = across_v * across_v + along_v * along_v / 12.0 + blur2
    spread_px = numbers[SPREAD_MM] * lens[6] * inverse / (0.5 * (lens[0] + lens[1]))
    return count, light, uu, uv, vv, spread_px * spread_px


@compiled_inline
def _grey_of_surface(piece: Floats, z: float, numbers: Floats, eye: Floats) -> float:
    """Lambert's cosine times the falloff of a fan of light (1 / distance); 0 where laser or camera is behind."""
    x, y = 0.5 * (piece[0] + piece[2]), 0.5 * (piece[1] + piece[3])
    nx, ny, nz = piece[4], piece[5], piece[6]
    to_x, to_y = numbers[LASER_X] - x, numbers[LASER_Y] - y
    distance = np.hypot(to_x, to_y)
    cosine = (nx * to_x + ny * to_y) / distance
    facing = nx * (eye[0] - x) + ny * (eye[1] - y) + nz * (eye[2] - z)
    if numbers[TWO_SIDED] > 0.0 and cosine < 0.0:
        cosine, facing = -cosine, -facing
    if cosine <= 0.0 or facing <= 0.0:
        return 0.0
    return numbers[GREY] * cosine * abs(numbers[LASER_X]) / distance


@compiled_inline
def _limited(per_mm_u: float, per_mm_v: float, sigma_mm: float) -> tuple[float, float]:
    """One sigma of the layer across the stripe in the picture (px), no longer than `WIDEST_PX`."""
    width = np.hypot(per_mm_u, per_mm_v) * sigma_mm
    scale = sigma_mm * min(1.0, WIDEST_PX / max(width, 1e-9))
    return per_mm_u * scale, per_mm_v * scale


@compiled
def add_spot(picture: Floats32, u: float, v: float, light: float, uu: float, uv: float, vv: float) -> None:
    """Add a Gaussian spot with a total of `light` (grey values x px) and covariance (uu, uv, vv) in px^2.

    Each row is run through by the recurrence of a Gaussian: two multiplications a pixel instead of an exponential.
    """
    height, width = picture.shape
    determinant = uu * vv - uv * uv
    reach_u, reach_v = _REACH_SIGMAS * np.sqrt(uu), _REACH_SIGMAS * np.sqrt(vv)
    top, bottom = max(int(np.ceil(v - reach_v)), 0), min(int(np.floor(v + reach_v)), height - 1)
    left, right = int(np.ceil(u - reach_u)), min(int(np.floor(u + reach_u)), width - 1)
    left = max(left, 0)
    a, b, c = vv / determinant, -uv / determinant, uu / determinant
    peak = light / (2.0 * np.pi * np.sqrt(determinant))
    bend = np.exp(-a)
    for row in range(top, bottom + 1):
        dv, du = row - v, left - u
        value = peak * np.exp(-0.5 * (a * du * du + 2.0 * b * du * dv + c * dv * dv))
        ratio = np.exp(-(a * (du + 0.5) + b * dv))
        for column in range(left, right + 1):
            picture[row, column] += np.float32(value)
            value *= ratio
            ratio *= bend
