import math

import numpy as np
import pytest

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation import press
from stretch_bt.simulation.membrane.indenters.placed import place
from stretch_bt.simulation.membrane.indenters.several import Part, Several
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.sheet.effects import Effects, Mullins
from stretch_bt.simulation.membrane.sheet.friction import LaggedFriction, remember
from stretch_bt.simulation.membrane.sheet.increments import increments
from stretch_bt.simulation.membrane.sheet.problem import Contact, Problem
from stretch_bt.simulation.membrane.sheet.result import Load
from stretch_bt.simulation.membrane.sheet.settings import Settings

ROUND = {"indenter": "sphere:20mm", "stretch": 0.03, "depth": 0.006}


def rubbed(mu, *, start=None, settings=None, **options):
    return press(**ROUND | options, effects=Effects(friction=mu), start=start, settings=settings)


def loads(detail):
    """Return the pressure and the size of the traction of each point in contact, and its area."""
    (held,) = detail.memory.frictions
    on = held.pressure > 0
    return held.pressure[on], np.linalg.norm(held.traction, axis=2)[on], held.weight[on]


@pytest.fixture(scope="module")
def stroke():
    """A sphere dragged 10 mm to the right and back, mu = 0.3, by one state a mm."""
    rough = Settings(coarsen=2.0)
    state = rubbed(0.3, at=(-0.005, 0.0), settings=rough)
    there, back = np.arange(-4, 6) * 1e-3, np.arange(4, -5, -1) * 1e-3
    states = []
    for x in [*there, *back, -0.005, *there]:
        state = rubbed(0.3, at=(float(x), 0.0), start=state, settings=rough)
        states.append(state)
    return states[: len(there)], states[len(there) :]


def rubbing_problem():
    """A pressed sheet whose sphere has been moved a little, so that some points stick and some slide."""
    pressed = press(**ROUND, settings=Settings(coarsen=2.0)).detail
    mesh, control, unit = pressed.shape.mesh, pressed.shape.control, pressed.shape.unit
    (old,) = pressed.contacts
    x, y = mesh.touch
    places = mesh.evaluate(control, x.place.ravel(), y.place.ravel())
    (body,) = place(Sphere(0.02), (1.2e-5, -6e-6), (0.001, 0.0), pressed.load.depth)
    contact = Contact(body, old.stiffness, old.offset)
    contact.friction = LaggedFriction.after(remember(control, mesh, old, unit), places, old.body, contact, 1.0, unit)
    return Problem(mesh, pressed.sheet.law(), [contact], unit), control.copy()


def test_gradient_and_hessian_are_derivatives(check_derivatives):
    problem, control = rubbing_problem()
    contact = problem.contacts[0]
    assert contact.friction.energy(control, problem.mesh) > 0
    size = np.linalg.norm(remember(control, problem.mesh, contact, problem.unit).traction, axis=2)
    on = contact.friction.limit > 0
    slides = size[on] > 0.999 * contact.friction.limit[on]
    assert 0.1 < slides.mean() < 0.9  # both branches of the law
    direction = np.zeros(control.shape)
    direction[1:-1] = np.random.default_rng(6).normal(size=control[1:-1].shape)
    check_derivatives(problem, control, direction, 1e-5, 1e-3, step=1e-7)


def test_no_friction_is_the_limit_of_little():
    free = press(**ROUND)
    extra = [rubbed(mu).force / free.force - 1 for mu in (1e-6, 0.1, 0.4)]
    assert abs(extra[0]) < 1e-4  # the path settles to this
    assert 1e-3 < extra[1] < extra[2] < 0.05
    np.testing.assert_array_equal(free.detail.friction, 0.0)
    assert free.detail.memory.frictions == ()


def test_increments_hardly_matter():
    rough = Settings(coarsen=2.0)
    coarse = rubbed(0.5, depth=0.008, settings=rough)
    state = None
    for depth in np.arange(1, 17) * 0.5e-3:
        state = rubbed(0.5, depth=float(depth), start=state, settings=rough)
    assert state.force == pytest.approx(coarse.force, rel=1e-3)


@pytest.mark.parametrize("shape", ["sphere:20mm", "cylinder:20mm"])
def test_the_cone_holds_everywhere(shape):
    pressure, size, area = loads(rubbed(0.3, indenter=shape, depth=0.005).detail)
    over = np.maximum(size - 0.3 * pressure, 0.0)
    assert area @ over < 2e-3 * (area @ (0.3 * pressure))


def test_balance_counts_the_tractions():
    found = rubbed(0.5, at=(0.012, 0.009), tilt=(0.1, 0.0))
    assert found.balance < 1e-6
    assert np.linalg.norm(found.detail.force + found.detail.reaction) < 1e-6 * found.force
    assert found.detail.friction[2] > 0  # the sheet is held up
    twice = Several((Part(Sphere(0.012), (-0.014, 0.0)), Part(Sphere(0.012), (0.014, 0.0))))
    pair = rubbed(0.5, indenter=twice)
    assert pair.balance < 1e-6
    assert abs(pair.detail.friction[0]) < 1e-6 * pair.force


def test_drag_is_mu_times_the_load_and_reverses(stroke):
    there, back = stroke
    ahead, behind = there[4].detail, back[4].detail  # both at x = 0, after at least 4 mm
    for found, sign in ((ahead, 1), (behind, -1)):
        pressure, _, area = loads(found)
        # the sum of all tractions is that of the limits but for the slope of the cap, whose mean cosine is about 0.95
        assert 0.88 < sign * found.friction[0] / (0.3 * found.sheet.force_unit * (area @ pressure)) <= 1.0
    drag = (ahead.force[0] - behind.force[0]) / (ahead.force[2] + behind.force[2])
    assert drag == pytest.approx(0.3, rel=0.15)
    assert abs(ahead.force[0] + behind.force[0]) < 0.05 * abs(ahead.force[0])


def test_a_closed_loop_uses_up_work(stroke):
    there, back = stroke
    loop = [there[-1], *back]  # from +5 mm to -5 mm and again to +5 mm
    x, pull = (np.array(v) for v in zip(*((s.detail.load.at[0], s.detail.force[0]) for s in loop), strict=True))
    assert x[0] == pytest.approx(x[-1])
    work = np.diff(x) @ (pull[1:] + pull[:-1]) / 2
    assert work == pytest.approx(
        0.3 * there[4].force * 0.020, rel=0.2
    )  # mu N times the way, less what sticks at the turns


def test_much_friction_holds_points_where_they_touched():
    slips = {}
    for mu in (0.0, 20.0):
        before = rubbed(mu, depth=0.004) if mu else press(**ROUND | {"depth": 0.004})
        after = rubbed(mu, start=before) if mu else press(**ROUND, start=before)
        centre = before.detail.shape.mesh.evaluate(before.detail.shape.control, *[np.array([-1.5, 0.0, 1.5])] * 2)
        later = after.detail.shape.mesh.evaluate(after.detail.shape.control, *[np.array([-1.5, 0.0, 1.5])] * 2)
        slips[mu] = np.abs(later - centre)[..., :2].max()
    assert slips[20.0] < 0.1 * slips[0.0]


def test_symmetry_and_scale_are_exact():
    rough = Settings(coarsen=2.0)
    options = {"depth": 0.004, "at": (0.011, 0.007), "settings": rough}
    base = rubbed(0.4, **options)
    for sx, sy in ((-1, 1), (1, -1)):
        assert rubbed(0.4, **options | {"at": (sx * 0.011, sy * 0.007)}).force == pytest.approx(base.force, rel=1e-8)
    big = {"indenter": Sphere(0.2), "stretch": 0.3, "depth": 0.04, "at": (0.11, 0.07), "settings": rough}
    scaled = rubbed(0.4, **big, gauge=1.0, width=0.9, thickness=0.02, shear_modulus=47.4e9)
    assert scaled.force == pytest.approx(base.force * 1e8, rel=1e-8)


def test_fast_presses_rub_too():
    exact, fast = (rubbed(0.5, at=(0.004, 0.0), settings=Settings(exact=e)) for e in (True, False))
    assert fast.force == pytest.approx(exact.force, rel=0.01)
    drawn = [
        rubbed(0.5, at=(0.009, 0.0), start=s, settings=Settings(exact=e)) for s, e in ((exact, True), (fast, False))
    ]
    assert drawn[1].detail.friction[0] == pytest.approx(drawn[0].detail.friction[0], rel=0.03)


def test_paths_are_straight_and_end_exactly():
    load = Load(Sphere(0.02), 0.03, 0.0052, (0.01, 0.0), (0.1, 0.0))
    cold, first = list(increments(None, load, 1e-3)), next(increments(None, load, 1e-3))
    assert cold[-1] == load
    assert len(cold) == 6
    assert (first.at, first.depth) == (load.at, pytest.approx(0.0052 / 6))
    assert len(list(increments(None, Load(Sphere(0.02), 0.0, 1e-6, (0.0, 0.0), (0.0, 0.0)), 1e-3))) == 4
    there = Load(Sphere(0.02), 0.03, 0.0052, (0.0, 0.0), (0.1, 0.0))
    assert len(list(increments(there, load, 1e-3))) == 10
    assert list(increments(load, load, 1e-3)) == [load]


@pytest.mark.parametrize("mu", [-0.1, math.nan, math.inf])
def test_bad_coefficients(mu):
    with pytest.raises(InvalidInput, match="friction"):
        Effects(friction=mu)


def test_the_name_has_a_usual_value():
    assert Effects.named(["friction"]).friction == 0.5


def test_a_path_begins_where_the_sheet_is_reached():
    edge = {"indenter": "cone:45deg", "stretch": 0.03, "depth": 0.010, "at": (0.046, 0.0)}
    free = press(**edge)
    assert press(**edge, effects=Effects(friction=0.3)).force == pytest.approx(free.force, rel=0.2)


def test_a_path_goes_on_from_the_same_sheet_and_indenter():
    free = press(**ROUND)
    has_friction = Effects(friction=0.3)
    with pytest.raises(InvalidInput, match="same sheet"):
        press(**ROUND, effects=has_friction, start=free)
    with pytest.raises(InvalidInput, match="same indenter"):
        press(**ROUND | {"indenter": "cone:45deg"}, effects=has_friction, start=press(**ROUND, effects=has_friction))


def test_a_press_that_let_go_leaves_its_softening_and_not_its_slide():
    both = {"effects": Effects(friction=0.3, mullins=Mullins()), "stretch": 0.01, "settings": Settings(coarsen=2.0)}
    deep = press("sphere:20mm", depth=0.012, **both).detail
    assert deep.memory.frictions
    loose = deep.let_go()
    assert loose.let_go() is loose
    for body in ("sphere:20mm", "sphere:22mm"):
        new = press(body, depth=0.006, **both)
        again = press(body, depth=0.006, start=loose, **both)
        assert again.force < 0.99 * new.force
    with pytest.raises(InvalidInput, match="let_go"):
        press("cone:45deg", depth=0.006, start=deep, **both)


def test_friction_goes_on_under_a_ball_that_flattens():
    first = rubbed(0.3, at=(-0.005, 0.0))
    same, flatter = (
        rubbed(0.3, indenter=f"sphere:{d}mm", at=(0.0, 0.0), start=first).detail.friction for d in (20, 20.4)
    )
    assert same[0] != 0.0
    np.testing.assert_allclose(flatter, same, atol=0.05 * np.linalg.norm(same))
