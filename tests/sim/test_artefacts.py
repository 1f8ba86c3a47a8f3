import tomllib
from pathlib import Path

import numpy as np
import pytest

from footscan.errors import InputError
from footscan.sim.artefacts import ArtefactChoice, build_artefact, save_artefact

VOLUME_DIAGONAL_MM = 450.0


def test_usual_sizes_are_those_of_the_acceptance_test():
    sphere, bar, plane = (build_artefact(kind) for kind in ("sphere", "ball-bar", "plane"))
    plane_mm = np.ptp(plane.surface.xyz_world, axis=0)

    assert 0.1 * VOLUME_DIAGONAL_MM <= sphere.diameters_mm[0] <= 0.2 * VOLUME_DIAGONAL_MM
    assert all(0.1 * VOLUME_DIAGONAL_MM <= diameter <= 0.2 * VOLUME_DIAGONAL_MM for diameter in bar.diameters_mm)
    assert bar.spacing_mm is not None
    assert bar.spacing_mm >= 0.3 * VOLUME_DIAGONAL_MM
    assert plane_mm[0] >= 0.5 * VOLUME_DIAGONAL_MM
    assert np.hypot(plane_mm[1], plane_mm[2]) >= 50.0


def test_balls_stand_as_far_apart_and_as_steep_as_said():
    tilt, heading = 0.3, 1.2
    choice = ArtefactChoice(46.0, 180.0, centre_world=(5.0, -3.0, 80.0), heading_rad=heading, tilt_rad=tilt)
    xyz_world = build_artefact("ball-bar", choice).surface.xyz_world
    one, two = xyz_world[: len(xyz_world) // 2], xyz_world[len(xyz_world) // 2 :]
    along = two.mean(axis=0) - one.mean(axis=0)
    direction = [np.cos(tilt) * np.cos(heading), np.cos(tilt) * np.sin(heading), np.sin(tilt)]

    assert np.allclose(along, 180.0 * np.array(direction), atol=1e-6)
    assert np.allclose((one.mean(axis=0) + two.mean(axis=0)) / 2.0, [5.0, -3.0, 80.0], atol=1e-6)
    assert np.allclose(np.linalg.norm(one - one.mean(axis=0), axis=1), 23.0)


def test_plane_is_flat_and_leans_as_said():
    plane = build_artefact("plane", ArtefactChoice(heading_rad=0.5, tilt_rad=0.4)).surface
    off = plane.xyz_world - plane.xyz_world.mean(axis=0)

    assert np.linalg.svd(off)[1][2] < 1e-9
    assert np.abs(plane.normal_world[:, 2]).min() == pytest.approx(np.cos(0.4))
    assert not plane.closed


@pytest.mark.parametrize(
    ("kind", "choice", "message"),
    [
        ("sphere", ArtefactChoice(diameter_mm=90.0, centre_world=(170.0, 0.0, 60.0)), "reaches 215 mm from the axis"),
        (
            "sphere",
            ArtefactChoice(diameter_mm=90.0, centre_world=(0.0, 0.0, 30.0)),
            "from -15 to 75 mm above the board",
        ),
        ("ball-bar", ArtefactChoice(spacing_mm=390.0), "up to 200 mm and from 0 to 260 mm"),
        ("ball-bar", ArtefactChoice(spacing_mm=40.0), "their spacing is above their diameter of 50 mm, found 40"),
        ("sphere", ArtefactChoice(diameter_mm=-1.0), "5 to 400 mm, found -1"),
        ("cube", ArtefactChoice(), "one of sphere, ball-bar, plane; found 'cube'"),
    ],
)
def test_what_does_not_fit_is_said_in_a_sentence(kind: str, choice: ArtefactChoice, message: str):
    with pytest.raises(InputError, match=message):
        build_artefact(kind, choice)


def test_artefact_file_holds_what_is_known_exactly(tmp_path: Path):
    tables: list[dict[str, object]] = []
    for kind in ("sphere", "ball-bar", "plane"):
        save_artefact(build_artefact(kind), tmp_path)
        tables.append(tomllib.loads((tmp_path / "artefact.toml").read_text()))

    assert tables == [
        {"format": "footscan-artefact/1", "kind": "sphere", "diameters_mm": [60.0]},
        {"format": "footscan-artefact/1", "kind": "ball-bar", "diameters_mm": [50.0, 50.0], "spacing_mm": 200.0},
        {"format": "footscan-artefact/1", "kind": "plane"},
    ]
