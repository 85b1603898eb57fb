import numpy as np
import pytest

from stretch_bt.simulation import press
from stretch_bt.simulation.membrane.indenters.placed import place
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.sheet.effects import Effects
from stretch_bt.simulation.membrane.sheet.friction import LaggedFriction, remember
from stretch_bt.simulation.membrane.sheet.problem import ContactPenalty, Problem
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
    contact = ContactPenalty(body, old.stiffness, old.offset)
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


def test_drag_is_mu_times_the_load_and_reverses(stroke):
    there, back = stroke
    ahead, behind = there[4].detail, back[4].detail  # both at x = 0, after at least 4 mm
    for found, sign in ((ahead, 1), (behind, -1)):
        pressure, _, area = loads(found)
        # the sum of all tractions equals the sum of the limits but for the slope of the cap, whose mean cosine is about 0.95
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
