"""A touch as light as rounding makes it has an equilibrium, with a force that goes to nothing."""

import numpy as np
import pytest

from stretch_bt.simulation.effects.bending import Bending
from stretch_bt.simulation.effects.friction import Friction
from stretch_bt.simulation.effects.mullins import Softening
from stretch_bt.simulation.effects.sag import Sag
from stretch_bt.simulation.fidelity.base import Place
from stretch_bt.simulation.fidelity.sheet import SheetFidelity
from stretch_bt.simulation.membrane.indenters.cone import Cone
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.materials import NeoHookean
from stretch_bt.simulation.scene.sections import MOUNT_PRESTRETCH, SHEAR_MODULUS

SHEET = (0.090, 0.100, 0.002, NeoHookean(SHEAR_MODULUS), MOUNT_PRESTRETCH)


@pytest.mark.parametrize(
    "body", [Sphere(0.020), pytest.param(Cone(0.7854, 0.0005), marks=pytest.mark.slow)], ids=["sphere", "cone"]
)
@pytest.mark.parametrize(
    "effects", [(), pytest.param((Friction(Friction.Parameters()),), marks=pytest.mark.slow)], ids=["plain", "friction"]
)
def test_a_grazing_touch(body, effects):
    sheet = SheetFidelity(*SHEET, effects)
    place = Place(body, None, (0.0, 0.0), 0.0, (0.0, 0.0), 0.01, 0.0)
    forces = [float(sheet.force(place, depth, None)[2]) for depth in (1e-18, 1e-9, 1e-6, 2e-5, 1e-4)]
    assert forces == sorted(forces)
    assert forces[0] >= 0.0
    assert forces[0] < 1e-15
    assert forces[-1] > 0
    top = sheet.press(place, 1e-18, None).skin.points[..., 2].max()
    assert top == pytest.approx(0.0, abs=3e-5)


@pytest.mark.parametrize(
    "travels", [(8e-5, 5e-4), pytest.param((8e-5, 1.2e-4, 1.6e-4, 5e-4), marks=pytest.mark.slow)], ids=["few", "more"]
)
def test_a_tip_that_a_hanging_membrane_just_meets(travels):
    # bent, softened and hanging, its energy is rounded by more than a light touch changes it
    effects = [kind(kind.Parameters()) for kind in (Bending, Softening, Sag)]
    sheet = SheetFidelity(*SHEET, effects)
    place = Place(Cone(0.7854, 0.0005), None, (0.0, 0.0), 0.0, (0.0, 0.0), 0.01, 0.0)
    forces = [float(sheet.force(place, travel - sheet.lift(place), None)[2]) for travel in travels]
    assert forces == sorted(forces)
    assert forces[0] > 0


def test_off_its_middle_a_hanging_membrane_is_touched_where_it_hangs():
    sheet = SheetFidelity(*SHEET, [Sag(None)])
    places = [Place(Sphere(0.020), None, (0.0, y), 0.0, (0.0, 0.0), 0.01, 0.0) for y in (0.0, 0.020, 0.035)]
    lifts = [sheet.lift(place) for place in places]
    assert lifts[0] > lifts[1] > lifts[2] > 0
    free = sheet.free(0.0).points
    for place, lift in zip(places, lifts, strict=True):
        near = np.hypot(*(free[..., :2] - place.at).T).T.argmin()
        assert lift == pytest.approx(-free[..., 2].ravel()[near], abs=1e-5)
        forces = [sheet.law(place, None)(travel - lift)[0] for travel in (1e-5, 1e-4, 2e-4, 3e-4, 5e-4, 1e-3)]
        assert forces == sorted(forces)
        assert forces[0] > 0
