import numpy as np

from footscan.sim.machine import TrueMachine
from footscan.sim.objects import build_cylinder, build_sphere
from footscan.sim.visibility import count_sheets


def test_both_sheets_see_the_staves_of_a_cylinder_and_none_sees_its_bottom(machine: TrueMachine):
    pillar = build_cylinder(40.0, 120.0)
    sheets = count_sheets(machine.calibration, pillar)
    stave = np.abs(pillar.normal_world[:, 2]) < 0.1

    assert np.mean(sheets[stave] == 2) > 0.99
    assert (sheets[pillar.normal_world[:, 2] < -0.9] == 0).all()


def test_no_sheet_sees_the_underside_of_a_ball_and_both_see_its_flanks(machine: TrueMachine):
    ball = build_sphere(40.0, np.array([0.0, 0.0, 60.0]), subdivisions=4)
    sheets = count_sheets(machine.calibration, ball)
    up = ball.normal_world[:, 2]

    assert (sheets[up < -0.93] == 0).all()
    assert (sheets[(up > -0.3) & (up < 0.6)] == 2).all()
