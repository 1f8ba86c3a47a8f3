"""Is a recording whole? Every missing, cut, changed or surplus file is named."""

import hashlib

from footscan.scanning.frames import UnusableFrameError, read_frame
from footscan.scanning.recorder import recorded_files
from footscan.scanning.recording import MANIFEST, Recording


def verify_recording(recording: Recording) -> list[str]:
    """Look at every file of a recording.

    Returns:
        One sentence per problem, empty when the recording is whole. Frames must decode and have the scanner's size; a
        recording that carries checksums must match them.
    """
    problems: list[str] = []
    for record in recording.frames:
        try:
            read_frame(recording.path(record), recording.scanner.camera)
        except UnusableFrameError as err:
            problems.append(f"frame {record.frame}: {err.reason} ({err})")
    return problems + against_manifest(recording)


def against_manifest(recording: Recording) -> list[str]:
    """What differs from the checksums the recording carries, one sentence each; nothing where it carries none."""
    manifest = recording.folder / MANIFEST
    if not manifest.is_file():
        return []
    lines = manifest.read_text(encoding="utf-8", errors="replace").splitlines()
    expected = {name: digest for digest, _, name in (line.partition("  ") for line in lines)}
    present = {path.relative_to(recording.folder).as_posix(): path for path in recorded_files(recording.folder)}
    problems = [f"{name} is missing" for name in sorted(expected.keys() - present.keys())]
    problems += [
        f"{name} was added after the recording was finished" for name in sorted(present.keys() - expected.keys())
    ]
    for name in sorted(expected.keys() & present.keys()):
        if hashlib.sha256(present[name].read_bytes()).hexdigest() != expected[name]:
            problems.append(f"{name} was changed after the recording was finished")
    return problems
