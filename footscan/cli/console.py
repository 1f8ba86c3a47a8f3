"""What commands share: a progress bar on standard error, results on standard output."""

import json
import sys
from collections.abc import Callable, Generator
from contextlib import contextmanager
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

ProgressCallback = Callable[[int, int], None]
STDERR = Console(stderr=True, highlight=False, markup=False, soft_wrap=True)
STDOUT = Console(highlight=False, markup=False, soft_wrap=True, width=None if sys.stdout.isatty() else 200)


@contextmanager
def progress_bar(what: str, quiet: bool) -> Generator[ProgressCallback]:
    """A bar on standard error for work of known length; nothing with `quiet` or where nobody looks."""
    from footscan.compiled import announce_compilation  # noqa: PLC0415 - not every command needs Numba

    if quiet or not STDERR.is_terminal:
        with announce_compilation(lambda text: None if quiet else STDERR.print(text)):
            yield lambda done, total: None
        return
    columns = (TextColumn(what), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=STDERR, transient=True) as bar, announce_compilation(STDERR.print):
        task = bar.add_task(what, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)


def print_json(value: dict[str, Any]) -> None:
    """One JSON object on standard output and nothing else."""
    print(json.dumps(value))
