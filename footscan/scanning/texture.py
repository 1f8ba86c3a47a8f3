"""The grey of the skin, from the frames taken without laser: each vertex as those show it that look at it best."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import map_coordinates

from footscan.coordinates import Bools, Floats, Frame, Ints, uv_from_pixel
from footscan.geometry.raster import front_facets
from footscan.optics.calibration import Calibration, camera_from_world, optical_centre_world
from footscan.optics.camera import Camera, pixel_from_camera
from footscan.scanning.angles import frame_angles
from footscan.scanning.frames import UnusableFrameError, read_frame
from footscan.scanning.recording import FrameRecord, Recording

MOST_FRAMES = 72
_BEHIND_MM = 4.0  # a vertex this much behind the facet in front of it is hidden
_LEAST_COSINE = 0.15


@dataclass(frozen=True)
class SkinTexture:
    """Grey value `(n,)` of each vertex, 0 to 255, NaN where no unlit frame shows it, and how many do `(n,)`."""

    grey: Floats
    views: Ints


def texture_from_unlit(
    recording: Recording, calibration: Calibration, xyz_world: Floats, normal_world: Floats, faces: Ints
) -> SkinTexture | None:
    """Look a mesh's grey up in the unlit frames of its recording; None if there are none.

    Args:
        recording: With frames without laser.
        calibration: Of its machine.
        xyz_world: `(n, 3)` vertices.
        normal_world: `(n, 3)` outward unit normals.
        faces: `(m, 3)`.
    """
    unlit = [record for record in recording.frames if record.laser == "none" and record.sweep != "static"]
    if not unlit:
        return None
    chosen = unlit[:: -(-len(unlit) // MOST_FRAMES)]
    time_s = np.array([record.time_s for record in chosen])
    angles = frame_angles(time_s, calibration.latency_s, recording.encoder, calibration.encoder)
    total, weight = np.zeros(len(xyz_world)), np.zeros(len(xyz_world))
    views = np.zeros(len(xyz_world), np.int64)
    for record, theta_rad, known in zip(chosen, angles.theta_rad, angles.known, strict=True):
        frame = _frame(recording, record) if known else None
        if frame is None:
            continue
        grey, share = _seen_in(frame, calibration, float(theta_rad), xyz_world, normal_world, faces)
        total, weight, views = total + share * grey, weight + share, views + (share > 0)
    with np.errstate(invalid="ignore"):
        return SkinTexture(np.where(weight > 0, total / weight, np.nan), views)


def _frame(recording: Recording, record: FrameRecord) -> Frame | None:
    try:
        return read_frame(recording.path(record), recording.scanner.camera)
    except UnusableFrameError:
        return None  # counted and named where the stripes are read


def _seen_in(
    frame: Frame, calibration: Calibration, theta_rad: float, xyz_world: Floats, normal_world: Floats, faces: Ints
) -> tuple[Floats, Floats]:
    """Grey of each vertex in one frame, and its weight: the squared cosine to the camera, 0 where hidden."""
    camera_from = camera_from_world(calibration, theta_rad)
    xyz_camera = xyz_world @ camera_from[:3, :3].T + camera_from[:3, 3]
    uv = uv_from_pixel(pixel_from_camera(xyz_camera, calibration.camera), calibration.camera.height_px)
    to_eye = optical_centre_world(calibration, theta_rad) - xyz_world
    cosine = np.sum(normal_world * to_eye, axis=1) / np.linalg.norm(to_eye, axis=1)
    seen = (cosine > _LEAST_COSINE) & _inside(uv, calibration.camera)
    seen[seen] = _in_front(uv, xyz_camera[:, 0], faces, seen, calibration.camera)
    grey = map_coordinates(frame.astype(np.float64), uv.T[::-1], order=1, mode="nearest")
    return grey, np.where(seen, cosine**2, 0.0)


def _inside(uv: Floats, camera: Camera) -> Bools:
    low, high = np.zeros(2), np.array([camera.width_px - 1.0, camera.height_px - 1.0])
    return np.all((uv >= low) & (uv <= high), axis=1)


def _in_front(uv: Floats, depth_mm: Floats, faces: Ints, asked: Bools, camera: Camera) -> Bools:
    """Which of the asked vertices no facet hides."""
    corners = np.column_stack([uv, -depth_mm])[faces]
    facet = front_facets(corners, np.array([-0.5, -0.5]), 1.0, (camera.height_px, camera.width_px))
    column, row = np.rint(uv[asked]).astype(np.int64).T
    in_front = facet[row, column]
    nearest_mm = depth_mm[faces].mean(axis=1)
    return (in_front < 0) | (depth_mm[asked] <= nearest_mm[in_front] + _BEHIND_MM)
