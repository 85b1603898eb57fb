"""The three classes of the membrane: undeformed, deformed, in contact."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput
from stretch_bt.perception.curvature import Curvatures, surface_curvatures
from stretch_bt.perception.smooth import derivative, gain
from stretch_bt.perception.surface import Surface, surface_of
from stretch_bt.perception.types import CONTACT, DEFORMED, INVALID, UNDEFORMED, FloatArray, LabelArray, MaskArray

__all__ = ["Rule", "Segmentation", "classify", "segment"]

Rule = Literal["mean", "either"]
Image = npt.NDArray[np.float32]

KERNELS = (1.9e-3, 2.7e-3, 3.8e-3)  # m; the first one in which the contact stands out is used
CLEAR = 9.0  # standard deviations at which a kernel is wide enough
SEED = 6.0  # standard deviations that a contact must show somewhere
GROW = 3.0  # and everywhere


@dataclass(frozen=True, slots=True)
class Segmentation:
    """Labels (h, w) uint8, the depth noise of one pixel, m, and the height of the undeformed membrane, m."""

    labels: LabelArray
    noise: float
    plane: float


def segment(points: FloatArray, valid: MaskArray, *, rule: Rule = "mean") -> LabelArray:
    """Sort the pixels of one frame into three classes.

    Parameters
    ----------
    points : (h, w, 3) float, m
        In the camera frame (z forward) or the membrane frame (z towards the camera, undeformed membrane at 0). Where
        the median z exceeds 0.4 of the width seen, they are taken to be in the camera frame.
    valid : (h, w) bool
    rule : "mean" or "either"
        "mean": the mean curvature is high, which it is not on a tense skirt however steep, because the tensions along
        the two axes balance there. "either": the paper's rule, the curvature along i or along j is high, which takes in
        part of the skirt. With both, points above the plane of the contact belong to it: that finds flat faces.

    Returns
    -------
    labels : (h, w) uint8
        0 undeformed, 1 deformed but not in contact, 2 in contact, 255 invalid. All thresholds come from the noise that
        the frame itself shows.
    """
    return classify(points, valid, rule=rule).labels


def classify(points: FloatArray, valid: MaskArray, *, rule: Rule = "mean") -> Segmentation:
    """Do as `segment`, and return the noise and the plane with the labels."""
    if rule not in ("mean", "either"):
        raise InvalidInput(f"rule is 'mean' or 'either', got {rule!r}")
    best: tuple[Surface, Curvatures] | None = None
    for kernel in KERNELS:
        surface = surface_of(points, valid, kernel)
        if surface is None:
            return Segmentation(np.where(valid, UNDEFORMED, INVALID).astype(np.uint8), 0.0, 0.0)
        found = surface_curvatures(surface)
        best = best or (surface, found)
        if float(found.sum.max()) > CLEAR * found.sum_sd:
            best = (surface, found)
            break
    assert best is not None
    surface, found = best
    plane = _plane(surface)
    raised = surface.smooth - np.float32(plane) > _least_rise(surface)
    contact = _mean_rule(surface, found, raised) if rule == "mean" else _either_rule(surface, found, raised)
    return Segmentation(_labels(surface, valid, raised, contact), surface.noise, plane + surface.level)


def _plane(surface: Surface) -> float:
    """Return the height of the undeformed membrane above the surface's level, m."""
    if surface.towards > 0:
        return -surface.level
    seen = surface.smooth[surface.trusted & surface.valid]
    # In the camera frame the membrane's distance is unknown; its lowest part is taken to be undeformed.
    return float(np.quantile(seen, 0.05)) + 1.645 * surface.smooth_sd if seen.size else 0.0


def _least_rise(surface: Surface) -> float:
    """Return the rise, m, from which a pixel counts as deformed; half a pixel's noise covers what is not white."""
    return max(3.0 * surface.smooth_sd, 0.5 * surface.noise, 0.01 * surface.sigma * surface.pitch)


def _labels(surface: Surface, valid: MaskArray, raised: MaskArray, contact: MaskArray) -> LabelArray:
    labels = np.where(raised, DEFORMED, UNDEFORMED).astype(np.uint8)
    labels[contact] = CONTACT
    labels[~(valid & surface.valid)] = INVALID
    return labels


def _mean_rule(surface: Surface, found: Curvatures, raised: MaskArray) -> MaskArray:
    contact = np.zeros(raised.shape, dtype=bool)
    for part, level in _convex(found.sum, found.sum_sd, raised, 2.0 / _width(surface)):
        whole = _with_above_plane(surface, part)
        inside = _inner_half(whole)
        flat = _curvature_of(surface, inside) < 0.5 * level
        contact |= _flat_face(surface, whole, inside, raised) if flat else whole
    return contact


def _either_rule(surface: Surface, found: Curvatures, raised: MaskArray) -> MaskArray:
    either = np.zeros(raised.shape, dtype=bool)
    for signal, sd in ((found.i, found.i_sd), (found.j, found.j_sd)):
        for part, _ in _convex(signal, sd, raised, 1.0 / _width(surface)):
            either |= part
    contact = np.zeros(raised.shape, dtype=bool)
    for part in _components(either):
        contact |= _with_above_plane(surface, part)
    return contact


def _width(surface: Surface) -> float:
    """Return the width of the view, m: a radius beyond it is a plane that is not quite flat."""
    return float(max(surface.height.shape) * surface.pitch)


def _convex(signal: Image, sd: float, raised: MaskArray, least: float) -> list[tuple[MaskArray, float]]:
    """Return each connected part with more than half its own typical curvature, and that curvature, 1/m."""
    found = []
    least = max(least, GROW * sd)
    for blob in _components(raised & (signal > least)):
        values = signal[blob]
        if float(values.max()) < SEED * sd:
            continue
        level = float(np.quantile(values, 0.9))
        for _ in range(4):
            level = float(np.median(values[values > 0.5 * level]))
        found.append((blob & (signal > max(least, 0.5 * level)), level))
    return found


def _components(mask: MaskArray) -> list[MaskArray]:
    """Return the 8-connected parts of a mask."""
    import cv2

    count, labels = cv2.connectedComponents(mask.astype(np.uint8))
    return [np.asarray(labels == k) for k in range(1, count)]


def _touching(mask: MaskArray, part: MaskArray) -> MaskArray:
    """Return the connected parts of a mask that share a pixel with `part`, their holes filled."""
    import cv2

    _, labels = cv2.connectedComponents(mask.astype(np.uint8))
    hit = np.unique(labels[part & mask])
    joined = np.isin(labels, hit[hit > 0])
    outline, _ = cv2.findContours(joined.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    filled = cv2.drawContours(np.zeros(mask.shape, dtype=np.uint8), outline, -1, 1, cv2.FILLED)
    return np.asarray(filled > 0)


def _distance(mask: MaskArray) -> Image:
    """Return how far each pixel of a mask is from its outside, pixels."""
    import cv2

    padded = np.pad(mask, 1).astype(np.uint8)
    return np.asarray(cv2.distanceTransform(padded, cv2.DIST_L2, 3)[1:-1, 1:-1], dtype=np.float32)


def _inner_half(mask: MaskArray) -> MaskArray:
    """Return the inner part of a mask, half as wide as the mask."""
    distance = _distance(mask)
    return np.asarray(distance > 0.5 * distance.max())


def _curvature_of(surface: Surface, part: MaskArray) -> float:
    """Return twice the mean curvature, 1/m, of a quadratic through the unsmoothed heights of a part.

    Smoothing would carry the bend at a rim into a face that is flat. Infinite where the part is too small to tell.
    """
    v, u = np.nonzero(part & surface.valid)
    if len(u) < 20:
        return np.inf
    x, y = (u - u.mean()) * surface.pitch, (v - v.mean()) * surface.pitch
    size = float(np.sqrt((x * x + y * y).mean()))
    x, y = x / size, y / size
    design = np.column_stack([np.ones(len(u)), x, y, x * x, x * y, y * y])
    solution = np.linalg.lstsq(design, surface.height[v, u].astype(np.float64), rcond=None)[0]
    return -2.0 * float(solution[3] + solution[5]) / size**2


def _above(surface: Surface, part: MaskArray) -> Image:
    """Return the height, m, of every pixel above the plane through the pixels of `part`."""
    v, u = np.nonzero(part)
    design = np.column_stack([np.ones(len(u)), u, v])
    solution = np.linalg.lstsq(design, surface.smooth[part].astype(np.float64), rcond=None)[0].astype(np.float32)
    rows, columns = (np.arange(n, dtype=np.float32) for n in part.shape)
    plane = solution[0] + solution[1] * columns[None, :] + solution[2] * rows[:, None]
    return np.asarray(surface.smooth - plane, dtype=np.float32)


def _with_above_plane(surface: Surface, part: MaskArray) -> MaskArray:
    """Add what lies above the plane of the part and touches it, and fill holes."""
    return _touching(part | (_above(surface, part) > 0.0), part)


def _flat_face(surface: Surface, whole: MaskArray, inside: MaskArray, raised: MaskArray) -> MaskArray:
    """Return the flat face that `inside` is part of, up to its rim.

    At a kink the smoothed height has dropped by just sigma^2 times its Laplacian, for any change of slope and any
    sigma, so that the height sharpened by this term crosses the plane of the face at the rim itself.
    """
    s = surface.sigma
    laplacian = derivative(surface.height, s, 2, 0) + derivative(surface.height, s, 0, 2)
    sharp_sd = surface.noise * gain(s, (0, 0, 1.0), (2, 0, -s * s), (0, 2, -s * s))
    sharp: Any = _above(surface, inside) - np.float32(s * s) * laplacian
    near = _distance(~whole) <= 2.0 * s
    return _touching(near & raised & (sharp > -1.5 * sharp_sd), inside)
