"""`footscan bench page`."""

from collections.abc import Sequence
from statistics import median
from typing import Annotated

import typer

from footscan.cli.console import STDOUT
from footscan.cli.rig_option import chosen_rig
from footscan.cli.served import paced


def bench_page_command(
    repeats: Annotated[int, typer.Option(help="Starts, and scans with and without a browser.", min=1)] = 3,
    scans: Annotated[int, typer.Option(help="Scans in one page, for its memory; 0 leaves them out.", min=0)] = 0,
) -> None:
    """Start, threshold to picture, frames that the live view costs, memory; needs Chromium and playwright."""
    from footscan.gui import page_bench  # noqa: PLC0415 - needs a dependency of developers
    from footscan.gui.headless import open_chromium  # noqa: PLC0415

    rig = chosen_rig(None, fast=False)
    STDOUT.print(page_bench.busy_now())
    with open_chromium() as browser:
        starts = list(page_bench.time_start(browser, repeats))
        for words, times in (
            ("command to its address", [start.address_s for start in starts]),
            ("command to its first words in a browser", [start.words_s for start in starts]),
            ("command to the whole page visible", [start.visible_s for start in starts]),
            ("the same, bare viser page", [start.bare_s for start in starts]),
        ):
            STDOUT.print(f"{words}: {min(times):.2f} / {median(times):.2f} s (minimum / median of {repeats})")
        _tell("threshold to new binary picture", page_bench.time_threshold(browser, paced(rig), 10 * repeats))
        for looked_at in (None, browser):
            for _ in range(repeats):
                frames, live = page_bench.count_frames(looked_at, page_bench.real_time_rig(rig))
                rejected = sum(frames.rejected.values())
                STDOUT.print(
                    f"scan {'without' if looked_at is None else 'with'} a browser: {frames.captured} captured, "
                    f"{frames.lost} lost, {rejected} rejected; live view {live.shown} of {live.given}"
                )
    if scans:
        memory: list[float] = []
        page_bench.grow(page_bench.small_rig(rig), scans, lambda number, now_mb: _note(memory, number, now_mb))


def _tell(words: str, taken_ms: Sequence[float]) -> None:
    STDOUT.print(f"{words}: {min(taken_ms):.0f} / {median(taken_ms):.0f} / {max(taken_ms):.0f} ms (min / median / max)")


def _note(memory: list[float], number: int, now_mb: float) -> None:
    memory.append(now_mb)
    if number in (1, 10) or number % 50 == 0:
        STDOUT.print(
            f"{number} scans: {now_mb:.0f} MB ({now_mb - memory[min(9, len(memory) - 1)]:+.1f} since the tenth)"
        )
