"""Hard cases of what is taken for the membrane: not a number, saturated, in another unit, round, or in two parts."""

import functools

import numpy as np

from stretch_bt.accuracy.perception.noise import WHITE_05, observe
from stretch_bt.accuracy.perception.view import CAMERA, PLANE_DISTANCE, Press, seen
from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.perception import (
    deproject,
    diameters,
    estimate_normals,
    expected_ratio,
    outline_of,
    segment,
    to_membrane,
)
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.membrane.indenters.several import Part, Several
from stretch_bt.simulation.membrane.indenters.sphere import Sphere

FACE = Cylinder(0.02)
PAIR = Several((Part(Cylinder(0.014), (-0.012, 0.0)), Part(Cylinder(0.010), (0.012, 0.0))))


@functools.cache
def depth(body=FACE):
    return observe(seen(Press(body, 0.03, 0.008)), WHITE_05, 0).depth.astype(float)


def saturated():
    image = depth().copy()
    image[np.random.default_rng(0).random(image.shape) < 1e-3] = 8.19
    return image


def camera(image):
    return deproject(image, CAMERA)


def membrane(image):
    points, valid = camera(image)
    return to_membrane(points, PLANE_DISTANCE), valid


def labelled(body):
    points, valid = membrane(depth(body))
    return points, segment(points, valid)


def cut():
    image = depth().copy()
    image[:, :106] = 0.0
    points, valid = membrane(image)
    return segment(points, valid), points


def covers(labels):
    """Check that about all of the face is labelled, and little else."""
    truth = seen(Press(FACE, 0.03, 0.008)).touching
    assert ((labels == 2) & truth).sum() > 0.75 * ((labels == 2) | truth).sum()


def all_valid():
    points, valid = membrane(depth())
    return segment(points, np.ones_like(valid))


CASES = {
    "NaN marked as valid": (all_valid, covers),
    "saturated pixels, camera frame": (lambda: segment(*camera(saturated())), covers),
    "saturated pixels, membrane frame": (lambda: segment(*membrane(saturated())), covers),
    "points in millimetres": (
        lambda: segment(1000.0 * membrane(depth())[0], membrane(depth())[1]),
        (InvalidInput, "another unit"),
    ),
    "stretch in millimetres": (lambda: segment(*membrane(depth()), stretch=30.0), (InvalidInput, "stretch is from 0")),
    "stretch that is no number": (lambda: expected_ratio(float("nan")), (InvalidInput, "stretch is from 0")),
    "kernel of no width": (lambda: estimate_normals(*membrane(depth()), kernel=0.0), (InvalidInput, "kernel")),
    "two cylinders side by side": (lambda: diameters(*labelled(PAIR)), (IllConditioned, "separate contacts")),
    "a sphere for a flat face": (
        lambda: diameters(*labelled(Sphere(0.05)), stretch=0.03),
        (IllConditioned, "outline|round|lies outside"),
    ),
    "an outline of half a contact": (lambda: outline_of(*cut()), (IllConditioned, "without depth|edge of the image")),
}
