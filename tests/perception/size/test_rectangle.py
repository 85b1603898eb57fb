from functools import cache

import numpy as np
import pytest

from stretch_bt.accuracy.perception.noise import WHITE_05, observe
from stretch_bt.accuracy.perception.view import BodyPress, seen
from stretch_bt.errors import InvalidInput
from stretch_bt.perception import find_contact
from stretch_bt.perception.size.box_prior import BoxPrior, shipped_box_prior
from stretch_bt.perception.size.free_form import FreeForm
from stretch_bt.perception.size.hypothesis import Context
from stretch_bt.perception.size.measure import measure_contact
from stretch_bt.perception.size.prior import shipped_prior
from stretch_bt.perception.size.rectangle import HEIGHT, RATIO, SKIRT, Rectangle
from stretch_bt.simulation.membrane.indenters.box import Box
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder

PRESSES = {
    "turned": BodyPress(Box(13e-3, 24e-3, 0.5), 30e-3, 8e-3, (4e-3, -5e-3)),
    "slack": BodyPress(Box(16e-3, 27e-3, -1.2), 0.0, 11e-3, (-6e-3, 2e-3)),
    "square": BodyPress(Box(15e-3, 15e-3, 0.3), 50e-3, 7e-3, (3e-3, 6e-3)),
}


@cache
def contact_of(press, seed=0):
    return find_contact(observe(seen(press), WHITE_05, seed))


@pytest.mark.parametrize("name", ["turned", pytest.param("slack", marks=pytest.mark.slow), "square"])
def test_a_box_is_found_to_be_a_rectangle_of_its_sides(name):
    press = PRESSES[name]
    contact = contact_of(press)
    size = measure_contact(contact.surface, contact.labels, stretch=press.stretch, fillet_sd=0.1e-3)
    assert size.shape == "rectangle"
    short, long = sorted((press.indenter.first, press.indenter.second))
    assert size.sides == pytest.approx((short, long), abs=0.7e-3)
    assert size.center == pytest.approx(press.at, abs=0.5e-3)
    turned = (size.rotation - press.indenter.angle + np.pi / 4) % (np.pi / 2) - np.pi / 4
    assert abs(turned) < np.radians(2.0)
    assert 0.05e-3 < min(size.sides_sd) <= max(size.sides_sd) < 1e-3


def test_the_stretch_may_be_unknown():
    contact = contact_of(PRESSES["turned"])
    size = measure_contact(contact.surface, contact.labels, hypothesis="rectangle")
    assert size.sides == pytest.approx((13e-3, 24e-3), abs=1e-3)


def test_the_fillet_moves_the_sides_and_its_uncertainty_their_deviation():
    contact = contact_of(PRESSES["turned"])
    sharp, blunt = (
        measure_contact(contact.surface, contact.labels, stretch=30e-3, hypothesis="rectangle", fillet=f, fillet_sd=sd)
        for f, sd in ((1e-3, 0.0), (2e-3, 0.5e-3))
    )
    grown = np.subtract(blunt.sides, sharp.sides)
    assert (grown > 1.0e-3).all()
    assert (grown < 2.2e-3).all()
    assert (np.array(blunt.sides_sd) > 0.5e-3).all()


def test_a_free_outline_measures_a_disc_within_its_deviation():
    press = BodyPress(Cylinder(20e-3), 20e-3, 8e-3, (2e-3, 3e-3))
    contact = contact_of(press)
    size = measure_contact(contact.surface, contact.labels, stretch=press.stretch, hypothesis="free_form")
    for value, sd in ((size.diameter_i, size.diameter_i_sd), (size.diameter_j, size.diameter_j_sd)):
        assert abs(value - 20e-3) < min(2.0 * sd, 2e-3)
    assert size.sides is None


def parameters(shape):
    q = np.zeros(SKIRT.stop)
    q[:5], q[RATIO], q[HEIGHT] = (2e-3, -1e-3, 14e-3, 22e-3, 0.4), 2.3, 8e-3
    mean = shape.skirt_prior.mean(q[[0, 1, 2, 3, 4, HEIGHT]][None], 20e-3)[0]
    q[SKIRT] = 1.1 * mean[1:] * 8e-3
    return q


def free_parameters(shape):
    q = np.zeros(35)
    q[:11] = 2e-3, -1e-3, 7e-3, 4e-3, 0.3e-3, 0.1e-3, 0.2e-3, -0.3e-3, 0.1e-3, 0.05e-3, 0.0
    q[11:13] = 2.3, 8e-3
    return np.concatenate([q[:11], q[11:13], [0.01, -0.01], np.linspace(3e-3, 0.5e-3, 14)])


@pytest.mark.parametrize(("kind", "make"), [(Rectangle, parameters), (FreeForm, free_parameters)])
def test_jacobians_are_derivatives(kind, make):
    shape = kind(Context(20e-3, 0.0, 0.0, shipped_prior()))
    q = make(shape)
    x, y = np.random.default_rng(2).uniform(-20e-3, 20e-3, (2, 3000))
    outside = shape.outside(q, x, y)
    near = (outside > -5e-3) & (outside < 12e-3)
    x, y = x[near], y[near]
    model, prior = shape.model(q, x, y)[1], shape.prior(q)[1]
    for n in range(q.size):
        move = np.zeros(q.size)
        move[n] = 1e-6
        numeric = (shape.model(q + move, x, y)[0] - shape.model(q - move, x, y)[0]) / 2e-6
        assert np.quantile(np.abs(model[n] - numeric), 0.98) < 0.02 * np.abs(numeric).max()
        numeric = (shape.prior(q + move)[0] - shape.prior(q - move)[0]) / 2e-6
        assert prior[n] == pytest.approx(numeric, abs=1e-3 * max(np.abs(numeric).max(), 1.0))


def test_sides_named_the_other_way_round_are_the_same_rectangle():
    shape = Rectangle(Context(20e-3, 1e-3, 0.0, shipped_prior()))
    q = parameters(shape)
    other = q.copy()
    other[2], other[3], other[4] = q[3], q[2], q[4] + np.pi / 2
    x, y = np.random.default_rng(3).uniform(-20e-3, 20e-3, (2, 500))
    assert shape.model(other, x, y)[0] == pytest.approx(shape.model(q, x, y)[0], abs=1e-8)
    assert shape.prior(other)[0] == pytest.approx(shape.prior(q)[0], abs=1e-6)


def test_the_prior_of_a_mirrored_contact_is_the_mirrored_prior():
    prior = shipped_box_prior()
    at = np.array([[3e-3, -4e-3, 12e-3, 25e-3, 0.7, 9e-3]])
    across, along = at * [[-1, 1, 1, 1, -1, 1]], at * [[1, -1, 1, 1, -1, 1]]
    from stretch_bt.perception.size.around import ORDERS

    # x to -x turns psi to pi - psi, y to -y turns it to -psi
    odd_x = np.array([1.0, *((-1.0) ** n * (1.0 if part == "c" else -1.0) for _, n, part in ORDERS)])
    odd_y = np.array([1.0, *(1.0 if part == "c" else -1.0 for _, n, part in ORDERS)])
    for mirrored, sign in ((across, odd_x), (along, odd_y)):
        assert prior.mean(mirrored, 20e-3) == pytest.approx(prior.mean(at, 20e-3) * sign, abs=1e-12)


def test_a_prior_survives_its_file_and_nonsense_is_refused():
    prior = shipped_box_prior()
    again = BoxPrior.from_json(prior.to_json())
    assert again.known.coefficients == pytest.approx(prior.known.coefficients, rel=1e-6)
    assert again.systematic == pytest.approx(prior.systematic, rel=1e-6)
    with pytest.raises(InvalidInput, match="perception_skirt_rectangle"):
        BoxPrior.from_json("{}")
