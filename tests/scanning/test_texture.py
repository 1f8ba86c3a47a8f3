from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from footscan.optics.scanner import Scanner
from footscan.scanning.recording import Recording, open_recording
from footscan.scanning.texture import SkinTexture, texture_from_unlit
from footscan.sim.machine import TrueMachine, workshop_machine
from footscan.sim.motion import SweepPlan
from footscan.sim.objects import build_sphere
from footscan.sim.picture import DEFAULT_PICTURE
from footscan.sim.record import prepare_scan, simulate_recording
from footscan.sim.surface import Surface

AMBIENT_GREY = 90.0
CENTRE = np.array([20.0, 10.0, 70.0])
LAMP = np.array([0.25, 0.15, 0.96]) / np.linalg.norm([0.25, 0.15, 0.96])


@pytest.fixture(scope="module")
def machine(prototype: Scanner) -> TrueMachine:
    return workshop_machine(prototype, seed=8)


@pytest.fixture(scope="module")
def ball() -> Surface:
    return build_sphere(40.0, CENTRE, subdivisions=4)


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory, machine: TrueMachine, ball: Surface) -> Recording:
    folder = tmp_path_factory.mktemp("texture") / "ball"
    plan = SweepPlan(frames_per_sweep=48, unlit_every=4)
    picture = replace(DEFAULT_PICTURE, ambient_skin_grey=AMBIENT_GREY)
    simulate_recording(folder, prepare_scan(machine, ball, plan, picture), "none")
    return open_recording(folder)


@pytest.fixture(scope="module")
def texture(recording: Recording, machine: TrueMachine, ball: Surface) -> SkinTexture:
    normal = (ball.xyz_world - CENTRE) / 40.0
    found = texture_from_unlit(recording, machine.calibration, ball.xyz_world, normal, ball.faces)
    assert found is not None
    return found


def test_each_vertex_has_the_grey_of_the_skin_there(texture: SkinTexture, ball: Surface):
    towards = np.maximum((ball.xyz_world - CENTRE) @ LAMP / 40.0, 0.0)
    true = AMBIENT_GREY * (1.0 + 2.0 * towards) / 3.0
    often = texture.views >= 4

    assert often.mean() > 0.5
    assert np.median(np.abs(texture.grey - true)[often]) < 2.0
    assert np.percentile(np.abs(texture.grey - true)[often], 95) < 8.0


def test_what_no_picture_shows_has_no_grey(texture: SkinTexture, ball: Surface):
    below = ball.xyz_world[:, 2] < CENTRE[2] - 38.0

    assert np.isnan(texture.grey[below]).all()
    assert (texture.views[below] == 0).all()
    assert np.array_equal(np.isnan(texture.grey), texture.views == 0)


def test_a_scan_without_unlit_frames_has_no_texture(small_scan: Path, machine: TrueMachine, ball: Surface):
    normal = (ball.xyz_world - CENTRE) / 40.0

    assert (
        texture_from_unlit(open_recording(small_scan), machine.calibration, ball.xyz_world, normal, ball.faces) is None
    )
