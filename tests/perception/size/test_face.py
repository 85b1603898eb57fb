"""Whether a face is seen to be flat."""

import numpy as np
import pytest

from stretch_bt.accuracy.perception.noise import Noise, observe
from stretch_bt.accuracy.perception.view import BodyPress, seen
from stretch_bt.errors import IllConditioned
from stretch_bt.perception import find_contact, measure_contact
from stretch_bt.simulation.membrane.indenters.cube import Cube
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.membrane.indenters.sphere import Sphere

NOISE = Noise(white=0.3e-3)


def measured(shape, stretch, every=1, **options):
    view = seen(BodyPress(shape, stretch, 0.010))
    contact = find_contact(observe(view, NOISE, 0))
    surface, labels = (np.ascontiguousarray(a[::every, ::every]) for a in (contact.surface, contact.labels))
    return view, measure_contact(surface, labels, stretch=stretch, **options)


@pytest.mark.parametrize(("diameter", "stretch"), [(0.02, 0.008), (0.03, 0.004), (0.06, 0.008), (0.06, 0.004)])
def test_a_ball_under_a_slack_membrane_is_not_told_as_a_small_flat_ellipse(diameter, stretch):
    with pytest.raises(IllConditioned, match="too small for its flatness to be seen"):
        measured(Sphere(diameter), stretch)
    assert measured(Sphere(diameter), stretch, hypothesis="ellipse")[1].shape == "ellipse"  # taken for granted


@pytest.mark.parametrize("shape", [Cylinder(0.008), Cylinder(0.010), Sphere(0.03)])
def test_a_circle_that_may_be_that_of_a_ball_is_stated_wider(shape):
    view, size = measured(shape, 0.0)
    true = shape.diameter if isinstance(shape, Cylinder) else 2 * view.radius
    assert size.shape == "circle"
    assert abs(size.diameter_i - true) < 1.5 * size.diameter_i_sd
    assert size.diameter_i_sd < 0.5 * true


def test_a_small_flat_face_is_measured_where_the_membrane_is_pulled():
    _, size = measured(Cylinder(0.010), 0.010)
    assert size.diameter_i == pytest.approx(0.010, abs=2 * size.diameter_i_sd)
    assert size.diameter_i_sd < 0.001


def test_a_face_is_as_large_however_fine_the_pixels_are():
    _, size = measured(Cube(0.012), 0.030, every=2)
    assert size.diameter_i == pytest.approx(0.012, abs=3 * size.diameter_i_sd)
