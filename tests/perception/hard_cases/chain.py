"""Hard frames for what runs on every one: deproject, mask, average, segment, find_contact, heights and detection."""

import dataclasses

import numpy as np

from stretch_bt.errors import IllConditioned, InvalidInput, NoContact
from stretch_bt.frames import DepthFrame, Intrinsics
from stretch_bt.perception import (
    ContactDetector,
    HeightTracker,
    average_frames,
    classify,
    curvatures,
    deproject,
    estimate_normals,
    find_contact,
    frame_noise,
    mask_membrane,
    pixel_noise,
    segment,
    to_membrane,
    track_height,
)
from stretch_bt.perception.types import CONTACT, DEFORMED, INVALID, UNDEFORMED

H, W, F, D = 160, 200, 400.0, 0.2
LENS = Intrinsics(F, F, (W - 1) / 2, (H - 1) / 2, W, H)
FLAT = np.full((H, W), D, dtype=np.float32)
OUTER = 45e-3
NAN, INF = np.float32(np.nan), np.float32(np.inf)


def press(x0=0.0, y0=0.0, radius=20e-3, angle=0.5, noise=0.2e-3, seed=0):
    """Depth of a cap with a logarithmic skirt that meets it without a kink, on a flat membrane."""
    x = (np.arange(W) - LENS.cx)[None, :] / F * D - x0
    y = (np.arange(H) - LENS.cy)[:, None] / F * D - y0
    r = np.hypot(x, y)
    edge = radius * np.sin(angle)
    drop = edge**2 / (radius * np.cos(angle))
    base = drop * np.log(OUTER / edge)
    skirt = base - drop * np.log(np.maximum(r, 1e-6) / edge)
    cap = base - radius * np.cos(angle) + np.sqrt(np.maximum(radius**2 - r * r, 0.0))
    height = np.where(r < edge, cap, np.maximum(skirt, 0.0))
    return (D - height + np.random.default_rng(seed).normal(0.0, noise, (H, W))).astype(np.float32)


def still(count):
    rng = np.random.default_rng(7)
    return [(FLAT + rng.normal(0.0, 0.2e-3, (H, W))).astype(np.float32) for _ in range(count)]


TOP = D - float(press(noise=0.0).min())


def with_pixels(image, pixels):
    image = image.copy()
    for (v, u), value in pixels.items():
        image[v, u] = value
    return image


def one_pixel():
    return with_pixels(0 * FLAT, {(80, 100): 0.2})


def half_gone():
    image = press()
    image[:, :85] = 0.0
    return image


def frame(depth, unit=0.02e-3, **changes):
    raw = np.where(np.isfinite(depth), np.rint(depth / unit), 0).astype(np.uint16)
    lens = Intrinsics(F, F, (depth.shape[1] - 1) / 2, (depth.shape[0] - 1) / 2, depth.shape[1], depth.shape[0])
    return DepthFrame(raw, unit, lens, 0.0, 0, D, **changes)


def cloud(depth):
    points, valid = deproject(depth, LENS)
    return to_membrane(points, D), valid


def labels(depth, **options):
    return segment(*cloud(depth), **options)


def height(depth):
    points, valid = cloud(depth)
    return track_height(points, valid, segment(points, valid))


def followed(make, *images):
    follower = make()
    return [follower.update(image) for image in images]


def all_are(label):
    def check(found):
        assert (found == label).all()

    return check


def covers(*places, least=0.9):
    """Contact in the discs (x, y, radius), m, and nowhere else."""

    def check(found):
        x = (np.arange(W) - LENS.cx)[None, :] / F * D
        y = (np.arange(H) - LENS.cy)[:, None] / F * D
        inside = np.any([np.hypot(x - a, y - b) < 0.7 * r for a, b, r in places], axis=0)
        near = np.any([np.hypot(x - a, y - b) < 1.5 * r for a, b, r in places], axis=0)
        seen = found != INVALID
        assert (found[inside & seen] == CONTACT).mean() > least
        assert not (found[~near] == CONTACT).any()

    return check


def close_to(value, within):
    def check(found):
        assert abs(float(found) - value) < within

    return check


def same(expected):
    def check(found):
        np.testing.assert_array_equal(found, expected)

    return check


def nothing_trusted(found):
    assert not found[1].any()


def no_curvature(found):
    assert not found.trusted.any()
    assert not found.sum.any()


def unsure(found):
    """Raised, but nothing that shows where the contact is: undecided rather than certain."""
    raised = found.labels == DEFORMED
    assert not (found.labels == CONTACT).any()
    assert raised.any()
    assert (found.confidence[raised] < 0.7).mean() > 0.9


def correlated(seed=0):
    from scipy.ndimage import gaussian_filter

    white = np.random.default_rng(seed).standard_normal((H, W))
    return (gaussian_filter(white, 3.0) * 6 * np.sqrt(np.pi) * 1e-3).astype(np.float32)


EDGE = 20e-3 * np.sin(0.5)

CASES = {
    # deproject
    "deproject, empty image": (lambda: deproject(np.zeros((0, 0)), Intrinsics(1, 1, 0, 0, 0, 0))[0].shape, (0, 0, 3)),
    "deproject, all invalid": (lambda: deproject(0 * FLAT, LENS)[1].any(), False),
    "deproject, NaN and inf": (
        lambda: deproject(with_pixels(FLAT, {(0, 0): NAN, (0, 1): INF, (0, 2): -INF}), LENS)[1].sum(),
        H * W - 3,
    ),
    "deproject, float32 stays": (lambda: deproject(FLAT, LENS)[0].dtype.name, "float32"),
    "deproject, millimetres": (lambda: deproject(1e3 * FLAT, LENS), (InvalidInput, "median of 200 m is another unit")),
    "deproject, kilometres": (lambda: deproject(1e-3 * FLAT, LENS), (InvalidInput, "another unit")),
    "deproject, counts": (lambda: deproject(np.ones((H, W), np.uint16), LENS), (InvalidInput, "counts by their unit")),
    "deproject, other resolution": (
        lambda: deproject(FLAT[::2, ::2], LENS),
        (InvalidInput, "160 rows by 200 columns, the image is"),
    ),
    "deproject, saturated": (
        lambda: deproject(np.full((H, W), 65535 * 0.125e-3, dtype=np.float32), LENS)[1].all(),
        True,
    ),
    # mask and average
    "mask, no plane": (
        lambda: mask_membrane(dataclasses.replace(frame(FLAT), plane_distance=None), gauge=0.1, width=0.09, stretch=0),
        (InvalidInput, "plane_distance"),
    ),
    "mask, narrower than its margin": (
        lambda: mask_membrane(frame(FLAT), gauge=0.1, width=1e-3, stretch=0.0).raw.any(),
        False,
    ),
    "average, nothing": (lambda: average_frames([]), (InvalidInput, "at least one frame")),
    "average, all invalid": (lambda: average_frames([frame(0 * FLAT)] * 3).raw.any(), False),
    "average, two resolutions": (
        lambda: average_frames([frame(FLAT), frame(FLAT[::2])]),
        (InvalidInput, "unit or intrinsics"),
    ),
    "average, saturated counts": (
        lambda: average_frames([dataclasses.replace(frame(FLAT), raw=np.full((H, W), 65535, np.uint16))] * 2).raw.max(),
        65535,
    ),
    # segment
    "segment, empty image": (lambda: segment(np.zeros((0, 0, 3)), np.zeros((0, 0), bool)).shape, (0, 0)),
    "segment, all invalid": (lambda: labels(0 * FLAT), all_are(INVALID)),
    "segment, one valid pixel": (lambda: labels(one_pixel())[80, 100], UNDEFORMED),
    "segment, constant depth": (lambda: labels(FLAT), all_are(UNDEFORMED)),
    "segment, one row": (
        lambda: labels(with_pixels(0 * FLAT, {(80, u): 0.2 for u in range(W)}))[80],
        all_are(UNDEFORMED),
    ),
    "segment, half dropped out": (lambda: labels(half_gone()), covers((0.0, 0.0, EDGE), least=0.3)),
    "segment, saturated pixels": (
        lambda: labels(with_pixels(press(), {(80, 90): 65535 * 0.125e-3, (20, 30): 65535 * 0.125e-3})),
        covers((0.0, 0.0, EDGE)),
    ),
    "segment, NaN and inf": (
        lambda: labels(with_pixels(press(), {(80, 100): NAN, (79, 100): INF, (81, 100): -INF})),
        covers((0.0, 0.0, EDGE)),
    ),
    "segment, float64 as float32": (
        lambda: (labels(press().astype(np.float64)) == labels(press())).mean() > 0.999,
        True,
    ),
    "segment, two contacts": (
        lambda: labels(press(x0=-22e-3, radius=15e-3) + press(x0=22e-3, radius=15e-3, noise=0.0) - FLAT),
        covers((-22e-3, 0.0, 15e-3 * np.sin(0.5)), (22e-3, 0.0, 15e-3 * np.sin(0.5)), least=0.8),
    ),
    "segment, concave": (lambda: (labels(2 * FLAT - press()) == CONTACT).any(), False),
    "segment, cap cut by the frame's edge": (lambda: labels(press(x0=42e-3)), covers((42e-3, 0.0, EDGE), least=0.6)),
    "segment, contact at the clamp": (lambda: labels(press(y0=28e-3)), covers((0.0, 28e-3, EDGE), least=0.8)),
    "segment, correlated noise": (
        lambda: classify(*cloud(press(radius=15e-3, angle=0.25, noise=0.0) + correlated())),
        unsure,
    ),
    "segment, wrong shape": (lambda: segment(FLAT, FLAT > 0), (InvalidInput, r"\(h, w, 3\) floats")),
    "segment, mask of numbers": (
        lambda: segment(np.zeros((4, 4, 3)), np.ones((4, 4))),
        (InvalidInput, "bool mask"),
    ),
    "normals, all invalid": (lambda: estimate_normals(*cloud(0 * FLAT)), nothing_trusted),
    "curvatures, all invalid": (lambda: curvatures(*cloud(0 * FLAT)), no_curvature),
    # find_contact
    "contact, all invalid": (lambda: find_contact(frame(0 * FLAT)), (NoContact, "no pixel of the frame has depth")),
    "contact, one valid pixel": (lambda: find_contact(frame(one_pixel())), (NoContact, "no part of the membrane")),
    "contact, constant depth": (lambda: find_contact(frame(FLAT)), (NoContact, "no part of the membrane")),
    "contact, no plane": (
        lambda: find_contact(dataclasses.replace(frame(FLAT), plane_distance=None)),
        (InvalidInput, "plane_distance"),
    ),
    "contact, concave": (lambda: find_contact(frame(2 * FLAT - press())), (NoContact, "no part of the membrane")),
    "contact, half dropped out": (lambda: find_contact(frame(half_gone())).labels, covers((0.0, 0.0, EDGE), least=0.3)),
    # heights
    "height, all invalid": (lambda: height(0 * FLAT), (NoContact, "no pixel in contact has depth")),
    "height, no contact": (lambda: height(FLAT), (NoContact, "no pixel in contact has depth")),
    "height, half dropped out": (lambda: height(half_gone()), close_to(TOP, 0.1e-3)),
    "height, saturated pixels": (
        lambda: height(with_pixels(press(), {(80, 90): 65535 * 0.125e-3, (79, 99): 65535 * 0.125e-3})),
        close_to(TOP, 0.05e-3),
    ),
    "height, one point": (
        lambda: track_height(*cloud(one_pixel()), np.full((H, W), CONTACT, np.uint8)),
        (IllConditioned, "twelve"),
    ),
    "height, labels of another resolution": (
        lambda: track_height(*cloud(FLAT), np.zeros((H, W // 2), np.uint8)),
        (InvalidInput, "labels need the shape"),
    ),
    "tracker, all invalid": (
        lambda: followed(HeightTracker, FLAT, 0 * FLAT),
        (NoContact, "no pixel has depth in this frame"),
    ),
    "tracker, constant depth": (lambda: [e.value for e in followed(HeightTracker, FLAT, FLAT)], [0.0, 0.0]),
    "tracker, millimetres": (lambda: followed(HeightTracker, FLAT, 1e3 * FLAT), (InvalidInput, "another unit")),
    "tracker, other resolution": (
        lambda: followed(HeightTracker, FLAT, FLAT[::2]),
        (InvalidInput, "reference is of images"),
    ),
    # detection
    "detector, constant depth": (lambda: any(followed(ContactDetector, *[FLAT] * 20)), False),
    "detector, all invalid": (
        lambda: followed(ContactDetector, *[FLAT] * 12, 0 * FLAT),
        (NoContact, "no pixel has depth in this frame"),
    ),
    "detector, one valid pixel": (
        lambda: followed(ContactDetector, *[FLAT] * 12, one_pixel()),
        (NoContact, "too few neighbouring"),
    ),
    "detector, half dropped out": (
        lambda: followed(ContactDetector, *still(12), half_gone())[-1],
        True,
    ),
    "detector, concave": (lambda: followed(ContactDetector, *still(40), 2 * FLAT - press())[-1], False),
    # noise
    "noise, constant depth": (lambda: pixel_noise(FLAT).sd.max() < 1e-8, True),
    "noise, one valid pixel": (lambda: pixel_noise(one_pixel()), (IllConditioned, "valid throughout")),
    "noise, millimetres": (lambda: pixel_noise(1e3 * FLAT), (InvalidInput, "another unit")),
    "noise of frames, constant depth": (lambda: frame_noise([FLAT] * 8).correlation, same(np.zeros(5))),
}
