"""What the page does not need at once is loaded once it stands; and memory is tidied between jobs.

`gc.freeze` takes everything loaded out of the garbage collector's sight: a full collection of a page that stands would
stop all threads, the machine's control thread too, for a third of a second.
"""

import ctypes
import gc
import importlib
import sys
import threading
from collections.abc import Generator
from contextlib import contextmanager

LATER = (
    "footscan.workflow.visit",
    "trimesh.exchange.gltf",
    "footscan.gui.fitting",
    "footscan.workflow.lasts_pictures",
    "footscan.workflow.lasts_export",
    "footscan.workflow.guided_calibration",
    "footscan.workflow.calibrate",
    "footscan.workflow.doctor",
    "footscan.workflow.drill",
)
"""In the order in which people come to need it."""
_AFTER_S = 5.0
"""The browser draws the page first."""
_SWITCH_S = 0.0005
"""The browser is served while modules are imported: that thread must not wait for the usual 5 ms each time."""


@contextmanager
def hurried() -> Generator[None]:
    """While the program starts: nothing that is imported is garbage, and the browser is served at once."""
    usual_s = sys.getswitchinterval()
    gc.disable()
    sys.setswitchinterval(_SWITCH_S)
    try:
        yield
    finally:
        sys.setswitchinterval(usual_s)
        gc.enable()


class Loader(threading.Thread):
    """Loads what is in `LATER`, unless it is ended before."""

    def __init__(self) -> None:
        super().__init__(name="loader", daemon=True)
        self._finished = threading.Event()

    def run(self) -> None:
        """Load one after the other."""
        if self._finished.wait(_AFTER_S):
            return
        for name in LATER:
            importlib.import_module(name)
            if self._finished.is_set():
                return
        gc.collect()
        gc.freeze()

    def finish(self) -> None:
        """End after what is being loaded."""
        self._finished.set()


def tidy_memory() -> None:
    """Collect what a job has left in cycles, and give what is free back to the operating system (glibc keeps it)."""
    gc.collect()
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim is not None:
        trim(0)
