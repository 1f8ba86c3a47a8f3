"""What a calibration recording shows: corners in the unlit frames, and the unlit frame of each lit one."""

from collections import Counter
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from footscan.calibration.charuco import BoardCorners, BoardFinder, corners_mm, why_not_found
from footscan.calibration.sightings import Corners, FrameTimes, resting_counts
from footscan.config import Board
from footscan.coordinates import LASER_NAMES, Bools, Frame, pixel_from_uv
from footscan.errors import RecordingError
from footscan.scanning.angles import frame_angles
from footscan.scanning.frames import UnusableFrameError, read_frame
from footscan.scanning.recording import FrameRecord, Recording

Progress = Callable[[int, int], None]
EMPTY = "empty"
FEWEST_PLACEMENTS = 3
FEWEST_VIEWS = 2
FEWEST_MOVING = 5
_SAME_STOP_COUNTS = 0.5
_LONGEST_LATENCY_S = 0.05
_SAMPLES = 8


@dataclass(frozen=True)
class Intake:
    """What the frames of a calibration recording show.

    Attributes:
        recording: Where it comes from.
        board: The board used, with measured lengths if there are any.
        placement_names: Setups in which the board was seen, in order of time.
        times: Times of all frames.
        corners: Corners in all unlit frames.
        pairs: (lit, unlit) frame indices of the same stop.
        rejected: Frames that could not be used, by reason.
        without_board: Placements in which the board was never seen.
    """

    recording: Recording
    board: Board
    placement_names: tuple[str, ...]
    times: FrameTimes
    corners: Corners
    pairs: tuple[tuple[int, int], ...]
    rejected: Counter[str]
    without_board: tuple[str, ...]

    def placement_of(self, setup: str) -> int:
        """The number of a placement; -1 of the bare footboard."""
        return -1 if setup == EMPTY else self.placement_names.index(setup)


def take_in(
    recording: Recording,
    board: Board | None = None,
    progress: Progress = lambda done, total: None,
    fewest: int = FEWEST_PLACEMENTS,
) -> Intake:
    """Find the board in every unlit frame, and the unlit frame of every lit one.

    Args:
        recording: A calibration recording.
        board: The board, when its lengths were measured after the recording was made.
        progress: Called with frames done and frames in all.
        fewest: Placements needed: fewer are enough for a check than for a calibration.

    Raises:
        RecordingError: Not a calibration, frames missing, or the board was not found; the reason is named.
    """
    board = _checked(recording, board)
    unlit = [k for k, record in enumerate(recording.frames) if record.laser == "none" and record.setup != EMPTY]
    found, rejected = _find_all(recording, board, unlit, progress)
    seen = {k: corners for k, corners in found.items() if corners is not None}
    setups = list(dict.fromkeys(recording.frames[k].setup for k in unlit))
    at_stops = Counter(recording.frames[k].setup for k in seen if recording.frames[k].sweep == "static")
    names = tuple(setup for setup in setups if at_stops[setup] >= FEWEST_VIEWS)
    if len(names) < fewest:
        raise RecordingError(_too_few(recording, board, names, setups, unlit, rejected, fewest))
    kept = {k: corners for k, corners in seen.items() if recording.frames[k].setup in names}
    if fewest >= FEWEST_PLACEMENTS:
        _refuse_unmoved(recording, kept)
    times = _times(recording)
    corners = _flat(recording, board, names, kept)
    pairs = _pairs(recording, names)
    missing = tuple(setup for setup in setups if setup not in names)
    return Intake(recording, board, names, times, corners, pairs, rejected, missing)


def _refuse_unmoved(recording: Recording, seen: dict[int, BoardCorners]) -> None:
    moving = sum(recording.frames[k].sweep != "static" for k in seen)
    if moving < FEWEST_MOVING:
        taken = sum(record.sweep != "static" for record in recording.frames)
        raise RecordingError(
            f"the board is seen in {moving} of {taken} frames taken while the head turned, at least {FEWEST_MOVING} "
            "are needed: without them nobody knows how late frames are stamped. Record two sweeps past a placement."
        )


def _checked(recording: Recording, board: Board | None) -> Board:
    own = board or recording.board
    if recording.info.kind != "calibration" or own is None:
        raise RecordingError(
            f"{recording.folder} is a {recording.info.kind} recording; calibrate needs a calibration recording."
        )
    lit = Counter(record.laser for record in recording.frames if record.setup == EMPTY)
    for name in LASER_NAMES:
        if not lit[name]:
            raise RecordingError(
                f"{recording.folder} has no frames of the bare footboard with the {name} laser: without them the "
                "height of the footboard is unknown. Record the empty footboard too."
            )
    return own


def _find_all(
    recording: Recording, board: Board, unlit: list[int], progress: Progress
) -> tuple[dict[int, BoardCorners | None], Counter[str]]:
    """Corners per frame; frames that cannot be read are counted by reason."""
    rejected: Counter[str] = Counter()
    found: dict[int, BoardCorners | None] = {}

    def look(own: list[int]) -> list[tuple[int, BoardCorners | None, str]]:
        finder = BoardFinder(board)
        return [_look(recording, finder, k) for k in own]

    batches = [unlit[start : start + 16] for start in range(0, len(unlit), 16)]
    with ThreadPoolExecutor(max_workers=2) as pool:
        for done, batch in enumerate(pool.map(look, batches), start=1):
            progress(min(done * 16, len(unlit)), len(unlit))
            for k, corners, reason in batch:
                found[k] = corners
                rejected.update([reason] if reason else [])
    return found, rejected


def _look(recording: Recording, finder: BoardFinder, k: int) -> tuple[int, BoardCorners | None, str]:
    try:
        frame = read_frame(recording.path(recording.frames[k]), recording.scanner.camera)
    except UnusableFrameError as err:
        return k, None, err.reason
    return k, finder.find(frame), ""


def _too_few(
    recording: Recording,
    board: Board,
    names: tuple[str, ...],
    setups: list[str],
    unlit: list[int],
    rejected: Counter[str],
    fewest: int,
) -> str:
    advice = f"at least {fewest} placements, differently turned and leaning, are needed"
    if rejected.total() > len(unlit) // 2:
        reasons = ", ".join(f"{count} x {reason}" for reason, count in rejected.most_common(3))
        return f"{rejected.total()} of {len(unlit)} unlit frames cannot be used ({reasons}); record or copy them again."
    if len(setups) < fewest:
        return f"the recording holds {len(setups)} placements of the board; {advice}. Record more."
    if names:
        missing = ", ".join(setup for setup in setups if setup not in names)
        return f"the board was found in {len(names)} placements only (not in {missing}); {advice}. Repeat those."
    samples = _sample_frames(recording, unlit)
    return f"the board was not found in any of {len(unlit)} unlit frames: {why_not_found(board, samples)}."


def _sample_frames(recording: Recording, unlit: list[int]) -> list[Frame]:
    """The brightest of the unlit frames: where a board faces the camera, it fills the picture."""
    frames: list[Frame] = []
    for k in unlit[:: max(1, len(unlit) // 48)]:
        try:
            frames.append(read_frame(recording.path(recording.frames[k]), recording.scanner.camera))
        except UnusableFrameError:
            continue  # counted by the caller
    return sorted(frames, key=lambda frame: -float(frame.mean()))[:_SAMPLES]


def _flat(recording: Recording, board: Board, names: tuple[str, ...], seen: dict[int, BoardCorners]) -> Corners:
    """All corners as flat arrays; frames at an unknown angle are left out."""
    known = _known_angle(recording)
    usable = [(k, corners) for k, corners in sorted(seen.items()) if known[k]]
    xy_board, records = corners_mm(board), recording.frames
    count = [len(corners.number) for _, corners in usable]
    height_px = recording.scanner.camera.height_px
    return Corners(
        frame=np.repeat([k for k, _ in usable], count).astype(np.int64),
        placement=np.repeat([names.index(records[k].setup) for k, _ in usable], count).astype(np.int64),
        xy_board=np.concatenate([xy_board[corners.number] for _, corners in usable]),
        yz_pixel=np.concatenate([pixel_from_uv(corners.uv, height_px) for _, corners in usable]),
        moving=np.repeat([records[k].sweep != "static" for k, _ in usable], count).astype(np.bool_),
    )


def _times(recording: Recording) -> FrameTimes:
    time_s = np.array([record.time_s for record in recording.frames])
    moving = np.array([record.sweep != "static" for record in recording.frames])
    return FrameTimes(time_s, moving, recording.encoder)


def _known_angle(recording: Recording) -> Bools:
    """Whether the angle of each frame `(m,)` is known, on the move whatever the latency turns out to be."""
    times, encoder = _times(recording), recording.scanner.encoder
    now, late = (
        frame_angles(times.time_s, latency_s, recording.encoder, encoder).known
        for latency_s in (0.0, _LONGEST_LATENCY_S)
    )
    return now & (late | ~times.moving)


def _pairs(recording: Recording, names: tuple[str, ...]) -> tuple[tuple[int, int], ...]:
    """Each lit frame at a stop with the unlit one of the same setup and count that is nearest in time."""
    time_s = np.array([record.time_s for record in recording.frames])
    count = resting_counts(time_s, recording.encoder)
    unlit: dict[str, list[int]] = {}
    for k, record in enumerate(recording.frames):
        if record.laser == "none" and record.sweep == "static":
            unlit.setdefault(record.setup, []).append(k)

    def partner(k: int, record: FrameRecord) -> int | None:
        same = [j for j in unlit.get(record.setup, []) if abs(count[j] - count[k]) < _SAME_STOP_COUNTS]
        return min(same, key=lambda j: abs(time_s[j] - time_s[k])) if same else None

    lit = [
        (k, partner(k, record))
        for k, record in enumerate(recording.frames)
        if record.laser != "none" and record.sweep == "static" and record.setup in (*names, EMPTY)
    ]
    return tuple((k, j) for k, j in lit if j is not None)
