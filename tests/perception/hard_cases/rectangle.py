"""Hard frames for the fit of a rectangle and of a free outline, on a press of a box that the sheet solver made."""

from functools import cache, partial

import numpy as np

from stretch_bt.accuracy.perception.noise import WHITE_03, Noise, observe
from stretch_bt.accuracy.perception.view import Press, seen
from stretch_bt.errors import InvalidInput, NoAnswer, NoContact
from stretch_bt.perception import deproject, to_membrane
from stretch_bt.perception.size.measure import measure_contact
from stretch_bt.simulation.membrane.indenters.box import Box

BOX = Press(Box(14e-3, 22e-3, 0.4), 30e-3, 9e-3, (3e-3, -2e-3))
EXACT = Noise(quantum=4e-6, dropouts=0.0)


@cache
def frame(noise=WHITE_03):
    """Points in the membrane frame and labels of the press."""
    view = seen(BOX)
    points, valid = deproject(observe(view, noise, 1))
    points = to_membrane(points, 0.2)
    face = view.touching | (points[..., 2] > 8.8e-3)
    return points, np.where(valid, np.where(face, 2, 1), 255).astype(np.uint8)


def measured(change=lambda p, v: (p, v), shape="rectangle", noise=WHITE_03):
    points, labels = (a.copy() for a in frame(noise))
    points, labels = change(points, labels)
    return measure_contact(points, labels, stretch=30e-3, hypothesis=shape)


def sides(size):
    """The sides within 0.8 mm of the truth and three of their standard deviations."""
    errors = np.abs(np.subtract(size.sides, (14e-3, 22e-3)))
    assert (errors < 0.8e-3).all()
    assert (errors < 3.0 * np.array(size.sides_sd)).all()
    assert all(np.isfinite([*size.sides_sd, size.rotation_sd, size.diameter_i_sd, size.diameter_j_sd]))


def sides_or_refusal(call):
    """The sides, if there are any, are within four of their standard deviations; a refusal has a reason."""
    try:
        size = call()
    except NoAnswer as error:
        assert error.reason
        return
    assert (np.abs(np.subtract(size.sides, (14e-3, 22e-3))) < 4.0 * np.array(size.sides_sd)).all()


def without(points, labels, where):
    labels[where(points)] = 255
    return points, labels


def broken(points, labels):
    rng = np.random.default_rng(0)
    hit = rng.random(labels.shape) < 0.2
    points[hit] = rng.choice([np.nan, np.inf, -np.inf], hit.sum())[:, None]
    labels[hit] = 255
    return points, labels


def flat(points, labels):
    points[..., 2] = 0.0
    return points, labels


def level(points, labels):
    points[..., 2] = 9e-3
    return points, labels


def third_gone(points, labels):
    return without(points, labels, lambda p: np.random.default_rng(1).random(p.shape[:2]) < 0.33)


CASES = {
    "exact": (partial(measured, noise=EXACT), sides),
    "exact, chosen": (partial(measured, noise=EXACT, shape="auto"), lambda size: _is(size, "rectangle")),
    "noisy, chosen": (partial(measured, shape="auto"), lambda size: _is(size, "rectangle")),
    "float32": (partial(measured, lambda p, v: (p.astype(np.float32), v)), sides),
    "NaN and infinite points": (partial(measured, broken), sides),
    "a third of the pixels dropped out": (partial(measured, third_gone), sides),
    "a quarter of the frame gone": (
        partial(
            sides_or_refusal,
            partial(measured, lambda p, v: without(p, v, lambda q: (q[..., 0] > 3e-3) & (q[..., 1] > 0))),
        ),
        None,
    ),
    "concave": (partial(measured, lambda p, v: (p * [1, 1, -1], v)), (NoContact, "rise")),
    "a plane called a contact": (partial(measured, flat), (NoContact, "rise")),
    "all at one height": (partial(measured, level), (NoAnswer, "contact")),
    "nothing in contact": (partial(measured, lambda p, v: (p, np.minimum(v, 1))), (NoContact, "labelled")),
    "all invalid": (partial(measured, lambda p, v: (p, np.full_like(v, 255))), (NoContact, "valid")),
    "millimetres": (partial(measured, lambda p, v: (p * 1e3, v)), (InvalidInput, "metres")),
    "labels of another type": (partial(measured, lambda p, v: (p, v.astype(int))), (InvalidInput, "uint8")),
    "points of another shape": (partial(measured, lambda p, v: (p[..., :2], v)), (InvalidInput, r"\(h, w, 3\)")),
    "free outline, exact": (
        partial(measured, shape="free_form", noise=EXACT),
        lambda size: _is(size, "free_form") or np.testing.assert_array_less(np.abs(size.diameter_j - 22e-3), 4e-3),
    ),
    "free outline of nothing": (partial(measured, flat, shape="free_form"), (NoContact, "rise")),
}


def _is(size, name):
    assert size.shape == name, size.evidence
