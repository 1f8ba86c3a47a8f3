"""The library of lasts on disk: one folder per last, one file per version, never overwritten; and the built-in family.

```
<lasts>/<id>/v0001.npz     a version, see last_file.py; written beside, synced and linked into its place
<lasts>/index.json         a cache of what the files say of themselves; made again whenever it does not fit
```

The built-in family takes no place on disk: its dimensions are in the package, its lasts are built when asked for.
"""

import difflib
import json
import os
import re
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, cast

from footscan.config.toml_file import write_whole
from footscan.coordinates import Side
from footscan.errors import InputError, StorageError
from footscan.shoelast.family import build_shoelast
from footscan.shoelast.family_data import FamilyMember
from footscan.shoelast.family_index import family_index, member_of_id
from footscan.shoelast.last_file import about_shoelast, load_about, load_shoelast, shoelast_bytes
from footscan.shoelast.model import Shoelast

INDEX, INDEX_FORMAT = "index.json", "footscan-last-index/1"
BUILT_IN = "built in"
_VERSION = re.compile(r"v(\d{4,})\.npz")
_TRIES = 50


@dataclass(frozen=True)
class LastEntry:
    """A last as the index knows it.

    Attributes:
        id: Stable name in the library.
        name: For people.
        side: Of the real last.
        dimensions: Name -> mm (cm3 for the volume).
        size_eu: Paris points, None when nobody said.
        fitting: As the maker writes it.
        style: men, women, therapeutic or a free word.
        pitch_mm: Heel height.
        version: The newest one; the built-in family has version 1.
        source: `built in`, or where it came from.
        remarks: What its import changed.
    """

    id: str
    name: str
    side: Side
    dimensions: Mapping[str, float] = field(hash=False)
    size_eu: float | None = None
    fitting: str = ""
    style: str = ""
    pitch_mm: float | None = None
    version: int = 1
    source: str = BUILT_IN
    remarks: tuple[str, ...] = ()


class LastLibrary:
    """The lasts of a data folder and the built-in ones; methods that add return the new entry."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def entries(self, *, built_in: bool = True) -> tuple[LastEntry, ...]:
        """Newest version of every last, own ones first, each by id.

        Raises:
            InputError: A file in the library is damaged; it is named.
        """
        own = tuple(self._own().values())
        return own + (family_entries() if built_in else ())

    def entry(self, last_id: str) -> LastEntry:
        """One of them.

        Raises:
            InputError: No such id, with the nearest ones.
        """
        own = self._own()
        if last_id in own:
            return own[last_id]
        found = next((entry for entry in family_entries() if entry.id == last_id), None)
        if found is not None:
            return found
        member = member_of_id(last_id)
        if member is not None:
            return _entry_of_member(member)
        raise InputError(f"no last {last_id!r} in {self.folder}{_nearest(last_id, [*own])}; see `footscan lasts list`.")

    def load(self, last_id: str, version: int | None = None) -> Shoelast:
        """The last itself, the newest version unless one is named.

        Raises:
            InputError: No such id or version, or its file is damaged.
        """
        versions = self.versions(last_id)
        if not versions:
            member = member_of_id(self.entry(last_id).id)
            if member is None:
                raise InputError(f"no last {last_id!r} in {self.folder}; see `footscan lasts list`.")
            return build_shoelast(
                member.style, member.size_eu, member.fitting, member.pitch_mm, member.toe, member.side
            )
        wanted = versions[-1] if version is None else version
        if wanted not in versions:
            raise InputError(f"{last_id} has no version {version}; it has {', '.join(map(str, versions))}.")
        return load_shoelast(self._file(last_id, wanted))

    def versions(self, last_id: str) -> tuple[int, ...]:
        """Version numbers of a last of one's own; empty for the built-in family."""
        folder = self.folder / last_id
        if not _is_id(last_id) or not folder.is_dir():
            return ()
        found = (_VERSION.fullmatch(path.name) for path in folder.iterdir())
        return tuple(sorted(int(match[1]) for match in found if match))

    def add(self, shoelast: Shoelast, source: str, last_id: str | None = None) -> LastEntry:
        """Keep a last: a new one, or with the id of a kept one its next version.

        Args:
            shoelast: With points and lines.
            source: Where it comes from, for people.
            last_id: Default: made from its name; taken names get a number.

        Raises:
            InputError: An id that is not allowed, or one of the built-in family.
            StorageError: The place cannot be written; nothing half-written is left.
        """
        wanted = last_id or self._free_id(shoelast)
        if not _is_id(wanted):
            raise InputError(f"id {wanted!r}: small letters, digits, - and _ are allowed, up to 80.")
        if member_of_id(wanted) is not None:
            raise InputError(f"id {wanted!r} belongs to the built-in family; choose another with --name.")
        about = about_shoelast(shoelast, id=wanted, source=source)
        content = shoelast_bytes(shoelast, about)
        version = self._place(wanted, content)
        return _entry_from_about(wanted, version, about)

    def _place(self, last_id: str, content: bytes) -> int:
        """Write a version under the next free number; a link, unlike a rename, never replaces a file."""
        folder = self.folder / last_id
        try:
            folder.mkdir(parents=True, exist_ok=True)
            with tempfile.NamedTemporaryFile(dir=folder, prefix=".new-", delete=True) as stream:
                stream.write(content)
                stream.flush()
                os.fsync(stream.fileno())
                for _ in range(_TRIES):
                    version = max(self.versions(last_id), default=0) + 1
                    try:
                        os.link(stream.name, self._file(last_id, version))
                    except FileExistsError:
                        continue
                    self._file(last_id, version).chmod(0o440)
                    _sync(folder)
                    return version
        except OSError as err:
            raise StorageError(f"{folder} cannot be written ({err.strerror}); nothing was kept.") from err
        raise StorageError(f"{folder} is being written by others all the time; try again.")

    def _file(self, last_id: str, version: int) -> Path:
        return self.folder / last_id / f"v{version:04d}.npz"

    def _free_id(self, shoelast: Shoelast) -> str:
        text = re.sub(r"[^a-z0-9_-]+", "-", shoelast.name.lower()).strip("-")[:60] or "last"
        taken = {path.name for path in self.folder.iterdir()} if self.folder.is_dir() else set[str]()
        names = [text, *(f"{text}-{number}" for number in range(2, len(taken) + 3))]
        return next(name for name in names if name not in taken and member_of_id(name) is None)

    def _own(self) -> dict[str, LastEntry]:
        """Newest version of one's own lasts by id; only files that the index does not know are read."""
        if not self.folder.is_dir():
            return {}
        known, entries = self._cached(), dict[str, LastEntry]()
        fresh = dict[str, Any]()
        for last_id in sorted(path.name for path in self.folder.iterdir() if path.is_dir() and _is_id(path.name)):
            versions = self.versions(last_id)
            if versions:
                key = f"{last_id}/{versions[-1]}"
                fresh[key] = known.get(key) or load_about(self._file(last_id, versions[-1]))
                entries[last_id] = _entry_from_about(last_id, versions[-1], fresh[key])
        if fresh.keys() != known.keys():
            self._keep_index(fresh)
        return entries

    def _cached(self) -> dict[str, Any]:
        try:
            content = json.loads((self.folder / INDEX).read_text(encoding="utf-8"))
            return dict(content["lasts"]) if content["format"] == INDEX_FORMAT else {}
        except (OSError, ValueError, KeyError, TypeError):
            return {}  # a cache: what is not readable is made again

    def _keep_index(self, lasts: dict[str, Any]) -> None:
        content = json.dumps({"format": INDEX_FORMAT, "lasts": lasts})
        try:
            write_whole(self.folder / INDEX, content.encode())
        except StorageError:
            return  # a library that may only be read is listed all the same, more slowly


def family_entries() -> tuple[LastEntry, ...]:
    """The built-in family, right and left."""
    right = tuple(_entry_of_member(member, values) for member, values in family_index())
    left = tuple(
        replace(entry, id=f"{entry.id}-left", name=f"{entry.name}-left", side=cast("Side", "left")) for entry in right
    )
    return right + left


def _entry_of_member(member: FamilyMember, values: Mapping[str, float] | None = None) -> LastEntry:
    found = values
    if found is None:
        shoelast = build_shoelast(
            member.style, member.size_eu, member.fitting, member.pitch_mm, member.toe, member.side
        )
        found = about_shoelast(shoelast)["dimensions"]
    return LastEntry(
        id=member.name,
        name=member.name,
        side=member.side,
        dimensions=found,
        size_eu=member.size_eu,
        fitting=member.fitting,
        style=member.style,
        pitch_mm=member.pitch_mm,
    )


def _entry_from_about(last_id: str, version: int, about: Mapping[str, Any]) -> LastEntry:
    return LastEntry(
        id=last_id,
        name=str(about["name"]),
        side=cast("Side", about["side"]),
        dimensions=about["dimensions"],
        size_eu=about["size_eu"],
        fitting=str(about["fitting"]),
        style=str(about["style"]),
        pitch_mm=about["dimensions"]["pitch"],
        version=version,
        source=str(about.get("source", "")),
        remarks=tuple(about["remarks"]),
    )


def _is_id(text: str) -> bool:
    return re.fullmatch(r"[a-z0-9][a-z0-9_-]{0,79}", text) is not None


def _nearest(last_id: str, own: list[str]) -> str:
    names = difflib.get_close_matches(last_id, own + [entry.id for entry in family_entries()], 3, 0.6)
    return f" (near: {', '.join(names)})" if names else ""


def _sync(folder: Path) -> None:
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
