"""What a storing program announced and what it got acknowledged, and whether the records still say so."""

import json
import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from footscan.errors import InputError
from footscan.records.store import RecordStore
from footscan.records.tree_hash import hash_of_folder
from footscan.records.values import Take


class Ledger:
    """Lines appended beside the data folder: `begin` before a call of the store, `done` after it returned."""

    def __init__(self, path: Path) -> None:
        self._file = os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT)

    def opened(self) -> None:
        """Say that the records are open."""
        self._write({"state": "open"})

    def begin(self, action: str, **facts: Any) -> None:
        """Announce a call."""
        self._write({"state": "begin", "action": action, **facts})

    def done(self, action: str, **facts: Any) -> None:
        """Say that a call was acknowledged."""
        self._write({"state": "done", "action": action, **facts})

    def _write(self, line: dict[str, Any]) -> None:
        os.write(self._file, json.dumps(line).encode() + b"\n")  # one write: a kill leaves whole lines


@dataclass
class Expected:
    """What the records must hold after all acknowledged calls; `begun` may have happened or not."""

    patients: dict[int, str] = field(default_factory=dict)
    deleted: set[int] = field(default_factory=set)
    takes: dict[int, dict[str, Any]] = field(default_factory=dict)
    results: dict[int, int] = field(default_factory=dict)
    in_use: int | None = None
    begun: dict[str, Any] | None = None
    acknowledged: int = 0

    def read(self, lines: list[dict[str, Any]]) -> None:
        """Go on with more lines of the ledger."""
        for line in lines:
            if line["state"] == "open":
                continue
            if line["state"] == "begin":
                self.begun = line
                self.in_use = None if line["action"] in ("use", "correct") else self.in_use
                continue
            self.begun = None
            self.acknowledged += 1
            self._note(line)

    def _note(self, line: dict[str, Any]) -> None:
        match line["action"]:
            case "add":
                self.patients[line["patient"]] = line["name"]
            case "delete":
                self.patients.pop(line["patient"], None)
                self.deleted.add(line["patient"])
                self.takes = {k: take for k, take in self.takes.items() if take["patient"] != line["patient"]}
            case "file" | "correct":
                facts = ("patient", "side", "load", "sha256", "landmarks")
                known = self.takes.get(line["take"], {"landmarks": {}})
                self.takes[line["take"]] = known | {name: line[name] for name in facts if name in line}
                self.results.setdefault(line["take"], line.get("results", 0))
            case "result":
                self.results[line["take"]] += 1
            case "landmark":
                self.takes[line["take"]]["landmarks"][line["name"]] = line["xyz"]
            case _:
                self.in_use = line["take"]

    def problems(self, store: RecordStore) -> list[str]:
        """Everything acknowledged that the records no longer say; what had only begun may be either way."""
        kept = {patient.id: patient.name for patient in store.find_patients(limit=10**6)}
        open_delete = self._target("delete", "patient")
        found = [f"patient {k} is gone" for k in self.patients.keys() - kept.keys() - {open_delete}]
        found += [f"patient {k} has another name" for k, name in self.patients.items() if kept.get(k, name) != name]
        found += [f"patient {k} was deleted and is back" for k in self.deleted & kept.keys()]
        if open_delete is not None and open_delete not in kept:
            self._note({"action": "delete", "patient": open_delete})
        self._adopt(store, kept)
        for number, facts in self.takes.items():
            found += self._problems_of_take(store, number, facts)
        found += self._lost_scan()
        self.begun = None
        return found

    def _lost_scan(self) -> list[str]:
        """A scan that was being filed is either a take by now, or still where it was."""
        sha256, recording = self._target("file", "sha256"), self._target("file", "recording")
        if sha256 is None or sha256 in {take["sha256"] for take in self.takes.values()}:
            return []
        place = Path(recording)
        kept = place.is_dir() and hash_of_folder(place) == sha256
        return [] if kept else [f"the scan {place} is neither filed nor still there"]

    def _adopt(self, store: RecordStore, kept: dict[int, str]) -> None:
        """What happened though the writer was killed before it heard so: from now on it must stay."""
        self.patients |= {number: name for number, name in kept.items() if number not in self.patients}
        visits = [visit.id for number in kept for visit in store.visits(number)]
        for take in (take for number in visits for take in store.takes(number)):
            if take.id not in self.takes:
                self.takes[take.id] = _facts(take)
                self.results[take.id] = len(store.results(take.id))

    def _problems_of_take(self, store: RecordStore, number: int, facts: dict[str, Any]) -> list[str]:
        try:
            take = store.take(number)
        except InputError:
            return [f"take {number} is gone"]
        now = _facts(take)
        changing = self.begun if self._target("correct", "take") == number else None
        moving = self.begun["name"] if self.begun and self._target("landmark", "take") == number else None
        found: list[str] = []
        for name, value in now.items():
            allowed = [facts[name]] + ([changing[name]] if changing and name in changing else [])
            if name == "landmarks":
                value = {mark: xyz for mark, xyz in value.items() if mark != moving}
                allowed = [{mark: xyz for mark, xyz in facts[name].items() if mark != moving}]
            if value not in allowed:
                found.append(f"take {number}: {name} is {value}, acknowledged was {facts[name]}")
        facts |= now
        had, has = self.results[number], len(store.results(number))
        if not had <= has <= had + (self._target("result", "take") == number):
            found.append(f"take {number} has {has} results, acknowledged were {had}")
        self.results[number] = has
        if self.in_use == number and not take.in_use:
            found.append(f"take {number} is no longer in use")
        return found

    def _target(self, action: str, what: str) -> Any:
        return self.begun[what] if self.begun and self.begun["action"] == action else None


def _facts(take: Take) -> dict[str, Any]:
    marks = {mark.name: list(mark.xyz_world) for mark in take.landmarks}
    said = {"patient": take.patient_id, "side": take.said.side, "load": take.said.load}
    return {**said, "sha256": take.recording_sha256, "landmarks": marks}


def read_lines(path: Path) -> list[dict[str, Any]]:
    """All whole lines of a ledger."""
    text = path.read_text(encoding="utf-8") if path.exists() else ""
    return [json.loads(line) for line in text.splitlines(keepends=True) if line.endswith("\n")]


def count_lines(path: Path) -> int:
    """How many whole lines a ledger has."""
    return path.read_bytes().count(b"\n") if path.exists() else 0
