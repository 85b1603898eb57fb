import math
from functools import lru_cache

import numpy as np
import pytest

from stretch_bt.errors import NoEquilibrium
from stretch_bt.simulation.membrane.axisymmetric import CircularMembrane
from stretch_bt.simulation.membrane.indenters.base import Zone
from stretch_bt.simulation.membrane.indenters.placed import place
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.materials import MooneyRivlin, NeoHookean
from stretch_bt.simulation.membrane.materials.base import energy
from stretch_bt.simulation.membrane.round_sheet import RoundSheet
from stretch_bt.simulation.membrane.sheet.effects import Effects, Mullins
from stretch_bt.simulation.membrane.sheet.newton import Newton
from stretch_bt.simulation.membrane.sheet.problem import GRADIENT, ContactPenalty, Problem
from stretch_bt.simulation.membrane.sheet.settings import Settings

RUBBER = NeoHookean(1.0)
SPHERE = Sphere(0.4)  # R/a = 0.2
MEMBRANE = RoundSheet(1.0, 1.0, RUBBER, 1.2)


@lru_cache
def axisymmetric(prestretch, depth, material=RUBBER):
    return CircularMembrane(1.0, 1.0, material, prestretch).press(0.2, depth)


def meshed(membrane, elements):
    zone = [Zone(-50.0, 50.0, 100 / elements)]
    sheet = membrane.sheet
    return sheet, sheet.outline.mesh(100.0, zone, zone, 1.0)


def test_the_mesh_covers_the_disc():
    _, mesh = meshed(MEMBRANE, 8)
    tx, ty = mesh.touch
    assert np.einsum("yxpq,yp,xq->", mesh.spread, ty.weight, tx.weight) == pytest.approx(math.pi * 2500, rel=1e-13)
    assert mesh.areas.sum() == pytest.approx(math.pi * 2500, rel=1e-13)
    along = np.linspace(-50.0, 50.0, 33)
    for x, y in ((along, np.array([-50.0])), (np.array([50.0]), along)):
        radii = np.linalg.norm(mesh.evaluate(mesh.rest, x, y), axis=-1)
        np.testing.assert_allclose(radii, 50.0, rtol=1e-3)


@pytest.mark.parametrize("prestretch", [1.0, 1.3])
def test_an_even_stretch_is_exact_and_balanced(prestretch):
    sheet, mesh = meshed(RoundSheet(1.0, 1.0, RUBBER, prestretch), 6)
    problem = Problem(mesh, sheet.law(), [], sheet.unit)
    found = problem.evaluate(sheet.outline.flat(mesh, sheet.span(0.0)), GRADIENT)
    exact = math.pi / prestretch**2 * energy(RUBBER, prestretch, prestretch)
    assert found.energy * sheet.force_unit * sheet.unit == pytest.approx(exact, rel=1e-13, abs=1e-13)
    np.testing.assert_allclose(found.gradient[1:-1], 0.0, atol=1e-12)


def test_gradient_and_hessian_are_derivatives_and_the_rim_is_held(check_derivatives):
    sheet, mesh = meshed(MEMBRANE, 9)
    (body,) = place(SPHERE, (0.1, 0.05), (0.0, 0.0), 0.3)
    problem = Problem(mesh, sheet.law(), [ContactPenalty(body, 2.0, 0.05)], sheet.unit)
    rng = np.random.default_rng(3)
    flat = sheet.outline.flat(mesh, sheet.span(0.0))
    control = sheet.outline.tent(flat, [body], sheet.span(0.0), sheet.unit)
    control = sheet.outline.clamped(mesh, control + rng.normal(0, 0.05, control.shape), sheet.span(0.0))
    direction = np.zeros(control.shape)
    direction[1:-1, 1:-1] = rng.normal(size=control[1:-1, 1:-1].shape)
    here, full = check_derivatives(problem, control, direction, 1e-6, 1e-4)
    assert here.totals[0, 5] > 10  # points in contact
    sides = np.arange(problem.unknowns).reshape(-1, mesh.shape[1], 3)[:, [0, -1]].ravel()
    np.testing.assert_array_equal(full[sides], np.eye(problem.unknowns)[sides])
    np.testing.assert_allclose(here.reaction + here.gradient[1:-1].sum(axis=(0, 1)), -here.force, atol=1e-9)


def test_a_smooth_energy_converges_at_order_four():
    energies = []
    for elements in (6, 12, 24):
        sheet, mesh = meshed(RoundSheet(1.0, 1.0, RUBBER, 1.2, Effects(sag=0.05)), elements)
        problem = Problem(mesh, sheet.law(), [], sheet.unit)
        problem.weight = sheet.weight
        start = sheet.outline.flat(mesh, sheet.span(0.0))
        start[1:-1, 1:-1, 2] = -3.0
        energies.append(Newton(problem, start).run(lambda step: step.size < 1e-9, 50).evaluation.energy)
    assert 3.7 < math.log2((energies[0] - energies[1]) / (energies[1] - energies[2])) < 4.3


@pytest.mark.parametrize(
    ("prestretch", "depth"),
    [pytest.param(1.05, 0.1, marks=pytest.mark.slow), (1.2, 0.3), pytest.param(1.5, 0.1, marks=pytest.mark.slow)],
)
def test_a_press_converges_to_the_axisymmetric_one(prestretch, depth):
    exact = axisymmetric(prestretch, depth)
    still = math.pi / prestretch**2 * energy(RUBBER, prestretch, prestretch)
    off = []
    for scale in (1.0, 0.5, 0.25):  # every element follows, not only the smallest
        settings = Settings(coarsen=scale, growth=1.6**scale)
        found = RoundSheet(1.0, 1.0, RUBBER, prestretch).press(SPHERE, depth, settings=settings)
        assert found.balance < 1e-6
        assert not found.warnings
        off.append(abs((found.energy - exact.energy) / (exact.energy - still)))
        assert found.force[2] == pytest.approx(exact.force, rel=2e-3 * scale)
    assert off[0] < 3e-3
    # the curvature jumps at the edge of the contact, which leaves order 3 of the elements' 4
    assert math.log2(off[0] / off[2]) / 2 > 2.7
    assert abs(found.force[2] / exact.force - 1) < 1e-3


def test_the_shape_is_the_axisymmetric_one():
    exact = axisymmetric(1.2, 0.3)
    found = MEMBRANE.press(SPHERE, 0.3)
    radii = np.linspace(0.02, 0.95, 12)
    truth = np.interp(radii, *exact.profile.T)
    for angle in (0.0, 0.6):
        height = found.shape.height(radii * math.cos(angle), radii * math.sin(angle))
        np.testing.assert_allclose(height, truth, atol=2e-3)
    assert found.region().radius == pytest.approx(exact.contact_radius, rel=0.015)
    assert np.isnan(found.shape.height(np.array([0.8]), np.array([0.8]))[0])


def test_no_direction_is_special():
    # the mesh has four corners at 45 degrees; a press towards them must not feel them
    forces = []
    for angle in np.radians([0.0, 22.5, 45.0]):
        away = np.array([math.cos(angle), math.sin(angle)])
        found = MEMBRANE.press(SPHERE, 0.15, at=tuple(0.45 * away))
        forces.append([found.force[2], away @ found.force[:2]])
    np.testing.assert_allclose(forces, forces[:1] * np.ones((3, 1)), atol=2e-3 * forces[0][0])
    mirrored = MEMBRANE.press(SPHERE, 0.15, at=(-0.45 * math.cos(math.pi / 8), -0.45 * math.sin(math.pi / 8)))
    assert mirrored.force[2] == pytest.approx(forces[1][0], rel=1e-8)


def test_materials_effects_and_warm_starts_carry_over():
    mooney = MooneyRivlin(1.0, 0.3)
    exact = axisymmetric(1.2, 0.2, mooney)
    first = RoundSheet(1.0, 1.0, mooney, 1.2).press(SPHERE, 0.2)
    assert first.force[2] == pytest.approx(exact.force, rel=3e-3)
    soft = RoundSheet(1.0, 1.0, mooney, 1.2, Effects(mullins=Mullins()))
    deep = soft.press(SPHERE, 0.3)
    assert soft.press(SPHERE, 0.2).force[2] == pytest.approx(first.force[2], rel=1e-6)
    assert soft.press(SPHERE, 0.2, start=deep).force[2] < 0.97 * first.force[2]
    warm = RoundSheet(1.0, 1.0, mooney, 1.2).press(SPHERE, 0.22, start=first)
    cold = RoundSheet(1.0, 1.0, mooney, 1.2).press(SPHERE, 0.22)
    assert warm.force[2] == pytest.approx(cold.force[2], rel=1e-3)
    assert RoundSheet(1.0, 1.0, mooney).press(SPHERE, 0.2).force[2] < 0.5 * first.force[2]


def test_a_ball_that_sinks_through_the_elements_asks_for_a_finer_mesh_which_finds_the_press():
    membrane, ball = RoundSheet(0.08, 0.003, NeoHookean(20e3), 2.0), Sphere(0.012)
    with pytest.raises(NoEquilibrium, match=r"too coarse for it: use a finer mesh, such as one of 0\.52 mm") as refused:
        membrane.press(ball, 0.019)
    assert "limit point" not in refused.value.reason
    found = membrane.press(ball, 0.019, settings=Settings(mesh=0.52e-3))
    assert abs(found.force[2] - 1.8963) < 2 * found.force_error < 0.03
