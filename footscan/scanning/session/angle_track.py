"""The head's angle over the last seconds, filled by the control thread and read by others."""

import threading

import numpy as np

from footscan.coordinates import Floats
from footscan.devices.values import EncoderSamples
from footscan.optics.calibration import EncoderScale, theta_from_encoder

_KEPT = 20_000


class AngleTrack:
    """Encoder samples of the last while as angles."""

    def __init__(self, encoder: EncoderScale) -> None:
        self._encoder = encoder
        self._lock = threading.Lock()
        self._time_s, self._count = np.empty(0), np.empty(0)

    def add(self, samples: EncoderSamples) -> None:
        """Newer samples."""
        with self._lock:
            self._time_s = np.concatenate([self._time_s, samples.time_s])[-_KEPT:]
            self._count = np.concatenate([self._count, samples.count])[-_KEPT:]

    def reaches(self, time_s: float) -> bool:
        """Whether the angle at a moment is known."""
        with self._lock:
            return len(self._time_s) > 0 and bool(self._time_s[-1] >= time_s)

    def theta_at(self, time_s: Floats) -> Floats:
        """Angles (rad) at some moments; NaN before the first and after the last sample."""
        with self._lock:
            if len(self._time_s) == 0:
                return np.full(np.shape(time_s), np.nan)
            count = np.interp(time_s, self._time_s, self._count, left=np.nan, right=np.nan)
        return theta_from_encoder(count, self._encoder)
