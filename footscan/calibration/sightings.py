"""What was seen, as flat arrays: corners of the board and places on stripes, each with its frame and placement."""

from dataclasses import dataclass, replace

import numpy as np

from footscan.coordinates import Bools, Floats, Ints
from footscan.scanning.recording import EncoderTrack

FLOOR_PLACEMENT = -1


def resting_counts(time_s: Floats, track: EncoderTrack) -> Floats:
    """The count `(m,)` of the encoder sample nearest to each time."""
    middle = 0.5 * (track.time_s[1:] + track.time_s[:-1])
    return track.count[np.searchsorted(middle, time_s)]


@dataclass(frozen=True)
class FrameTimes:
    """`(m,)` times of the frames that sightings refer to, which of them moved, and the encoder's own samples."""

    time_s: Floats
    moving: Bools
    track: EncoderTrack

    def counts(self, latency_s: float) -> Floats:
        """Counts `(m,)`: interpolated at the frames' times minus the latency; at a stop that of the nearest sample.

        A late stamp of a stop's last frame may lie after the stop's last sample, when the head already turns on.
        """
        turning = np.interp(self.time_s - latency_s, self.track.time_s, self.track.count)
        return np.where(self.moving, turning, resting_counts(self.time_s, self.track))


@dataclass(frozen=True)
class Corners:
    """Board corners.

    Attributes:
        frame: `(n,)` index into `FrameTimes`.
        placement: `(n,)` which placement.
        xy_board: `(n, 2)` mm on the board.
        yz_pixel: `(n, 2)` where they were seen, in F.
        moving: `(n,)` seen while the head turned.
    """

    frame: Ints
    placement: Ints
    xy_board: Floats
    yz_pixel: Floats
    moving: Bools

    def __len__(self) -> int:
        return len(self.frame)

    def kept(self, keep: Bools) -> "Corners":
        """The sightings for which `keep` `(n,)` holds."""
        return Corners(*(getattr(self, key)[keep] for key in self.__dataclass_fields__))


@dataclass(frozen=True)
class StripePoints:
    """Places on laser stripes.

    Attributes:
        frame: `(n,)` index into `FrameTimes`.
        placement: `(n,)` on which board, or `FLOOR_PLACEMENT` on the footboard.
        laser: `(n,)` 0 right, 1 left.
        yz_pixel: `(n, 2)` where they were seen, in F.
        plain: `(n,)` nothing is printed near, so that the stripe is evenly bright across.
    """

    frame: Ints
    placement: Ints
    laser: Ints
    yz_pixel: Floats
    plain: Bools

    def __len__(self) -> int:
        return len(self.frame)

    def kept(self, keep: Bools) -> "StripePoints":
        """The sightings for which `keep` `(n,)` holds."""
        return StripePoints(*(getattr(self, key)[keep] for key in self.__dataclass_fields__))


@dataclass(frozen=True)
class Sightings:
    """Everything a joint estimate works on; `placement_names` are the setups of frames.csv."""

    times: FrameTimes
    corners: Corners
    stripes: StripePoints
    placement_names: tuple[str, ...]

    def without(self, placement: int) -> "Sightings":
        """All sightings but those of one placement; numbering stays."""
        corners = self.corners.kept(self.corners.placement != placement)
        return replace(self, corners=corners, stripes=self.stripes.kept(self.stripes.placement != placement))

    def only(self, placement: int) -> "Sightings":
        """The sightings of one placement; numbering stays."""
        corners = self.corners.kept(self.corners.placement == placement)
        return replace(self, corners=corners, stripes=self.stripes.kept(self.stripes.placement == placement))


_NONE = np.zeros(0, dtype=np.int64)
NO_STRIPES = StripePoints(_NONE, _NONE, _NONE, np.zeros((0, 2)), np.zeros(0, dtype=bool))
