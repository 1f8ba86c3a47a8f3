"""The program that the kill drill kills: it stores and stores until it is dead.

`python -m footscan.records.drill_writer` reads lines `data-folder <tab> ledger <tab> seed` from standard input, forks a
writer for each, prints its process number, and when it is dead how it ended.
"""

import os
import sys
from datetime import UTC, datetime
from pathlib import Path
from random import Random

from footscan.coordinates import Side
from footscan.records.data_folder import SCANS
from footscan.records.drill_ledger import Ledger
from footscan.records.results import CALIBRATION
from footscan.records.store import RecordStore
from footscan.records.tree_hash import hash_of_folder
from footscan.records.values import Correction, Measured, NewPatient, NewResult, NewTake, Take
from footscan.scanning.recorder import manifest_of
from footscan.scanning.recording import MANIFEST

BY = "drill"
_LETTERS = "aäßéçøłñабвгдאבגابت漢字かなกข가나ग🦶 "
_ACTIONS = ("add", "file", "file", "file", "result", "correct", "use", "landmark", "delete")


class Writer:
    """Stores at random in one data folder."""

    def __init__(self, store: RecordStore, ledger: Ledger, random: Random) -> None:
        self._store, self._ledger, self._random = store, ledger, random

    def run(self) -> None:
        """Until killed."""
        self._ledger.opened()
        while True:
            action = self._random.choice(_ACTIONS)
            patients, takes = self._known()
            if action == "add" or not patients:
                self._add()
            elif action == "file" or not takes:
                self._file(self._random.choice(patients))
            elif action == "delete":
                if len(patients) > 4:
                    self._delete(self._random.choice(patients))
            else:
                getattr(self, f"_{action}")(self._random.choice(takes), patients)

    def _known(self) -> tuple[list[int], list[Take]]:
        patients = [patient.id for patient in self._store.find_patients()]
        visits = [visit.id for number in patients for visit in self._store.visits(number)]
        return patients, [take for number in visits for take in self._store.takes(number)]

    def _add(self) -> None:
        name = "p" + "".join(self._random.choices(_LETTERS, k=20)).strip() + f" {self._random.getrandbits(40)}"
        self._ledger.begin("add", name=name)
        patient = self._store.add_patient(NewPatient(name), BY)
        self._ledger.done("add", patient=patient.id, name=patient.name)

    def _delete(self, patient: int) -> None:
        self._ledger.begin("delete", patient=patient)
        self._store.delete_patient(patient, "drill", BY)
        self._ledger.done("delete", patient=patient)

    def _file(self, patient: int) -> None:
        side: Side = self._random.choice(("left", "right"))
        scan = self._store.data / SCANS / f"{self._random.getrandbits(64):016x}-{side}"
        self._record(scan / "recording", side)
        said = NewTake(side, BY, datetime.now(UTC), load=self._random.choice(("seated", "bipedal")))
        made = self._random.random() < 0.7
        if made:
            self._make_results(scan / "results")
            _write(scan / CALIBRATION, b"drill = true\n")
        sha256 = hash_of_folder(scan / "recording")
        self._ledger.begin("file", patient=patient, sha256=sha256, recording=str(scan / "recording"))
        take = self._store.file_take(
            patient,
            said,
            scan / "recording",
            _result(said) if made else None,
            scan / "results" if made else None,
            scan / CALIBRATION if made else None,
        )
        self._ledger.done(
            "file",
            take=take.id,
            patient=patient,
            side=side,
            load=said.load,
            sha256=take.recording_sha256,
            results=int(made),
        )

    def _result(self, take: Take, _patients: list[int]) -> None:
        made = self._store.data.parent / f"made-{os.getpid()}-{self._random.getrandbits(40)}"
        self._make_results(made)
        self._ledger.begin("result", take=take.id)
        self._store.file_result(take.id, _result(take.said), made, None, BY)
        self._ledger.done("result", take=take.id)

    def _correct(self, take: Take, patients: list[int]) -> None:
        side: Side = "left" if take.said.side == "right" else "right"
        patient = self._random.choice((take.patient_id, self._random.choice(patients)))
        self._ledger.begin("correct", take=take.id, side=side, patient=patient)
        self._store.correct_take(take.id, Correction(patient, side), "drill", BY)
        self._ledger.done("correct", take=take.id, side=side, patient=patient)

    def _use(self, take: Take, _patients: list[int]) -> None:
        if take.result is not None:
            self._ledger.begin("use", take=take.id)
            self._store.use_take(take.id, BY)
            self._ledger.done("use", take=take.id)

    def _landmark(self, take: Take, _patients: list[int]) -> None:
        name, xyz = f"mark_{self._random.randrange(4)}", (self._random.random(), 2.0, 3.0)
        self._ledger.begin("landmark", take=take.id, name=name, xyz=xyz)
        self._store.place_landmark(take.id, name, xyz, BY)
        self._ledger.done("landmark", take=take.id, name=name, xyz=xyz)

    def _record(self, folder: Path, side: Side) -> None:
        head = (
            f'format = "footscan-recording/1"\nkind = "scan"\nside = "{side}"\ncreated = "2026-01-01T00:00:00+00:00"\n'
        )
        _write(folder / "recording.toml", head.encode())
        for k in range(self._random.randrange(1, 8)):
            _write(folder / f"frames/{k:06d}.png", self._random.randbytes(self._random.randrange(1, 30000)))
        _write(folder / MANIFEST, manifest_of(folder).encode())

    def _make_results(self, folder: Path) -> None:
        _write(folder / "scan.json", self._random.randbytes(500))
        _write(folder / "surface.stl", self._random.randbytes(self._random.randrange(1, 60000)))


def _write(path: Path, content: bytes) -> None:
    """Without a sync: the time between the kills belongs to the store."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)


def _result(said: NewTake) -> NewResult:
    values = tuple(
        Measured(f"length_{k}", 240.0 + k, "mm", True, "", None, None, "heel to toe", "1") for k in range(20)
    )
    return NewResult(said.side, said.load, (), "0" * 64, {"threshold": 40}, {"footscan": "drill"}, "", values)


def _serve() -> None:
    for line in sys.stdin:
        data, ledger, seed = line.rstrip("\n").split("\t")
        child = os.fork()
        if child == 0:
            Writer(RecordStore(Path(data)), Ledger(Path(ledger)), Random(int(seed))).run()
        print(child, flush=True)  # noqa: T201  the drill reads it
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        print(status, flush=True)  # noqa: T201


if __name__ == "__main__":
    _serve()
