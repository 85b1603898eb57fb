"""What no caller should hand over: each function of an image refuses it by what is wrong, or gives finite numbers."""

import dataclasses

import numpy as np
import pytest

from stretch_bt import perception
from stretch_bt.accuracy.perception.noise import WHITE_05, observe
from stretch_bt.accuracy.perception.view import BodyPress, seen
from stretch_bt.errors import IllConditioned, InvalidInput, NoContact
from stretch_bt.perception.types import INVALID
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.units import Estimate

STRAIN = Estimate(0.3, 0.05)
SURFACES = {
    "single precision": lambda s: s.astype(np.float32),
    "half precision": lambda s: s.astype(np.float16),
    "whole numbers": lambda s: np.nan_to_num(1e6 * s).astype(int),
    "objects": lambda s: s.astype(object),
    "lists": lambda s: s.tolist(),
    "complex": lambda s: s.astype(np.complex64),
    "bytes the other way": lambda s: s.astype(">f8"),
    "columns first": np.asfortranarray,
    "no pixel": lambda s: s[:0],
    "one pixel": lambda s: s[:1, :1],
    "one row": lambda s: s[60:61],
    "nothing seen": lambda s: np.full_like(s, np.nan),
    "endless heights": lambda s: np.where(s > 2e-3, np.inf, s),
    "millimetres": lambda s: 1e3 * s,
    "1e30": lambda s: 1e30 * s,
    "1e-30": lambda s: 1e-30 * s,
    "no width": lambda s: s * [0, 1, 1],
    "no height": lambda s: s * [1, 1, 0],
    "pressed the other way": lambda s: s * [1, 1, -1],
    "two axes": lambda s: s[..., 0],
}
LABELS = {
    "of another shape": lambda c: c[:-1],
    "whole numbers": lambda c: c.astype(int),
    "truths": lambda c: c == 2,
    "lists": lambda c: c.tolist(),
    "all in contact": lambda c: np.full_like(c, 2),
    "of no class": lambda c: np.full_like(c, 7),
}
IMAGES = {
    "segment": lambda s, c: perception.segment(s, c != INVALID),
    "track_height": lambda s, c: perception.track_height(s, c != INVALID, c),
    "measure_contact": perception.measure_contact,
    "surface_noise": lambda s, c: perception.surface_noise(s),
    "highest_of": lambda s, c: perception.highest_of(s),
    "outline_at": lambda s, c: perception.outline_at(s, 2e-3),
    "lift_off": lambda s, c: perception.lift_off(s, c, 0.01, 0.002, STRAIN, 0.1),
}
NUMBERS = {
    "measure_contact noise": lambda s, c, x: perception.measure_contact(s, c, noise=x),
    "measure_contact fillet": lambda s, c, x: perception.measure_contact(s, c, fillet=x),
    "measure_contact fillet_sd": lambda s, c, x: perception.measure_contact(s, c, fillet_sd=x),
    "measure_contact stretch": lambda s, c, x: perception.measure_contact(s, c, stretch=x),
    "segment stretch": lambda s, c, x: perception.segment(s, c != INVALID, stretch=x),
    "track_height reach": lambda s, c, x: perception.track_height(s, c != INVALID, c, reach=x),
    "outline_at below": lambda s, c, x: perception.outline_at(s, x),
    "lift_off height": lambda s, c, x: perception.lift_off(s, c, x, 0.002, STRAIN, 0.1),
    "lift_off thickness": lambda s, c, x: perception.lift_off(s, c, 0.01, x, STRAIN, 0.1),
    "lift_off gauge": lambda s, c, x: perception.lift_off(s, c, 0.01, 0.002, STRAIN, x),
}


@pytest.fixture(scope="module")
def contact():
    return perception.find_contact(observe(seen(BodyPress(Cylinder(0.02), stretch=0.03, depth=0.01)), WHITE_05, seed=1))


def numbers(answer):
    """Return all numbers of an answer, also in its fields; the hidden part of a contact is None, which adds none."""
    if isinstance(answer, Estimate):
        return np.array([float(answer), answer.sd])
    if dataclasses.is_dataclass(answer):
        fields = (getattr(answer, field.name) for field in dataclasses.fields(answer))
        return np.concatenate([numbers(value) for value in fields] or [np.empty(0)])
    return np.asarray(answer, dtype=float).ravel() if isinstance(answer, float | int | np.ndarray) else np.empty(0)


@pytest.mark.parametrize("name", IMAGES)
@pytest.mark.parametrize(
    ("kind", "odd"), [*(("surface", case) for case in SURFACES), *(("labels", case) for case in LABELS)]
)
def test_an_odd_image_is_refused_or_gives_finite_numbers(contact, name, kind, odd):
    surface, labels = contact.surface, contact.labels
    if kind == "surface":
        surface = SURFACES[odd](surface)
        labels = labels[: np.shape(surface)[0], : np.shape(surface)[1]] if np.ndim(surface) == 3 else labels
    else:
        labels = LABELS[odd](labels)
    try:
        answer = IMAGES[name](surface, labels)
    except (InvalidInput, NoContact, IllConditioned):
        return
    assert np.isfinite(numbers(answer)).all()


@pytest.mark.parametrize("name", NUMBERS)
@pytest.mark.parametrize("odd", [-1.0, np.nan, np.inf, "5 mm", [1.0]], ids=repr)
def test_a_number_that_is_none_is_named(contact, name, odd):
    if (name, odd) == ("lift_off height", -1.0):
        pytest.skip("a membrane may stand below its clamps")
    with pytest.raises(InvalidInput, match=name.split()[1].removesuffix("_sd").replace("below", "a level")):
        NUMBERS[name](contact.surface, contact.labels, odd)


def test_the_middle_of_a_face_that_leans_is_stated_wider(contact):
    """Its high side alone bends the membrane much: middles were 1.2 to 1.8 stated deviations off, most 7.5, and are 0.8 to 1.2."""
    leaning = contact.surface.copy()
    leaning[..., 2] += np.float32(0.05) * leaning[..., 0]
    upright, leant = (perception.measure_contact(s, contact.labels, stretch=0.03) for s in (contact.surface, leaning))
    assert max(upright.center_sd) < 0.11e-3
    assert 0.12e-3 < min(leant.center_sd) <= max(leant.center_sd) < 0.3e-3


DEPTH = np.full((60, 80), 0.2)
RAGGED = {
    "fit_sphere": lambda: perception.fit_sphere([[0, 0, 0], [1, 2]]),
    "circularity": lambda: perception.circularity([[0, 0], [1]]),
    "labels": lambda: perception.Contact.from_heights(DEPTH - 0.2, 1e-3, noise=1e-4, labels=[[1], [1, 2]]),
    "stretch of labels": lambda: perception.Contact.from_heights(
        DEPTH - 0.2, 1e-3, noise=1e-4, labels=DEPTH > 0, stretch="40 mm"
    ),
}


@pytest.mark.parametrize("name", RAGGED)
def test_rows_of_different_lengths_are_refused(name):
    with pytest.raises(InvalidInput):
        RAGGED[name]()
