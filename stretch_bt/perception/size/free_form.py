"""A contact of any smooth outline: for contacts that are neither round nor rectangular, or to check that they are."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.size.around import COUNT, skirt_around, slope_sums
from stretch_bt.perception.size.box_prior import TARGETS, BoxPrior, shipped_box_prior
from stretch_bt.perception.size.exterior import ExteriorMap
from stretch_bt.perception.size.hypothesis import Context, FittedSizes
from stretch_bt.perception.size.start import Start

__all__ = ["FreeForm"]

Array = npt.NDArray[np.float64]
Complex = npt.NDArray[np.complex128]

HARMONICS = 4
OUTLINE = slice(2, 3 + 2 * HARMONICS)  # C, then real and imaginary parts of c_1 .. c_4
SHAPE = OUTLINE.stop
RATIO, HEIGHT, TILT_X, TILT_Y = SHAPE, SHAPE + 1, SHAPE + 2, SHAPE + 3
SKIRT = slice(SHAPE + 4, SHAPE + 4 + COUNT)
SIZE = SKIRT.stop
LOOSE = 3.0  # times the deviations of the prior for rectangles: other outlines have other skirts
LIKELY = 30.0  # squared deviations from the prior that all of it allows
TILT_SD = 0.02  # rad
SPREAD = np.array([0.3, 0.2, 0.08, 0.08, 0.08, 0.08, 0.04, 0.04])  # of ln(i / j), Im c_1 / C, then c_2 .. c_4 over C
INSIDE = 0.88  # |z| to which the map goes on inside the outline
NEAR = 1.5e-3  # m inside the rim beyond which the face is flat
SMALLEST = 1e-3  # m, C
POINTS = 128
FOLDED = 0.1  # share of the outline that may run backwards, as it does at tips that are sharper than it can be
FOLLOWED = np.array([0, 1, *range(2, SHAPE), RATIO, HEIGHT])  # parameters that the prior's means depend on
STEPS = np.where(FOLLOWED == RATIO, 1e-5, 1e-7)
ROUND = 0.05  # of the second moment along an axis: an outline whose moments differ by less is taken as along i
HANDICAP = 0.009  # of the depth: the skirts of simple shapes miss up to 0.006 without noise
RATIOS = (-0.5, 5.0)


class FreeForm:
    """Parameters q: x, y, C, c_1 .. c_4, ln ratio, height, two tilts, the skirt's coefficients; all but the ratio in m.

    The outline of the hinge is x + i y / k = C z + sum_n c_n z^-n on |z| = 1, so that no outline has a corner; the error of a
    rectangle's is part of the stated standard deviation.
    """

    name = "free_form"
    ratio = RATIO
    handicap = HANDICAP

    def __init__(self, context: Context, prior: BoxPrior | None = None) -> None:
        self.context = context
        self.skirt_prior = prior or shipped_box_prior()
        covariance = LOOSE**2 * self.skirt_prior.covariance(context.stretch)
        self._whitener = np.linalg.inv(np.linalg.cholesky(covariance))

    def starts(self, start: Start) -> list[Array]:
        """Return an ellipse of the raised part's smaller width, with the prior's skirt."""
        radius = 1.6 * min(start.across, start.along)
        q = np.zeros(SIZE)
        q[:2], q[RATIO], q[HEIGHT] = (start.x, start.y), 2.0, start.top
        q[RATIO] = self._mean(_ellipse(q, radius)[None])[0, 0]
        q = _ellipse(q, radius)
        q[SKIRT] = self._mean(q[None])[0, 1:] * start.top
        return [q]

    def scales(self, q: Array) -> Array:
        """Return the largest step that is allowed at once: 2 mm in the plane, a twentieth of the size in the shape."""
        size = np.full(SIZE, 2e-3)
        size[3:SHAPE] = 0.05 * abs(q[2]) + 1e-4
        size[RATIO] = 0.5
        size[HEIGHT] = 0.3 * abs(q[HEIGHT]) + 1e-3
        size[[TILT_X, TILT_Y]] = 0.2
        size[SKIRT] = 0.5 * abs(q[HEIGHT]) + 1e-3
        return size

    def model(self, q: Array, x: Array, y: Array) -> tuple[Array, Array]:
        """Return heights (n,), m, and their Jacobian."""
        k, dx, dy = _k(q), x - q[0], y - q[1]
        sign = np.where(self.outside(q, x, y) > -NEAR, 1.0, 0.0)
        fall, by, basis = skirt_around(_outline(q), _by_outline(), k, q[SKIRT], dx, dy, sign, INSIDE)
        jacobian = np.empty((SIZE, x.size))
        jacobian[:2] = -by[:2] - q[[TILT_X, TILT_Y], None]
        jacobian[OUTLINE] = -by[3:]
        jacobian[RATIO] = -0.5 * k * by[2]
        jacobian[HEIGHT], jacobian[TILT_X], jacobian[TILT_Y] = 1.0, dx, dy
        jacobian[SKIRT] = -basis
        return q[HEIGHT] + q[TILT_X] * dx + q[TILT_Y] * dy - fall, jacobian

    def prior(self, q: Array) -> tuple[Array, Array]:
        """Return the residuals of q to the prior of skirt, tilts and outline, and their Jacobian."""
        depth = max(float(q[HEIGHT]), 1e-4)
        rows = np.tile(q, (1 + len(FOLLOWED), 1))
        rows[np.arange(1, len(rows)), FOLLOWED] += STEPS
        mean, shape = self._mean(rows), _shape(rows)
        slopes = np.zeros((SIZE, TARGETS))
        slopes[FOLLOWED] = -(mean[1:] - mean[0]) / STEPS[:, None]
        slopes[HEIGHT, 1:] -= q[SKIRT] / depth**2
        slopes[RATIO, 0] += 1.0
        slopes[SKIRT, 1:] = np.eye(COUNT) / depth
        jacobian = np.zeros((SIZE, TARGETS + 2 + len(SPREAD)))
        jacobian[:, :TARGETS] = slopes @ self._whitener.T
        jacobian[TILT_X, TARGETS] = jacobian[TILT_Y, TARGETS + 1] = 1.0 / TILT_SD
        jacobian[FOLLOWED, TARGETS + 2 :] = (shape[1:] - shape[0]) / STEPS[:, None]
        skirt = self._whitener @ (np.append(q[RATIO], q[SKIRT] / depth) - mean[0])
        return np.concatenate([skirt, q[[TILT_X, TILT_Y]] / TILT_SD, shape[0]]), jacobian

    def _mean(self, rows: Array) -> Array:
        """Return the prior's means (n, TARGETS) for the rectangles of the outlines' second moments."""
        w = rows[:, OUTLINE] @ _powers().T
        x, y = w.real, np.exp(0.5 * np.clip(rows[:, RATIO], *RATIOS))[:, None] * w.imag
        xx, yy, xy = (x * x).mean(axis=1), (y * y).mean(axis=1), (x * y).mean(axis=1)
        half, skew = 0.5 * (xx + yy), 0.5 * (xx - yy)
        # a round outline lies along no axis: rounding would turn it, and its slopes
        twice = np.arctan2(xy, skew + ROUND * half)
        apart = skew * np.cos(twice) + xy * np.sin(twice)
        # around a square of side a the line has a second moment a^2 / 6 along each axis, around a circle a^2 / 8
        long, short = (np.sqrt(7.0 * np.maximum(half + sign * apart, 1e-8)) for sign in (1.0, -1.0))
        sizes = np.column_stack([rows[:, 0], rows[:, 1], long, short, 0.5 * twice, np.maximum(rows[:, HEIGHT], 1e-4)])
        return self.skirt_prior.mean(sizes, self.context.stretch)

    def log_prior(self, q: Array) -> float:
        """Return the logarithm of the prior density but for x, y, height and C."""
        against, _ = self.prior(q)
        depth, size = max(float(q[HEIGHT]), 1e-4), max(float(q[2]), SMALLEST)
        density = float(np.log(np.diag(self._whitener)).sum()) - 2.0 * math.log(TILT_SD) - COUNT * math.log(depth)
        # d ln(i / j) / d Re c_1 = 2 C / (C^2 - c_1^2)
        by_first = math.log(2.0 * size / max(size**2 - float(q[3]) ** 2, 1e-3 * size**2))
        shape = by_first - float(np.log(SPREAD).sum()) - (2 * HARMONICS - 1) * math.log(size)
        return density + shape - 0.5 * float(against @ against) - 0.5 * against.size * math.log(2.0 * math.pi)

    def satisfied(self, q: Array) -> bool:
        """Return whether the prior has little against the skirt and the tilts."""
        against, _ = self.prior(q)
        return bool(against @ against < LIKELY)

    def outside(self, q: Array, x: Array, y: Array) -> Array:
        """Return how far places lie outside the rim along the line from the centre, m."""
        outline_x, outline_y = _places(q)
        angle = np.arctan2(outline_y, outline_x)
        order = np.argsort(angle)
        radius = np.interp(
            np.arctan2(y - q[1], x - q[0]), angle[order], np.hypot(outline_x, outline_y)[order], period=2.0 * math.pi
        )
        return np.asarray(np.hypot(x - q[0], y - q[1]) - radius)

    def measure(self, q: Array, covariance: Array) -> FittedSizes:
        """Return the sizes; raises IllConditioned where the outline is folded, or none."""
        angle = np.unwrap(np.arctan2(*_places(q)[::-1]))
        if q[HEIGHT] <= 0.0 or q[2] <= 2.0 * SMALLEST or (np.diff(angle) <= 0.0).mean() > FOLDED:
            raise IllConditioned(
                "no single outline fits the contact: it is too shallow or too small for the noise; press deeper, or average more frames"
            )
        chosen = [*range(2, SHAPE), RATIO]
        inner = covariance[np.ix_(chosen, chosen)]
        sizes = []
        for axis in (0, 1):
            by = np.array([(_width(_moved(q, n), axis) - _width(q, axis)) / 1e-7 for n in chosen])
            inset = self._inset(q, axis)
            systematic = self.skirt_prior.free_form[axis]
            variance = float(by @ inner @ by) + (2.0 * inset * self.context.fillet_sd) ** 2 + systematic**2
            sizes.append((_width(q, axis) + 2.0 * inset * self.context.fillet, math.sqrt(variance)))
        sd = np.sqrt(np.diag(covariance))
        return FittedSizes(
            center=((float(q[0]), float(sd[0])), (float(q[1]), float(sd[1]))),
            diameter_i=sizes[0],
            diameter_j=sizes[1],
            depth=(float(q[HEIGHT]), float(sd[HEIGHT])),
        )

    def _inset(self, q: Array, axis: int) -> float:
        """Return how far the hinge lies inside the object's edge, over the fillet, at the ends along an axis."""
        z = _circle()
        x, y = _places(q)
        away = np.abs(np.arctan2(np.abs((y, x)[axis]), np.abs((x, y)[axis])))
        steep = q[SKIRT] @ slope_sums(_outline(q), _k(q), z)
        slope = float(np.abs(steep[away < 0.35]).mean()) if (away < 0.35).any() else 0.0
        return 1.0 - math.tan(0.5 * math.atan(slope))


def _shape(rows: Array) -> Array:
    """Return how far the outlines (n, q) deviate from a circle, (n, 2 HARMONICS), in standard deviations of the prior."""
    size = np.maximum(rows[:, 2], SMALLEST)
    half_i, half_j = (np.maximum(size + sign * rows[:, 3], 0.02 * size) for sign in (1.0, -1.0))
    ratio = np.log(half_i / half_j) - 0.5 * np.clip(rows[:, RATIO], *RATIOS)
    return np.asarray(np.column_stack([ratio, rows[:, 4:SHAPE] / size[:, None]]) / SPREAD)


def _k(q: Array) -> float:
    return math.exp(0.5 * float(np.clip(q[RATIO], *RATIOS)))


def _ellipse(q: Array, radius: float) -> Array:
    """Return q with the outline of a circle."""
    found, low = q.copy(), radius / _k(q)
    found[OUTLINE] = 0.0
    found[2], found[3] = 0.5 * (radius + low), 0.5 * (radius - low)
    return found


def _moved(q: Array, n: int) -> Array:
    found = q.copy()
    found[n] += 1e-7
    return found


@lru_cache(maxsize=1)
def _circle() -> Complex:
    return np.asarray(np.exp(2j * np.pi * (np.arange(POINTS) + 0.31) / POINTS))


@lru_cache(maxsize=1)
def _powers() -> Complex:
    """Return the derivatives of the places of the outline (POINTS,) by each of its parameters."""
    z = _circle()
    terms = [z] + [part * z**-n for n in range(1, HARMONICS + 1) for part in (1.0, 1j)]
    return np.column_stack(terms)


@lru_cache(maxsize=1)
def _by_outline() -> Complex:
    """Return the derivatives of C and the series by k (0) and by the outline's parameters."""
    by = np.zeros((2 + 2 * HARMONICS, 1 + HARMONICS), dtype=np.complex128)
    by[1, 0] = 1.0
    for n in range(HARMONICS):
        by[2 + 2 * n, 1 + n], by[3 + 2 * n, 1 + n] = 1.0, 1j
    return by


def _outline(q: Array) -> ExteriorMap:
    parts = q[3:SHAPE].reshape(-1, 2)
    return ExteriorMap(max(float(q[2]), SMALLEST), np.ascontiguousarray(parts[:, 0] + 1j * parts[:, 1]), 1)


def _places(q: Array) -> tuple[Array, Array]:
    """Return places (POINTS,) on the outline about its centre, m."""
    w = _powers() @ q[OUTLINE]
    return w.real, _k(q) * w.imag


def _width(q: Array, axis: int) -> float:
    """Return the width of the outline through its centre along an axis, m."""
    x, y = _places(q)
    along, aside = (x, y) if axis == 0 else (y, x)
    after, beyond = np.roll(aside, -1), np.roll(along, -1)
    crossing = (aside < 0.0) != (after < 0.0)
    share = aside[crossing] / (aside[crossing] - after[crossing])
    ends = along[crossing] + share * (beyond[crossing] - along[crossing])
    return float(np.ptp(ends)) if ends.size else 0.0
