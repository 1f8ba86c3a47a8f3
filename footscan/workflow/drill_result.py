"""What one case of the drill came to, and what it left on disk."""

from dataclasses import dataclass
from pathlib import Path

from footscan.errors import DeviceError
from footscan.optics.camera import Camera
from footscan.scanning.frames import UnusableFrameError, read_frame
from footscan.scanning.recording import open_recording

TARGET_S = 0.3
"""The program lives and reaches its module."""
WATCHDOG_TARGET_S = 1.2
"""It does not: the module switches off by itself."""


@dataclass(frozen=True)
class DrillResult:
    """One case.

    Attributes:
        case: What was broken.
        off_after_s: From the fault to lasers and motor off, as the world saw it.
        told: What the person reads.
        captured: Frames that had come in, named or kept; None where the program is no longer there to be asked.
        named: Frames kept plus frames rejected by name; the same.
        kept: Whole frames in the recording on disk.
        unlisted: Picture files beyond those listed in frames.csv; 1 may be half-written by a killed program.
        target_s: What `off_after_s` may be.
        spoiled: How often a busy computer ended the scan before the drill did; each time it was begun again.
    """

    case: str
    off_after_s: float
    told: str
    captured: int | None
    named: int | None
    kept: int
    unlisted: int
    target_s: float = TARGET_S
    spoiled: int = 0

    @property
    def well(self) -> bool:
        """Off in time, told, and every captured frame still there."""
        return (
            0.0 <= self.off_after_s <= self.target_s
            and bool(self.told)
            and self.captured == self.named
            and self.kept > 0
            and self.unlisted <= 1
        )


def frames_on_disk(folder: Path) -> tuple[int, int]:
    """Whole frames listed in a recording, and picture files that are not listed.

    Raises:
        DeviceError: A listed frame cannot be read.
    """
    recording = open_recording(folder)
    whole = sum(1 for record in recording.frames if _readable(recording.path(record), recording.scanner.camera))
    if whole < len(recording.frames):
        raise DeviceError(f"{folder}: {len(recording.frames) - whole} listed frames cannot be read.")
    files = [path for path in (folder / "frames").iterdir() if not path.is_symlink()]
    return whole, len(files) - len(recording.frames)


def fill_disk(folder: Path, frame: int) -> None:
    """Writing this frame meets a full disk: the kernel's own ENOSPC, from /dev/full."""
    (folder / "frames").mkdir()
    (folder / f"frames/{frame:06d}.png").symlink_to("/dev/full")


def time_of_next_frame(folder: Path, frames_per_s: float) -> float:
    """When the frame after the last one that is on disk was to come."""
    return open_recording(folder).frames[-1].time_s + 1.0 / frames_per_s


def _readable(path: Path, camera: Camera) -> bool:
    try:
        read_frame(path, camera)
    except UnusableFrameError:
        return False
    return True
