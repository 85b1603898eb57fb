"""Hard contacts for the measurement of size, each with what must come of it."""

from functools import cache

import numpy as np

from stretch_bt.accuracy.perception.noise import Noise, observe
from stretch_bt.accuracy.perception.view import CAMERA, PLANE_DISTANCE, Press, seen
from stretch_bt.errors import IllConditioned, InvalidInput, NoContact
from stretch_bt.perception import deproject, diameters, measure_contact, to_membrane
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder

STRETCH, WIDTH, DEPTH = 0.03, 0.02, 0.008
NOISE = Noise(white=0.3e-3)


@cache
def press(at=(0.0, 0.0)):
    """Return points in the membrane frame and labels that know the truth."""
    view = seen(Press(Cylinder(WIDTH), STRETCH, DEPTH, at))
    points, valid = deproject(observe(view, NOISE, 1))
    points = to_membrane(points, PLANE_DISTANCE)
    face = view.touching | (points[..., 2] > DEPTH - 0.1e-3)
    return points, np.where(valid, np.where(face, 2, np.where(points[..., 2] > 1e-3, 1, 0)), 255).astype(np.uint8)


def measured(at=(0.0, 0.0), move=lambda points: points, relabel=lambda labels: labels, **options):
    points, labels = press(at)
    return measure_contact(
        move(points.copy()), relabel(labels.copy()), **{"stretch": STRETCH, "hypothesis": "circle", **options}
    )


def about(value=WIDTH, within=0.4e-3):
    """Check the width, and that its stated error covers it."""

    def check(found):
        assert abs(found.diameter_i - value) < min(within, 4.0 * found.diameter_i_sd)
        assert found.diameter_i == found.diameter_j
        assert found.diameter_i_sd < 2.0 * within

    return check


def without_columns(first, last):
    def relabel(labels):
        labels[:, first:last] = 255
        return labels

    return relabel


def flying(points):
    rng = np.random.default_rng(5)
    hit = rng.random(points.shape[:2]) < 0.01
    points[..., 2][hit] += rng.uniform(-0.02, 0.02, int(hit.sum()))
    return points


def broken(points):
    points[::7, ::5] = np.nan
    points[3::7, 2::5, 2] = np.inf
    return points


def level(points):
    points[..., 2] = 0.0
    return points


def one_pixel(labels):
    labels[labels != 255] = 255
    labels[166, 106] = 2
    return labels


def all_as(value):
    return lambda labels: np.full_like(labels, value)


def undo_contact(labels):
    labels[labels == 2] = 1
    return labels


def two_presses():
    """Return two cylinders side by side, as the higher of two surfaces."""
    (left, labels), (right, others) = press((-0.018, 0.0)), press((0.018, 0.0))
    higher = right[..., 2] > left[..., 2]
    points = np.where(higher[..., None], right, left)
    points[..., :2] = deproject(np.full((CAMERA.height, CAMERA.width), PLANE_DISTANCE - DEPTH), CAMERA)[0][..., :2]
    return measure_contact(points, np.where(higher, others, labels), stretch=STRETCH)


def camera_frame(points):
    points[..., 2] = PLANE_DISTANCE - points[..., 2]
    return points


CASES = {
    "as it is": (measured, about()),
    "empty frame": (lambda: diameters(np.zeros((0, 0, 3)), np.zeros((0, 0), np.uint8)), (NoContact, "no valid pixel")),
    "all invalid": (lambda: measured(relabel=all_as(255)), (NoContact, "no valid pixel")),
    "nothing in contact": (lambda: measured(relabel=undo_contact), (NoContact, "labelled as in contact")),
    "one valid pixel": (lambda: measured(relabel=one_pixel), (NoContact, "hardly any")),
    "constant depth": (lambda: measured(move=level), (NoContact, "do not rise")),
    "concave": (lambda: measured(move=lambda p: p * [1.0, 1.0, -1.0]), (NoContact, "do not rise")),
    "two contacts": (two_presses, (IllConditioned, "two separate contacts")),
    "beside the rim cut off": (lambda: measured(relabel=without_columns(0, 76)), about()),
    "a sixth of the face cut off": (lambda: measured(relabel=without_columns(0, 90)), about(within=1e-3)),
    "half of the face cut off": (
        lambda: measured(relabel=without_columns(0, 106)),
        (IllConditioned, "too little of the"),
    ),
    "near the clamp": (lambda: measured((0.0, 0.025)), about(within=0.8e-3)),
    "at the free edge": (lambda: measured((0.034, 0.0)), (IllConditioned, "too little of the")),
    "half of the frame gone": (lambda: measured(relabel=without_columns(110, 213)), (IllConditioned, "too little")),
    "NaN and infinite": (lambda: measured(move=broken), about()),
    "flying pixels": (lambda: measured(move=flying), about()),
    "single precision": (lambda: measured(move=lambda p: p.astype(np.float32)), about()),
    "a kilometre away": (lambda: measured(move=lambda p: p + [1e3, -1e3, 0.0]), about()),
    "in the camera frame": (lambda: measured(move=camera_frame), about()),
    "stretch not known": (lambda: measured(stretch=None), about(within=0.6e-3)),
    "metres passed as millimetres": (lambda: measured(move=lambda p: p * 1e3), (InvalidInput, "metres")),
    "stretch in millimetres": (lambda: measured(stretch=30.0), (InvalidInput, "stretch")),
    "fillet below 0": (lambda: measured(fillet=-1e-3), (InvalidInput, "fillet")),
    "no such shape": (lambda: measured(hypothesis="star"), (InvalidInput, "'auto' or one of")),
    "labels of another type": (lambda: measured(relabel=lambda s: s.astype(int)), (InvalidInput, "uint8")),
    "points of another shape": (
        lambda: diameters(np.zeros((4, 3)), np.zeros((4, 4), np.uint8)),
        (InvalidInput, "h, w, 3"),
    ),
}
