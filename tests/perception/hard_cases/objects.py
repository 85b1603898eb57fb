"""Hard cases of outlines, fusion and dimensions: by name the call, and the value or the refusal that is right."""

from dataclasses import replace

import numpy as np

from stretch_bt.errors import IllConditioned, InvalidInput, NoContact
from stretch_bt.perception import Contact, circularity, cloud_of, fuse_contact, measure_object, outline_of

TURN = 2 * np.pi * np.arange(200) / 200
DISC = 0.0125 * np.column_stack([np.cos(TURN), np.sin(TURN)])
V, U = np.mgrid[:80, :80]
INSIDE = np.hypot(U - 40.2, V - 39.7) < 25
LABELS = np.where(INSIDE, 2, 0).astype(np.uint8)
PITCH = 0.4e-3


def near(value, tolerance):
    """Return a check that a result, or its first number, is the value within a tolerance."""

    def check(found):
        assert abs(float(found) - value) <= tolerance, f"{float(found)} is not {value} within {tolerance}"

    return check


def contact(points, **changes):
    points = np.asarray(points, dtype=float)
    rays = np.tile([0.0, 0.0, -1.0], (len(points), 1))
    made = Contact(points, rays, LABELS, 1e-4, None, None, 0.0, np.zeros((80, 80, 3)), np.ones((80, 80)))
    return replace(made, **changes)


def flat(count=400, at=(0.0, 0.0, 0.0)):
    side = int(np.sqrt(count))
    x, y = np.meshgrid(np.arange(side) * 0.5e-3, np.arange(side) * 0.5e-3)
    return np.column_stack([x.ravel(), y.ravel(), np.full(side * side, 0.01)]) + at


def labelled(**changes):
    """Return labels, some of which are changed: rows or columns by name."""
    labels = LABELS.copy()
    for place, label in changes.values():
        labels[place] = label
    return labels


def scattered(points, where, value):
    out = np.array(points, dtype=float)
    out[where] = value
    return out


def top_height(points, **options):
    return measure_object(cloud_of(points, 1e-4, **options)).height


CASES = {
    "outline: disc": (lambda: circularity(DISC), near(1.0, 0.002)),
    "outline: disc at 1e6 mm": (lambda: circularity(DISC + [1e3, -1e3]), near(1.0, 0.002)),
    "outline: disc in float32": (lambda: circularity(DISC.astype(np.float32)), near(1.0, 0.002)),
    "outline: disc in millimetres": (lambda: circularity(DISC * 1e3), near(1.0, 0.002)),
    "outline: every vertex twice": (lambda: circularity(np.repeat(DISC, 2, axis=0)), near(1.0, 0.002)),
    "outline: in whole pixels": (lambda: circularity(np.round(DISC / PITCH).astype(int)), near(1.0, 0.02)),
    "outline: three points": (lambda: circularity(DISC[[0, 67, 133]]), near(np.pi * np.sqrt(3) / 9, 1e-3)),
    "outline: empty": (lambda: circularity(np.zeros((0, 2))), (IllConditioned, "three vertices")),
    "outline: one point": (lambda: circularity(DISC[:1]), (IllConditioned, "three vertices")),
    "outline: all points one": (lambda: circularity(np.ones((50, 2))), (IllConditioned, "no area")),
    "outline: collinear": (lambda: circularity(np.outer(np.arange(50.0), [1.0, 2.0])), (IllConditioned, "no area")),
    "outline: NaN": (lambda: circularity(scattered(DISC, 3, np.nan)), (InvalidInput, "finite")),
    "outline: infinite": (lambda: circularity(scattered(DISC, 3, np.inf)), (InvalidInput, "finite")),
    "outline: (n, 3)": (lambda: circularity(np.zeros((50, 3))), (InvalidInput, "shape")),
    "outline: text": (lambda: circularity(np.array([["a", "b"]] * 9)), (InvalidInput, "real numbers")),
    "region: disc": (lambda: outline_of(LABELS, PITCH).roundness().circularity, near(1.0, 0.005)),
    "region: none": (lambda: outline_of(0 * LABELS, PITCH), (NoContact, "no pixel")),
    "region: all": (lambda: outline_of(0 * LABELS + 2, PITCH), (IllConditioned, "edge of the image")),
    "region: all invalid": (lambda: outline_of(0 * LABELS + 255, PITCH), (NoContact, "no pixel")),
    "region: one pixel": (
        lambda: outline_of(labelled(a=(LABELS > 0, 0), b=((40, 40), 2)), PITCH),
        (IllConditioned, "at least 40"),
    ),
    "region: cut by the edge": (lambda: outline_of(LABELS[:, 30:], PITCH), (IllConditioned, "edge of the image")),
    "region: two contacts": (lambda: outline_of(np.hstack([LABELS, LABELS]), PITCH), (IllConditioned, "2 pieces")),
    "region: border unseen": (lambda: outline_of(labelled(a=(V > 45, 255)), PITCH), (IllConditioned, "no depth")),
    "region: half of it dropped out": (
        lambda: outline_of(labelled(a=((U * 7 + V * 13) % 2 == 0, 255)), PITCH).roundness().circularity,
        near(1.0, 0.05),
    ),
    "region: depth instead of labels": (lambda: outline_of(LABELS.astype(float), PITCH), (InvalidInput, "uint8")),
    "region: points of another image": (lambda: outline_of(LABELS, np.zeros((40, 80, 3))), (InvalidInput, "shape")),
    "region: points not known": (lambda: outline_of(LABELS, np.full((80, 80, 3), np.nan)), (NoContact, "no pixel")),
    "fusion: empty": (lambda: fuse_contact(contact(np.zeros((0, 3)))), (NoContact, "no valid point")),
    "fusion: all invalid": (lambda: fuse_contact(contact(np.full((50, 3), np.nan))), (NoContact, "no valid point")),
    "fusion: three points": (lambda: fuse_contact(contact(flat()[:3])), (IllConditioned, "too small")),
    "fusion: some NaN": (lambda: fuse_contact(contact(scattered(flat(), slice(9), np.nan))).contacts, near(1, 0)),
    "fusion: some infinite": (lambda: fuse_contact(contact(scattered(flat(), slice(9), np.inf))).contacts, near(1, 0)),
    "fusion: all points one": (lambda: len(fuse_contact(contact(np.ones((50, 3))))), near(1, 0)),
    "fusion: collinear": (lambda: fuse_contact(contact(np.outer(np.arange(50), [1e-3, 0, 0]))).contacts, near(1, 0)),
    "fusion: float32": (lambda: fuse_contact(contact(flat().astype(np.float32))).points[:, 2].mean(), near(0.01, 1e-8)),
    "fusion: at 1e6 mm": (lambda: fuse_contact(contact(flat(at=(1e3, 1e3, 0)))).points[:, 2].mean(), near(0.01, 1e-8)),
    "fusion: noise not known": (lambda: fuse_contact(contact(flat(), noise=np.nan)), (InvalidInput, "noise")),
    "fusion: no noise": (lambda: fuse_contact(contact(flat(), noise=0.0)).sd.min(), near(1e-4, 1e-6)),
    "fusion: (n, 2)": (lambda: fuse_contact(contact(flat()[:, :2])), (InvalidInput, "shape")),
    "fusion: cell of nothing": (lambda: fuse_contact(contact(flat()), cell=0.0), (InvalidInput, "positive")),
    "dimensions: empty": (lambda: top_height(np.zeros((0, 3))), (NoContact, "no point")),
    "dimensions: all invalid": (lambda: top_height(np.full((500, 3), np.nan)), (NoContact, "no point")),
    "dimensions: three points": (lambda: top_height(flat()[:3]), (IllConditioned, "at least 100")),
    "dimensions: all points one": (lambda: top_height(np.ones((500, 3))), (IllConditioned, "line")),
    "dimensions: collinear": (
        lambda: top_height(np.outer(np.arange(500.0), [1.0, 2.0, 3.0])),
        (IllConditioned, "line"),
    ),
    "dimensions: exact plane": (lambda: top_height(flat()), near(0.01, 1e-9)),
    "dimensions: exact plane at 1e6 mm": (lambda: top_height(flat(at=(1e3, -1e3, 0.0))), near(0.01, 1e-7)),
    "dimensions: every point twice": (lambda: top_height(np.repeat(flat(), 2, axis=0)), near(0.01, 1e-9)),
    "dimensions: float32": (lambda: top_height(flat().astype(np.float32)), near(0.01, 1e-7)),
    "dimensions: no noise": (lambda: cloud_of(flat(), 0.0), (InvalidInput, "positive")),
    "dimensions: millimetres as integers": (
        lambda: cloud_of((flat() * 1e3).astype(int), 1.0),
        (InvalidInput, "floats"),
    ),
}
