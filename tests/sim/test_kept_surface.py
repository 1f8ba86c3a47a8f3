"""Surfaces kept between programs."""

from pathlib import Path

import numpy as np
import pytest

from footscan.sim import kept_surface
from footscan.sim.surface import Surface


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(kept_surface, "user_cache_path", lambda name: tmp_path / name)
    return tmp_path / "footscan" / "surfaces"


class Maker:
    def __init__(self) -> None:
        self.made = 0

    def __call__(self) -> Surface:
        self.made += 1
        return Surface(np.arange(9.0).reshape(3, 3) / 7.0, np.array([[0, 1, 2]]))


def _same(one: Surface, other: Surface) -> bool:
    return np.array_equal(one.xyz_world, other.xyz_world) and np.array_equal(one.faces, other.faces)


def test_a_surface_is_made_once_and_read_bit_by_bit_afterwards(cache: Path) -> None:
    make = Maker()
    first = kept_surface.kept_surface("foot", ("left", 1.0), make)
    second = kept_surface.kept_surface("foot", ("left", 1.0), make)

    assert make.made == 1
    assert _same(first, second)
    assert [path.suffix for path in cache.iterdir()] == [".npz"]


def test_another_description_is_another_surface(cache: Path) -> None:
    make = Maker()
    for shape in (("left", 1.0), ("left", 1.0000001), ("right", 1.0)):
        kept_surface.kept_surface("foot", shape, make)

    assert make.made == 3


@pytest.mark.parametrize("content", [b"", b"no archive", b"PK\x03\x04 cut off"])
def test_a_damaged_file_is_made_anew(cache: Path, content: bytes) -> None:
    make = Maker()
    first = kept_surface.kept_surface("foot", 1, make)
    kept_surface.kept_path("foot", 1).write_bytes(content)
    again = kept_surface.kept_surface("foot", 1, make)
    third = kept_surface.kept_surface("foot", 1, make)

    assert make.made == 2
    assert _same(first, again) and _same(first, third)


def test_without_a_folder_it_is_simply_made(cache: Path) -> None:
    cache.parent.write_text("a file where the folder should be")
    make = Maker()
    kept_surface.kept_surface("foot", 1, make)
    kept_surface.kept_surface("foot", 1, make)

    assert make.made == 2
