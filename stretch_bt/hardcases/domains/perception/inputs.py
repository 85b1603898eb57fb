"""Inputs that are taken for the membrane: not a number, saturated, in another unit, round, or in two parts."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.accuracy.perception.noise import WHITE_05, observe
from stretch_bt.accuracy.perception.view import CAMERA, PLANE_DISTANCE, BodyPress, seen
from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.hardcases.expect import Check, Refusal
from stretch_bt.hardcases.hard import group
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

FACE = BodyPress(Cylinder(0.02), 0.03, 0.008)
BALL = BodyPress(Sphere(0.05), 0.03, 0.008)
PAIR = BodyPress(Several((Part(Cylinder(0.014), (-0.012, 0.0)), Part(Cylinder(0.010), (0.012, 0.0)))), 0.03, 0.008)
Image = npt.NDArray[np.float64]


@functools.cache
def _depth(wanted: BodyPress = FACE) -> Image:
    return observe(seen(wanted), WHITE_05, 0).depth.astype(float)


def _saturated() -> Image:
    image = _depth().copy()
    image[np.random.default_rng(0).random(image.shape) < 1e-3] = 8.19
    return image


def _camera(image: Image) -> Any:
    return deproject(image, CAMERA)


def _membrane(image: Image) -> Any:
    points, valid = _camera(image)
    return to_membrane(points, PLANE_DISTANCE), valid


def _labelled(wanted: BodyPress) -> Any:
    points, valid = _membrane(_depth(wanted))
    return points, segment(points, valid)


def _cut() -> Any:
    image = _depth().copy()
    image[:, :106] = 0.0
    points, valid = _membrane(image)
    return segment(points, valid), points


def _all_valid() -> Any:
    points, valid = _membrane(_depth())
    return segment(points, np.ones_like(valid))


def _covers(labels: Any) -> bool:
    truth = seen(FACE).touching
    return bool(((labels == 2) & truth).sum() > 0.75 * ((labels == 2) | truth).sum())


COVERS = Check("the labelled part is the face, but for a quarter", _covers)

CASES = (
    *group(
        "pixels without depth come as NaN or saturated, and a mask may call them valid",
        {
            "NaN marked as valid": (_all_valid, COVERS),
            "saturated pixels, camera frame": (lambda: segment(*_camera(_saturated())), COVERS),
            "saturated pixels, membrane frame": (lambda: segment(*_membrane(_saturated())), COVERS),
        },
        prefix="input, ",
    ),
    *group(
        "a number in another unit, or none, gives an answer that looks right",
        {
            "points in millimetres": (
                lambda: segment(1000.0 * _membrane(_depth())[0], _membrane(_depth())[1]),
                Refusal(InvalidInput, "another unit"),
            ),
            "stretch in millimetres": (
                lambda: segment(*_membrane(_depth()), stretch=30.0),
                Refusal(InvalidInput, "stretch is from 0"),
            ),
            "stretch that is no number": (
                lambda: expected_ratio(float("nan")),
                Refusal(InvalidInput, "stretch is from 0"),
            ),
            "kernel of no width": (
                lambda: estimate_normals(*_membrane(_depth()), kernel=0.0),
                Refusal(InvalidInput, "kernel"),
            ),
        },
        prefix="input, ",
    ),
    *group(
        "the object is not the one flat face whose diameter is wanted",
        {
            "two cylinders side by side": (
                lambda: diameters(*_labelled(PAIR)),
                Refusal(IllConditioned, "separate contacts"),
            ),
            "a sphere for a flat face": (
                lambda: diameters(*_labelled(BALL), stretch=0.03),
                Refusal(IllConditioned, "outline|round|lies outside|a ball looks alike"),
            ),
            "an outline of half a contact": (
                lambda: outline_of(*_cut()),
                Refusal(IllConditioned, "without depth|edge of the image"),
            ),
        },
        prefix="input, ",
    ),
)
