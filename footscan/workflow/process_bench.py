"""`footscan bench process`: a whole recording as a process of its own, and many times the frames."""

import json
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from footscan.errors import InputError
from footscan.optics.scanner import Scanner
from footscan.scanning.recording import ENCODER_COLUMNS, FRAME_COLUMNS, Recording, csv_line, open_recording
from footscan.workflow.simulate import SimulateSettings, simulate_scan

_PAUSE_S = 1.0


@dataclass(frozen=True)
class ProcessTiming:
    """One run of `footscan process`: wall time, peak memory, seconds of its frame loop and of all its stages."""

    frames: int
    wall_s: float
    peak_mb: float
    loop_s: float
    stages_s: float


def time_process(scanner: Scanner, times: int, repeats: int) -> list[ProcessTiming]:
    """Process a simulated scan of 480 frames `repeats` times, then one of `times` as many frames once."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "scan"
        simulate_scan(scanner, SimulateSettings("foot", seed=1), folder, lambda done, total: None)
        calibration = folder / "truth-calibration.toml"
        runs = [_run(folder, calibration, Path(place) / "out") for _ in range(repeats + 1)][1:]
        long = repeat_recording(open_recording(folder), times, Path(place) / "long")
        return [min(runs, key=lambda run: run.wall_s), _run(long, calibration, Path(place) / "out")]


def repeat_recording(recording: Recording, times: int, folder: Path) -> Path:
    """The same scan over and over again as one recording; frames are links to the original's."""
    (folder / "frames").mkdir(parents=True)
    for name in ("recording.toml", "scanner.toml"):
        (folder / name).write_bytes((recording.folder / name).read_bytes())
    track = recording.encoder
    turn_s = float(track.time_s[-1] - track.time_s[0]) + _PAUSE_S
    frames, counts = [csv_line(FRAME_COLUMNS)], [csv_line(ENCODER_COLUMNS)]
    for k in range(times):
        counts += [csv_line((t + k * turn_s, int(c))) for t, c in zip(track.time_s, track.count, strict=True)]
        for record in recording.frames:
            number = len(frames) - 1
            file = f"frames/{number:06d}.png"
            (folder / file).symlink_to(recording.path(record).resolve())
            frames.append(
                csv_line((number, file, record.time_s + k * turn_s, record.laser, record.sweep, record.setup))
            )
    (folder / "frames.csv").write_text("".join(frames), encoding="utf-8")
    (folder / "encoder.csv").write_text("".join(counts), encoding="utf-8")
    return folder


def _run(folder: Path, calibration: Path, out: Path) -> ProcessTiming:
    command = [sys.executable, "-m", "footscan.cli.main", "process", str(folder), "--calibration", str(calibration)]
    begin = time.perf_counter()
    with (
        tempfile.TemporaryFile() as output,
        subprocess.Popen([*command, "--out", str(out), "--json"], stdout=output) as run,
    ):
        _, status, usage = os.wait4(run.pid, 0)
        run.returncode = os.waitstatus_to_exitcode(status)
        wall_s = time.perf_counter() - begin
        output.seek(0)
        text = output.read()
    if run.returncode != 0:
        raise InputError(f"footscan process ended with status {run.returncode}; run it by hand to see why.")
    report = json.loads(text)
    seconds = report["seconds"]
    return ProcessTiming(
        report["frames"]["seen"], wall_s, usage.ru_maxrss / 1024.0, seconds["frames"], sum(seconds.values())
    )
