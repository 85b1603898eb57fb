"""Shapes that only a camera sees are solved more loosely than forces, and never answer for one."""

from dataclasses import replace

import numpy as np
import pytest

from stretch_bt.errors import NoEquilibrium
from stretch_bt.simulation.effects.friction import Friction
from stretch_bt.simulation.fidelity.base import Place
from stretch_bt.simulation.fidelity.sheet import SheetFidelity
from stretch_bt.simulation.membrane.indenters.cube import Cube
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.membrane.indenters.several import Part, Several
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.materials import NeoHookean
from stretch_bt.simulation.membrane.sheet import newton, solver
from stretch_bt.simulation.membrane.sheet.problem import Evaluation
from stretch_bt.simulation.objects.base import HertzForm
from stretch_bt.simulation.scene.sections import MOUNT_PRESTRETCH, SHEAR_MODULUS

SHEET = (0.090, 0.100, 0.002, NeoHookean(SHEAR_MODULUS), MOUNT_PRESTRETCH)
PLACE = Place(Sphere(0.020), None, (0.0, 0.0), 0.0, (0.0, 0.0), 0.01, 0.02)
DEPTH = 4e-3


@pytest.fixture
def solved(monkeypatch):
    """The depths and settings of all that is solved."""
    calls, solve = [], solver.solve

    def noted(sheet, load, settings, start=None):
        calls.append((load.depth, settings.exact))
        return solve(sheet, load, settings, start)

    monkeypatch.setattr(solver, "solve", noted)
    return calls


@pytest.mark.hard
def test_a_press_that_was_seen_answers_for_no_force(solved):
    sheet = SheetFidelity(*SHEET)
    shape = sheet.press(PLACE, DEPTH, None).skin.points
    assert solved == [(DEPTH, False)]
    felt = float(sheet._solved_force(PLACE, DEPTH, None)[2])
    assert solved[1:] == [(DEPTH, True)]
    exact = sheet.press(PLACE, DEPTH, None).skin.points
    assert len(solved) == 2, "what is exact may be seen"
    assert np.abs(exact - shape).max() < 0.04e-3
    assert felt == pytest.approx(float(SheetFidelity(*SHEET)._solved_force(PLACE, DEPTH, None)[2]), rel=1e-6)


@pytest.mark.hard
def test_a_membrane_that_remembers_is_seen_as_exactly_as_it_is_felt(solved):
    SheetFidelity(*SHEET, [Friction(Friction.Parameters())]).press(PLACE, 1e-3, None)
    assert solved == [(1e-3, True)]


@pytest.mark.parametrize(
    ("left", "step", "solved"),
    [(1e-6, 1e-8, True), (1e-6, 1e-4, False), (1e-2, 1e-12, False)],
    ids=["only rounding is left", "energy is to be gained", "forces are out of balance"],
)
def test_what_rounding_keeps_from_balancing_any_better_is_solved(left, step, solved):
    """The whole force is 1, the energy 1, and one node of the middle row has a force left that a step would follow."""
    gradient, direction = np.zeros((4, 5, 3)), np.zeros((2, 5, 3))
    gradient[1, 2, 2], direction[0, 2, 2] = left, -step
    totals = np.zeros((1, 8))
    totals[0, 2] = 1.0
    assert newton._rounded(Evaluation(1.0, gradient, totals, np.zeros(3)), direction) is solved


BODIES = {
    "ball": Sphere(0.012),
    "disc": Cylinder(0.02),
    "cube": Cube(0.025),
    "two balls": Several((Part(Sphere(0.012), (-0.01, 0.0)), Part(Sphere(0.016), (0.01, 0.004), 0.001))),
}


@pytest.mark.parametrize("at", [(0.0, 0.0), (0.004, 0.027)])
@pytest.mark.parametrize("tilt", [(0.0, 0.0), (0.4, 0.3), (0.7, 0.0)])
@pytest.mark.parametrize("body", BODIES)
def test_no_point_that_a_camera_sees_lies_below_the_top_of_the_body(body, tilt, at):
    """Between quadrature points the solved shape does: of cubes on their edge by 0.3 to 0.9 mm."""
    place = Place(BODIES[body], None, at, 0.0, tilt, 0.02, 0.01, passing=True)
    sheet = SheetFidelity(*SHEET)
    seen = sheet.press(place, 0.01, None).skin.points
    solved = sheet._last[place].solved
    shape = solved.shape.points(seen.shape[1], seen.shape[0])
    raised = seen[..., 2] - shape[..., 2]
    np.testing.assert_array_equal(seen[..., :2], shape[..., :2])
    assert raised.min() == 0.0
    for contact in solved.contacts:
        before, after = (contact.body.gap(points.reshape(-1, 3)) for points in (shape, seen))
        top = before.normal[:, 2] > 0.5
        assert after.distance[top].min() > -2e-5
        untouched = (raised == 0.0).ravel()
        np.testing.assert_array_equal(after.distance[untouched], before.distance[untouched])
    assert 1e-5 < raised.max() < 1.2e-3


def test_balls_that_differ_a_little_share_their_solved_presses(solved):
    """Each was solved anew where the closed form of the place went with the ball: ten times the CPU time of a palpation."""
    sheet = SheetFidelity(*SHEET)
    for radius in (0.0200, 0.0201, 0.0203, 0.0206):
        ball = Sphere(2 * radius)
        place = Place(ball, HertzForm("sphere", radius), (0.0, 0.0), 0.0, (0.0, 0.0), radius, 0.02, varies=True)
        sheet.law(place, None)(DEPTH)
    once = len(solved)
    sheet.law(replace(place, body=Sphere(0.0408), form=HertzForm("sphere", 0.0204)), None)(DEPTH)
    assert len(solved) == once


def test_a_press_that_is_solved_loosely_is_counted(monkeypatch):
    exact = solver.solve

    def unbalanced(sheet, load, settings, start=None):
        if settings.exact:
            raise NoEquilibrium("no equilibrium within 0 iterations")
        return exact(sheet, load, settings, start)

    monkeypatch.setattr(solver, "solve", unbalanced)
    sheet = SheetFidelity(*SHEET)
    assert sheet._solved_force(PLACE, DEPTH, None)[2] > 0
    assert sheet.stats.counts["solve to 1 %"] == 1
