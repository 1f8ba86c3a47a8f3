"""What is loaded later can be loaded; the page's own modules wait for none of it."""

import gc
import importlib.util
import subprocess
import sys

from footscan.gui.readiness import LATER, hurried


def test_what_is_loaded_later_exists() -> None:
    assert all(importlib.util.find_spec(name) is not None for name in LATER)


def test_the_page_stands_without_what_only_later_steps_need() -> None:
    heavy = ("trimesh", "matplotlib", "scipy.spatial", "footscan.foot.surface", "footscan.shoelast.customise")
    words = f"import sys, footscan.cli.served, footscan.app; print([name for name in {heavy} if name in sys.modules])"
    loaded = subprocess.run([sys.executable, "-c", words], capture_output=True, text=True, check=True).stdout

    assert loaded.strip() == "[]"


def test_hurrying_is_over_afterwards() -> None:
    usual_s = sys.getswitchinterval()
    with hurried():
        hurrying = (gc.isenabled(), sys.getswitchinterval() < usual_s)

    assert hurrying == (False, True)
    assert (gc.isenabled(), sys.getswitchinterval()) == (True, usual_s)
