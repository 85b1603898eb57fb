"""Shapes that only a camera sees are solved more loosely than forces, and never answer for one."""

import numpy as np
import pytest

from stretch_bt.simulation.effects.bending import Bending
from stretch_bt.simulation.effects.friction import Friction
from stretch_bt.simulation.fidelity.base import Place
from stretch_bt.simulation.fidelity.sheet import SheetFidelity
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.materials import NeoHookean
from stretch_bt.simulation.membrane.sheet import solver
from stretch_bt.simulation.membrane.sheet.effects import Effects
from stretch_bt.simulation.membrane.sheet.geometry import Sheet
from stretch_bt.simulation.membrane.sheet.result import Load
from stretch_bt.simulation.membrane.sheet.settings import Settings
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


def test_a_membrane_that_remembers_is_seen_as_exactly_as_it_is_felt(solved):
    SheetFidelity(*SHEET, [Friction(Friction.Parameters())]).press(PLACE, 1e-3, None)
    assert solved == [(1e-3, True)]


def test_a_touch_that_rounding_keeps_from_balancing_any_better_is_solved():
    bends = Bending(Bending.Parameters()).on_sheet(Effects())
    sheet = Sheet(0.100, 0.090, 0.002, NeoHookean(SHEAR_MODULUS), MOUNT_PRESTRETCH, bends)
    touch = solver.solve(sheet, Load(Sphere(0.020), 0.0, 2e-5, (0.0, 0.0), (0.0, 0.0), 0.0), Settings())
    assert 0 < touch.force[2] < 2e-3
    assert touch.balance < 1e-3
    assert touch.pivot > 0, "it is a minimum"
