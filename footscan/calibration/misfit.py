"""Where an estimate says corners and stripes should be, against where they were seen."""

from dataclasses import replace

import numpy as np

from footscan.calibration.estimate import SHAPE, Estimate
from footscan.calibration.sightings import FLOOR_PLACEMENT, Corners, Sightings, StripePoints
from footscan.coordinates import Floats, Ints
from footscan.geometry.rigid import inverse_rigid
from footscan.optics import Calibration
from footscan.optics.calibration import camera_from_world, theta_from_encoder
from footscan.optics.camera import image_from_pixel, ray_from_undistorted, undistorted_from_distorted

_LEAST_SLOPE = 1e-6


def head_angles(estimate: Estimate, sightings: Sightings) -> Floats:
    """Head angle (rad) of every frame `(m,)`."""
    machine = estimate.machine
    return theta_from_encoder(sightings.times.counts(machine.latency_s), machine.encoder)


def corner_misfit_px(estimate: Estimate, corners: Corners, theta_rad: Floats) -> Floats:
    """Seen minus expected place of `(n,)` corners, `(n, 2)` px along y_F and z_F; NaN for a corner behind the lens.

    Both are compared after the distortion of the seen one is removed (eq. 14): so nothing has to be inverted, and a
    wild trial of K1 and K2 cannot fold the picture.
    """
    xyz_world = board_points(estimate, corners.placement, corners.xy_board)
    xyz_head = _turned_back(xyz_world, theta_rad[corners.frame])
    camera_from_head = camera_from_world(estimate.machine)
    xyz_camera = xyz_head @ camera_from_head[:3, :3].T + camera_from_head[:3, 3]
    camera = estimate.machine.camera
    depth = xyz_camera[:, 0] - camera.focal_length_mm
    reach = np.where(depth > 0.0, -camera.focal_length_mm / np.where(depth > 0.0, depth, 1.0), np.nan)
    seen = corners.yz_pixel - estimate.doubts[corners.placement, len(SHAPE) :]
    off_mm = undistorted_from_distorted(image_from_pixel(seen, camera), camera) - xyz_camera[:, 1:] * reach[:, None]
    return off_mm / np.array([camera.horizontal_scale * camera.pixel_pitch_y_mm, -camera.pixel_pitch_z_mm])


def board_points(estimate: Estimate, placement: Ints, xy_board: Floats) -> Floats:
    """World places `(n, 3)` of board places `(n, 2)`, with the stretch and bend that is doubted."""
    stretch_x, stretch_y, bend_xx, bend_yy, bend_xy = estimate.doubts[placement, : len(SHAPE)].T
    x, y = xy_board.T
    xyz_board = np.stack(
        [x * (1.0 + stretch_x), y * (1.0 + stretch_y), bend_xx * x * x + bend_yy * y * y + bend_xy * x * y], axis=-1
    )
    pose = estimate.world_from_board[placement]
    return np.einsum("nij,nj->ni", pose[:, :3, :3], xyz_board) + pose[:, :3, 3]


def stripe_points_head(estimate: Estimate, stripes: StripePoints, theta_rad: Floats) -> Floats:
    """Where the rays of stripe places meet their board or the footboard: `(n, 3)` mm in W turned back to theta = 0."""
    camera = estimate.machine.camera
    yz_pixel = stripes.yz_pixel
    if np.any(estimate.doubts[:, len(SHAPE) :]):
        shift = np.vstack([estimate.doubts[:, len(SHAPE) :], np.zeros(2)])  # the last row serves the footboard, -1
        yz_pixel = yz_pixel - shift[stripes.placement]
    ray = ray_from_undistorted(undistorted_from_distorted(image_from_pixel(yz_pixel, camera), camera), camera)
    head_from_camera = inverse_rigid(camera_from_world(estimate.machine))
    ray_head = ray @ head_from_camera[:3, :3].T
    centre = head_from_camera @ np.array([camera.focal_length_mm, 0.0, 0.0, 1.0])
    normal, offset = _planes_head(estimate, stripes, theta_rad)
    slope = np.einsum("ni,ni->n", normal, ray_head)
    slope = np.where(np.abs(slope) < _LEAST_SLOPE, _LEAST_SLOPE, slope)
    reach = (offset - normal @ centre[:3]) / slope
    return centre[:3] + reach[:, None] * ray_head


def stripe_misfit_mm(estimate: Estimate, stripes: StripePoints, theta_rad: Floats) -> Floats:
    """Distance `(n,)` of stripe places, carried on to their board or the footboard, from their laser's sheet."""
    if not len(stripes):
        return np.zeros(0)
    return sheet_misfit_mm(estimate.machine, stripes, stripe_points_head(estimate, stripes, theta_rad))


def sheet_misfit_mm(machine: Calibration, stripes: StripePoints, xyz_head: Floats) -> Floats:
    """Distance `(n,)` of places `(n, 3)` in W at theta = 0 from the sheet of the laser that lit them."""
    normal = np.array([sheet.normal for sheet in machine.lasers])[stripes.laser]
    offset = np.array([sheet.offset_mm for sheet in machine.lasers])[stripes.laser]
    return np.einsum("ni,ni->n", normal, xyz_head) - offset


def stripe_scale_mm_per_px(estimate: Estimate, stripes: StripePoints, theta_rad: Floats) -> Floats:
    """How far `(n,)` a stripe place leaves its sheet, in mm, per pixel across the stripe."""
    slopes = []
    for shift in np.eye(2) * 0.5:
        ahead, behind = (replace(stripes, yz_pixel=stripes.yz_pixel + sign * shift) for sign in (1.0, -1.0))
        slopes.append(stripe_misfit_mm(estimate, ahead, theta_rad) - stripe_misfit_mm(estimate, behind, theta_rad))
    return np.hypot(slopes[0], slopes[1])


def _planes_head(estimate: Estimate, stripes: StripePoints, theta_rad: Floats) -> tuple[Floats, Floats]:
    """Normal `(n, 3)` and offset `(n,)` of the board or footboard under each place, turned back to theta = 0."""
    floor = estimate.machine.floor
    normals = np.vstack([estimate.world_from_board[:, :3, 2], floor.normal_array])
    middles = estimate.world_from_board[:, :3, 3]
    offsets = np.append(np.einsum("pi,pi->p", normals[:-1], middles), floor.offset_mm)
    assert FLOOR_PLACEMENT == -1
    return _turned_back(normals[stripes.placement], theta_rad[stripes.frame]), offsets[stripes.placement]


def _turned_back(xyz_world: Floats, theta_rad: Floats) -> Floats:
    """`(n, 3)` turned by -theta `(n,)` about the axis: from W into W at theta = 0, as the head carries it along."""
    c, s = np.cos(theta_rad), np.sin(theta_rad)
    x, y, z = xyz_world.T
    return np.stack([c * x + s * y, c * y - s * x, z], axis=-1)
