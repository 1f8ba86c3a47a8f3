import numpy as np

from footscan.optics.scanner import Scanner, calibration_from_design
from footscan.sim.machine import WORKSHOP, ideal_machine, workshop_machine, world_from_board


def test_ideal_machine_is_the_design(prototype: Scanner):
    assert ideal_machine(prototype).calibration == calibration_from_design(prototype)


def test_same_seed_builds_the_same_machine(prototype: Scanner):
    assert workshop_machine(prototype, 3) == workshop_machine(prototype, 3)
    assert workshop_machine(prototype, 3).calibration != workshop_machine(prototype, 4).calibration


def test_every_built_machine_is_off_but_within_tolerance(prototype: Scanner):
    design = calibration_from_design(prototype)
    for seed in range(40):
        built = workshop_machine(prototype, seed).calibration
        shift = np.subtract(built.camera.principal_point_px, design.camera.principal_point_px)

        assert 0.0 < np.max(np.abs(shift)) <= WORKSHOP.principal_point_px
        assert 0.0 < abs(built.pose.phi_rad - design.pose.phi_rad) <= WORKSHOP.pose_rad
        assert 0.0 <= built.latency_s <= WORKSHOP.latency_s
        for sheet, ideal in zip(built.lasers, design.lasers, strict=True):
            angle = np.arccos(min(1.0, float(np.dot(sheet.normal, ideal.normal))))
            assert np.linalg.norm(sheet.normal) == 1.0 or abs(np.linalg.norm(sheet.normal) - 1.0) < 1e-12
            assert 0.0 < angle <= np.hypot(WORKSHOP.alpha_rad, WORKSHOP.lean_rad)
            assert 0.0 < abs(sheet.offset_mm) <= WORKSHOP.offset_mm


def test_papers_and_truth_name_the_same_machine(prototype: Scanner):
    built = workshop_machine(prototype, 3)

    assert built.scanner.machine_id == built.calibration.machine_id
    assert built.scanner.machine_id is not None


def test_what_stands_on_the_board_stands_on_the_leaning_board(prototype: Scanner):
    floor = workshop_machine(prototype, 3).calibration.floor
    transform = world_from_board(floor)
    corners = np.array([[100.0, 0.0, 0.0], [0.0, 100.0, 0.0], [-70.0, -20.0, 0.0]]) @ transform[:3, :3].T

    assert np.allclose(floor.distance_mm(corners + transform[:3, 3]), 0.0, atol=1e-12)
    assert np.allclose(transform[:3, :3].T @ transform[:3, :3], np.eye(3), atol=1e-14)
    assert np.linalg.det(transform) > 0.0
