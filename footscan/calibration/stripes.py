"""Stripe places in the lit frames of a calibration recording: on the board's front, and on the footboard.

The unlit frame of the same stop is subtracted, so that the pattern of the board does not hide the stripe. Where the
pattern changes under the stripe its brightness is lopsided; such places are marked and weigh less.
"""

from concurrent.futures import ThreadPoolExecutor

import cv2
import numpy as np

from footscan.calibration.charuco import half_size_mm
from footscan.calibration.estimate import Estimate
from footscan.calibration.intake import Intake, Progress
from footscan.calibration.misfit import head_angles, stripe_points_head, stripe_scale_mm_per_px
from footscan.calibration.sightings import FLOOR_PLACEMENT, Sightings, StripePoints
from footscan.coordinates import LASER_NAMES, Bools, Floats, Frame, pixel_from_uv
from footscan.geometry.rigid import inverse_rigid
from footscan.optics.calibration import optical_centre_world
from footscan.scanning.filters import FilterSettings, filtered
from footscan.scanning.frames import UnusableFrameError, read_frame
from footscan.scanning.stripe import StripeFinder, automatic_threshold

_LEAST_THRESHOLD = 14
_PATTERN_PX = 7
_PATTERN_GREY = 25
_INSIDE_MM = 2.0
_FLOOR_RADIUS_MM = 190.0
_COARSEST_MM_PER_PX = 3.0
_BOARD_KEEP, _FLOOR_KEEP = 3, 4
"""Every n-th place is used: neighbours along a stripe share their errors, so more of them only take time."""
_LEAST_COSINE = 0.1


def find_stripes(intake: Intake, progress: Progress = lambda done, total: None) -> StripePoints:
    """Find stripes in all lit frames at stops; frames that cannot be read are skipped."""
    pairs = intake.pairs

    def look(batch: tuple[tuple[int, int], ...]) -> list[tuple[int, Floats, Bools]]:
        finder = StripeFinder()
        return [result for pair in batch if (result := _look(intake, finder, *pair)) is not None]

    batches = [pairs[start : start + 16] for start in range(0, len(pairs), 16)]
    found: list[tuple[int, Floats, Bools]] = []
    with ThreadPoolExecutor(max_workers=2) as pool:
        for done, part in enumerate(pool.map(look, batches), start=1):
            progress(min(16 * done, len(pairs)), len(pairs))
            found += part
    return _flat(intake, found)


def _flat(intake: Intake, found: list[tuple[int, Floats, Bools]]) -> StripePoints:
    records = intake.recording.frames
    count = [len(uv) for _, uv, _ in found]

    def per_frame(values: list[int]) -> np.ndarray:
        return np.repeat(np.array(values, dtype=np.int64), count)

    uv = np.concatenate([uv for _, uv, _ in found]) if found else np.zeros((0, 2))
    plain = np.concatenate([plain for _, _, plain in found]) if found else np.zeros(0, dtype=bool)
    return StripePoints(
        per_frame([k for k, _, _ in found]),
        per_frame([intake.placement_of(records[k].setup) for k, _, _ in found]),
        per_frame([int(records[k].laser == LASER_NAMES[1]) for k, _, _ in found]),
        pixel_from_uv(uv, intake.recording.scanner.camera.height_px),
        plain,
    )


def _look(intake: Intake, finder: StripeFinder, lit: int, unlit: int) -> tuple[int, Floats, Bools] | None:
    try:
        bright, dark = _both(intake, lit, unlit)
    except UnusableFrameError as err:
        intake.rejected.update([err.reason])
        return None
    stripe_only = filtered(bright, FilterSettings("unlit"), dark)
    stripe = finder.find(stripe_only, max(_LEAST_THRESHOLD, automatic_threshold(stripe_only)))
    return lit, stripe.uv, _plain(dark, stripe.uv)


def _both(intake: Intake, lit: int, unlit: int) -> tuple[Frame, Frame]:
    recording = intake.recording
    bright, dark = (read_frame(recording.path(recording.frames[k]), recording.scanner.camera) for k in (lit, unlit))
    return bright, dark


def lit_stripe(intake: Intake, lit: int, unlit: int) -> Frame | None:
    """A lit frame minus its unlit one; nothing where one of them cannot be read."""
    try:
        bright, dark = _both(intake, lit, unlit)
    except UnusableFrameError:
        return None  # counted when stripes were looked for
    return filtered(bright, FilterSettings("unlit"), dark)


def _plain(dark: Frame, uv: Floats) -> Bools:
    """Whether the unlit picture is even around each place."""
    window = np.ones((_PATTERN_PX, _PATTERN_PX), dtype=np.uint8)
    spread = np.asarray(cv2.subtract(cv2.dilate(dark, window), cv2.erode(dark, window)))
    column, row = np.round(uv).astype(np.int64).T
    return spread[row, column] < _PATTERN_GREY


def assign_stripes(raw: StripePoints, estimate: Estimate, intake: Intake) -> StripePoints:
    """Say of every stripe place whether it lies on the board's front or on the footboard; drop what is neither."""
    on_board = _on_front(raw, estimate, intake)
    floor = raw.kept(raw.placement == FLOOR_PLACEMENT)
    sightings = Sightings(intake.times, intake.corners, floor, intake.placement_names)
    theta_rad = head_angles(estimate, sightings)
    place = stripe_points_head(estimate, floor, theta_rad)
    near = np.hypot(place[:, 0], place[:, 1]) < _FLOOR_RADIUS_MM
    near &= _fine(estimate, floor, theta_rad)
    near &= np.arange(len(floor)) % _FLOOR_KEEP == 0
    return _joined(on_board, floor.kept(near))


def _on_front(raw: StripePoints, estimate: Estimate, intake: Intake) -> StripePoints:
    points = raw.kept(raw.placement >= 0)
    points = points.kept(np.arange(len(points)) % _BOARD_KEEP == 0)
    sightings = Sightings(intake.times, intake.corners, points, intake.placement_names)
    theta_rad = head_angles(estimate, sightings)
    xy_board, front = _board_places(estimate, points, theta_rad)
    inside = np.all(np.abs(xy_board) < half_size_mm(intake.board) - _INSIDE_MM, axis=1)
    return points.kept(front & inside & _fine(estimate, points, theta_rad))


def _fine(estimate: Estimate, points: StripePoints, theta_rad: Floats) -> Bools:
    """Whether a pixel across the stripe is a small step in space."""
    if not len(points):
        return np.zeros(0, dtype=bool)
    return stripe_scale_mm_per_px(estimate, points, theta_rad) < _COARSEST_MM_PER_PX


def _board_places(estimate: Estimate, points: StripePoints, theta_rad: Floats) -> tuple[Floats, Bools]:
    """Board places `(n, 2)` of stripe places, and whether the camera sees the board's front there."""
    if not len(points):
        return np.zeros((0, 2)), np.zeros(0, dtype=bool)
    xyz_head = stripe_points_head(estimate, points, theta_rad)
    angle = theta_rad[points.frame]
    xyz_world = _turned(xyz_head, angle)
    board_from_world = np.stack([inverse_rigid(pose) for pose in estimate.world_from_board])[points.placement]
    xyz_board = np.einsum("nij,nj->ni", board_from_world[:, :3, :3], xyz_world) + board_from_world[:, :3, 3]
    lens = _turned(np.tile(optical_centre_world(estimate.machine), (len(points), 1)), angle)
    seen_from = np.einsum("nij,nj->ni", board_from_world[:, :3, :3], lens) + board_from_world[:, :3, 3]
    sight = seen_from - xyz_board
    return xyz_board[:, :2], sight[:, 2] < -_LEAST_COSINE * np.linalg.norm(sight, axis=1)


def _turned(xyz_head: Floats, theta_rad: Floats) -> Floats:
    c, s = np.cos(theta_rad), np.sin(theta_rad)
    x, y, z = xyz_head.T
    return np.stack([c * x - s * y, s * x + c * y, z], axis=-1)


def _joined(one: StripePoints, other: StripePoints) -> StripePoints:
    return StripePoints(*(np.concatenate([getattr(one, k), getattr(other, k)]) for k in one.__dataclass_fields__))
