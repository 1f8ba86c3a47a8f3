"""The kill drill: a program that stores is killed (-9) at random moments, and the records are looked at each time.

It shows what a killed program can do to the records. What a power cut can do rests on the order of the syncs, which a
kill does not show: the kernel lives on and writes everything.
"""

import os
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from random import Random

from footscan.errors import RecordsError
from footscan.records.drill_ledger import Expected, count_lines, read_lines
from footscan.records.store import RecordStore

KILLS_PER_FOLDER = 20
MOST_LINES, LONGEST_S = 6, 0.25
"""A writer dies at a random time, up to so many seconds after it wrote a random number of lines of its ledger."""
EARLY_SHARE = 0.15
"""This share of the writers dies without having to write a line first: while it opens the records, or soon after."""
_PATIENCE_S = 60.0


@dataclass(frozen=True)
class DrillReport:
    """What a drill saw.

    Attributes:
        kills: Writers killed.
        acknowledged: Calls of the store that had returned, over all writers.
        struck: What the killed writers were doing: calls that had begun, `between calls`, or `opening`.
        half_done: Of these calls, those that left files behind: leftovers, or scan folders whose removal was finished.
        folders: Data folders used.
        seconds: Duration.
        problems: Everything wrong; empty when the drill is passed.
    """

    kills: int
    acknowledged: int
    struck: dict[str, int]
    half_done: int
    folders: int
    seconds: float
    problems: tuple[str, ...]


@dataclass
class _Site:
    """One data folder under drill."""

    data: Path
    ledger: Path
    expected: Expected
    lines_read: int = 0
    leftovers: int = 0


def drill_records(
    kills: int, seed: int = 0, progress: Callable[[int, int], None] = lambda done, total: None
) -> DrillReport:
    """Kill storing programs and check after each kill.

    Raises:
        RecordsError: A writer ended by itself, so nothing was drilled.
    """
    random, begin = Random(seed), time.perf_counter()
    struck: Counter[str] = Counter()
    problems: list[str] = []
    acknowledged = half_done = folders = 0
    with tempfile.TemporaryDirectory(prefix="footscan-drill-") as place, _nursery() as nursery:
        site = None
        for k in range(kills):
            if site is None or k % KILLS_PER_FOLDER == 0:
                site = _new_site(Path(place), folders)
                folders += 1
            _kill_one(nursery, site, random)
            acknowledged -= site.expected.acknowledged
            what, torn, found = _inspect(site)
            acknowledged += site.expected.acknowledged
            struck[what] += 1
            half_done += torn
            problems += [f"kill {k + 1} ({what}): {problem}" for problem in found]
            progress(k + 1, kills)
    seconds = time.perf_counter() - begin
    return DrillReport(kills, acknowledged, dict(struck), half_done, folders, seconds, tuple(problems))


def _new_site(place: Path, number: int) -> _Site:
    folder = place / f"site-{number}"
    folder.mkdir()
    return _Site(folder / "data", folder / "ledger.jsonl", Expected())


@contextmanager
def _nursery() -> Generator["subprocess.Popen[str]"]:
    """The process that forks writers; importing the store once keeps the drill short."""
    command = [sys.executable, "-m", "footscan.records.drill_writer"]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as nursery:
        yield nursery
        assert nursery.stdin is not None
        nursery.stdin.close()


def _kill_one(nursery: "subprocess.Popen[str]", site: _Site, random: Random) -> None:
    assert nursery.stdin is not None
    assert nursery.stdout is not None
    nursery.stdin.write(f"{site.data}\t{site.ledger}\t{random.getrandbits(32)}\n")
    nursery.stdin.flush()
    writer = int(nursery.stdout.readline())
    early = random.random() < EARLY_SHARE
    _wait_for_lines(site, 0 if early else random.randint(1, MOST_LINES))
    time.sleep(random.uniform(0.0, LONGEST_S))
    os.kill(writer, signal.SIGKILL)  # it is our own and not waited for yet, so the number cannot be another's
    status = int(nursery.stdout.readline())
    if status != -signal.SIGKILL:
        raise RecordsError(f"a writer of the drill ended by itself (status {status}); look at what it printed.")


def _wait_for_lines(site: _Site, lines: int) -> None:
    end = time.monotonic() + _PATIENCE_S
    while count_lines(site.ledger) < site.lines_read + lines:
        if time.monotonic() > end:
            raise RecordsError(f"a writer of the drill stored too little in {site.data} within {_PATIENCE_S:g} s.")
        time.sleep(0.005)


def _inspect(site: _Site) -> tuple[str, bool, list[str]]:
    """What the writer was doing, whether it left something half done, and everything wrong."""
    lines = read_lines(site.ledger)
    fresh, site.lines_read = lines[site.lines_read :], len(lines)
    site.expected.read(fresh)
    begun = site.expected.begun
    what = "opening" if not fresh else "between calls" if begun is None else str(begun["action"])
    scans = site.data / "scans"
    before = len(list(scans.iterdir())) if scans.is_dir() else 0
    with RecordStore(site.data) as store:
        found = store.check_records() + site.expected.problems(store)
        leftovers = len(store.find_leftovers())
        found += _unaccounted(store)
    after = len(list(scans.iterdir())) if scans.is_dir() else 0
    torn = leftovers > site.leftovers or after < before
    site.leftovers = leftovers
    return what, torn, found


def _unaccounted(store: RecordStore) -> list[str]:
    """Folders of the store that neither a row nor the list of leftovers speaks of."""
    offered = {leftover.folder for leftover in store.find_leftovers()}
    named = {path for path in (store.data / "files").glob("??/*") if path not in offered}
    nameless = {path for path in (store.data / "stage").glob("*") if path not in offered}
    lost = {path for path in named if not store.is_kept(path.name)} | nameless
    return [f"{path} is neither kept nor offered" for path in sorted(lost)]
