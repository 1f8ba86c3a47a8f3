"""The last maker's sheet is at 1:1: measured on the rendered pages."""

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from matplotlib import image

from footscan.shoelast.dimensions import dimensions
from footscan.shoelast.family import build_shoelast
from footscan.shoelast.handed import mirrored
from footscan.shoelast.model import Shoelast
from footscan.workflow.lasts_sheet import BAR_MM, PAGES_MM, Paper, SheetHead, save_sheet

_DPI = 254
"""Ten pixels to the millimetre."""

needs_poppler = pytest.mark.skipif(shutil.which("pdftoppm") is None, reason="pdftoppm (poppler-utils) is not installed")


@pytest.fixture(scope="module")
def shoelast() -> Shoelast:
    return build_shoelast("women", 38, "g", 45.0, "round", "left")


def _sheet(shoelast: Shoelast, folder: Path, paper: Paper) -> tuple[Path, int]:
    path = folder / f"sheet-{paper}.pdf"
    values = {name: (value.value, value.unit) for name, value in dimensions(shoelast).items()}
    return path, save_sheet(shoelast, values, path, SheetHead("A17", "2026-11-26", "0.1.0"), paper)


def _rendered(path: Path) -> list[np.ndarray]:
    subprocess.run(["pdftoppm", "-r", str(_DPI), "-png", path, path.with_suffix("")], check=True)
    return [image.imread(name)[..., :3] for name in sorted(path.parent.glob(f"{path.stem}-*.png"))]


def _longest_run(dark: np.ndarray) -> int:
    edges = np.flatnonzero(np.diff(np.concatenate([[False], dark, [False]]).astype(int)))
    return int((edges[1::2] - edges[::2]).max(initial=0))


@needs_poppler
@pytest.mark.parametrize("paper", ["a3", "a4"])
def test_the_check_bars_of_every_page_measure_100_mm_both_ways(shoelast: Shoelast, tmp_path: Path, paper: Paper):
    path, count = _sheet(shoelast, tmp_path, paper)

    pages = _rendered(path)

    width, height = PAGES_MM[paper]
    assert len(pages) == count == {"a3": 1, "a4": 3}[paper]
    for page in pages:
        dark = page.max(axis=-1) < 0.5
        assert np.abs(np.array(page.shape[:2]) - 10 * np.array([height, width])).max() <= 1
        bottom, left = dark[-115:-100], dark[:, 100:115]
        assert max(_longest_run(row) for row in bottom) == pytest.approx(10 * BAR_MM, abs=3)
        assert max(_longest_run(column) for column in left.T) == pytest.approx(10 * BAR_MM, abs=3)


@needs_poppler
def test_the_drawn_outline_is_as_long_and_high_as_the_last(shoelast: Shoelast, tmp_path: Path):
    page = _rendered(_sheet(shoelast, tmp_path, "a3")[0])[0]
    red = (page[..., 0] > 0.8) & (page[..., 1] < 0.45) & (page[..., 2] < 0.45)

    rows, columns = np.flatnonzero(red.any(axis=1)), np.flatnonzero(red.any(axis=0))
    gap = np.flatnonzero(np.diff(rows) > 20)[0]
    sizes = dimensions(shoelast)
    xyz = mirrored(shoelast.upper.grid(np.arange(720) / 720, np.linspace(0, 1, 61)), "left")
    assert np.ptp(columns) / 10 == pytest.approx(sizes["stick_length"].value, abs=0.4)
    assert np.ptp(rows[: gap + 1]) / 10 == pytest.approx(xyz[..., 2].max(), abs=0.4), "side view from ground to cone"
    assert np.ptp(rows[gap + 1 :]) / 10 == pytest.approx(np.ptp(xyz[..., 1]), abs=0.4), "plan"


@needs_poppler
def test_the_sheet_says_who_it_is_and_holds_the_tapes(shoelast: Shoelast, tmp_path: Path):
    path, _ = _sheet(shoelast, tmp_path, "a3")

    text = subprocess.run(["pdftotext", "-layout", path, "-"], check=True, capture_output=True, text=True).stdout

    ball = dimensions(shoelast)["ball_girth"].value
    assert re.search(rf"A17: {shoelast.name}, left last, EU 38, fitting g", text)
    assert re.search(rf"ball girth\s+{ball:.1f}\s+\d+\.\d\s+\d+\.\d", text)
    assert "scale 1:1" in text and "2026-11-26" in text
    assert "long heel girth" in text and "toe spring" in text
