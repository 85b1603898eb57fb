"""A rectangular contact at any angle."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.size.around import COUNT
from stretch_bt.perception.size.box_prior import TARGETS, BoxPrior, shipped_box_prior
from stretch_bt.perception.size.box_rim import BoxRim
from stretch_bt.perception.size.hypothesis import Context, FittedSizes
from stretch_bt.perception.size.start import Start

__all__ = ["Rectangle"]

Array = npt.NDArray[np.float64]

LIKELY = 30.0  # squared deviations from the prior that all of it allows
TILT_SD = 0.02  # rad: an object's face lies about parallel to the membrane
ASPECT_SD = 0.5  # of ln(first / second), over the objects there are
SMALLEST, LARGEST = 3e-3, 60e-3  # m, sides
RATIOS = (-0.5, 5.0)  # of ln(T_j / T_i)
RATIO, HEIGHT, TILT_X, TILT_Y = 5, 6, 7, 8
SKIRT = slice(9, 9 + COUNT)
GEOMETRY = [0, 1, 2, 3, 4, HEIGHT]  # parameters that the prior's mean depends on
STEPS = np.array([1e-6, 1e-6, 1e-6, 1e-6, 1e-5, 1e-6])


class Rectangle:
    """Parameters q: x, y, two sides, rotation of the first from i, ln ratio, height, two tilts, the skirt's coefficients.

    Sides are the object's, to the ends of its fillet; the coefficients are in m.
    """

    name = "rectangle"
    ratio = RATIO
    handicap = 0.0

    def __init__(self, context: Context, prior: BoxPrior | None = None) -> None:
        self.context = context
        self.skirt_prior = prior or shipped_box_prior()
        self._whitener = np.linalg.inv(np.linalg.cholesky(self.skirt_prior.covariance(context.stretch)))

    def starts(self, start: Start) -> list[Array]:
        """Return squares along i and j and turned from them, and along the axes of the raised part, with the prior's skirt."""
        square = 2.6 * min(start.across, start.along)
        boxes = [
            (square, square, 0.0),
            (square, square, math.pi / 4),
            (2.2 * start.major, 2.2 * start.minor, start.angle),
        ]
        return [self._start(start, *box) for box in boxes]

    def _start(self, start: Start, first: float, second: float, rotation: float) -> Array:
        q = np.zeros(9 + COUNT)
        q[:5] = start.x, start.y, max(first, 1.5 * SMALLEST), max(second, 1.5 * SMALLEST), rotation
        q[HEIGHT] = start.top
        mean = self.skirt_prior.mean(q[GEOMETRY][None], self.context.stretch)[0]
        q[RATIO], q[SKIRT] = mean[0], mean[1:] * start.top
        return q

    def scales(self, q: Array) -> Array:
        """Return the largest step that is allowed at once: 2 mm in the plane."""
        size = np.full(q.size, 2e-3)
        size[4], size[RATIO] = 0.25, 0.5
        size[HEIGHT] = 0.3 * abs(q[HEIGHT]) + 1e-3
        size[[TILT_X, TILT_Y]] = 0.2
        size[SKIRT] = 0.5 * abs(q[HEIGHT]) + 1e-3
        return size

    def rim(self, q: Array) -> BoxRim:
        """Return the hinge of the skirt: inside the object's edge by f - f tan(theta / 2) where it leaves at theta."""
        first, second = np.clip(q[2:4], SMALLEST, LARGEST)
        rim = BoxRim(q[0], q[1], float(first), float(second), q[4], float(np.clip(q[RATIO], *RATIOS)))
        inset = [2.0 * self.context.fillet * part for part in _inset(rim.slopes(q[SKIRT]))]
        sides = [max(float(side) - gone, 0.5 * SMALLEST) for side, gone in zip((first, second), inset, strict=True)]
        return BoxRim(rim.x, rim.y, sides[0], sides[1], rim.rotation, rim.log_ratio)

    def model(self, q: Array, x: Array, y: Array) -> tuple[Array, Array]:
        """Return heights (n,), m, and their Jacobian; the inset of the rim is taken as fixed in it."""
        fall, by_rim, basis = self.rim(q).skirt(q[SKIRT], x, y)
        dx, dy = x - q[0], y - q[1]
        jacobian = np.empty((q.size, x.size))
        jacobian[:6] = -by_rim
        jacobian[0] -= q[TILT_X]
        jacobian[1] -= q[TILT_Y]
        jacobian[HEIGHT], jacobian[TILT_X], jacobian[TILT_Y] = 1.0, dx, dy
        jacobian[SKIRT] = -basis
        return q[HEIGHT] + q[TILT_X] * dx + q[TILT_Y] * dy - fall, jacobian

    def prior(self, q: Array) -> tuple[Array, Array]:
        """Return the residuals of q to the prior of the skirt and of the tilts, and their Jacobian."""
        depth = max(float(q[HEIGHT]), 1e-4)
        rows = np.tile(q[GEOMETRY], (7, 1))
        rows[np.arange(1, 7), np.arange(6)] += STEPS
        mean = self.skirt_prior.mean(rows, self.context.stretch)
        slopes = np.zeros((q.size, TARGETS))
        slopes[GEOMETRY] = -(mean[1:] - mean[0]) / STEPS[:, None]
        slopes[HEIGHT, 1:] -= q[SKIRT] / depth**2
        slopes[RATIO, 0] = 1.0
        slopes[SKIRT, 1:] = np.eye(COUNT) / depth
        against = np.append(q[RATIO], q[SKIRT] / depth) - mean[0]
        jacobian = np.zeros((q.size, TARGETS + 2))
        jacobian[:, :TARGETS] = slopes @ self._whitener.T
        jacobian[TILT_X, TARGETS] = jacobian[TILT_Y, TARGETS + 1] = 1.0 / TILT_SD
        return np.concatenate([self._whitener @ against, q[[TILT_X, TILT_Y]] / TILT_SD]), jacobian

    def log_prior(self, q: Array) -> float:
        """Return the logarithm of the prior density, with the priors of the sides' ratio and of the rotation, even over a quarter turn."""
        against, _ = self.prior(q)
        depth, second = max(float(q[HEIGHT]), 1e-4), max(abs(float(q[3])), SMALLEST)
        scale = float(np.log(np.diag(self._whitener)).sum()) - 2.0 * math.log(TILT_SD) - COUNT * math.log(depth)
        skirt = scale - 0.5 * float(against @ against) - 0.5 * against.size * math.log(2.0 * math.pi)
        ratio = math.log(q[2] / q[3]) / ASPECT_SD if min(q[2], q[3]) > 0.0 else math.inf
        aspect = -0.5 * ratio**2 - math.log(ASPECT_SD * math.sqrt(2.0 * math.pi) * second)
        return skirt + aspect - math.log(math.pi / 2.0)

    def satisfied(self, q: Array) -> bool:
        """Return whether the prior has little against the skirt and the tilts."""
        against, _ = self.prior(q)
        return bool(against @ against < LIKELY)

    def outside(self, q: Array, x: Array, y: Array) -> Array:
        """Return how far places lie outside the rim, m."""
        return self.rim(q).outside(x, y)

    def measure(self, q: Array, covariance: Array) -> FittedSizes:
        """Return the sizes; raises IllConditioned where the fit shrank to a line or turned into a hollow."""
        if q[HEIGHT] <= 0.0 or not SMALLEST < min(q[2:4]) <= max(q[2:4]) < LARGEST:
            raise IllConditioned(
                "no rectangle fits the contact: it is too shallow or too small for the noise; press deeper, or average more frames"
            )
        shape = covariance[:5, :5] + self._beyond_noise(q)
        q = self._corrected(q)
        sd = np.sqrt(np.diag(shape))
        short = 2 if q[2] <= q[3] else 3
        sides = [(float(q[n]), float(sd[n])) for n in (short, 5 - short)]
        turned = float(q[4]) + (0.0 if short == 2 else 0.5 * math.pi)
        return FittedSizes(
            center=((float(q[0]), float(sd[0])), (float(q[1]), float(sd[1]))),
            diameter_i=_width(q, shape, 0.0),
            diameter_j=_width(q, shape, 0.5 * math.pi),
            depth=(float(q[HEIGHT]), math.sqrt(covariance[HEIGHT, HEIGHT])),
            sides=(sides[0], sides[1]),
            rotation=((turned + 0.5 * math.pi) % math.pi - 0.5 * math.pi, float(sd[4])),
        )

    def _corrected(self, q: Array) -> Array:
        """Return q with the correction of the steady error of fits without noise added to its sides."""
        along_i, along_j = self.skirt_prior.steady(float(q[HEIGHT]), self.context.stretch)
        c, s = math.cos(q[4]) ** 2, math.sin(q[4]) ** 2
        found = q.copy()
        found[2:4] += c * along_i + s * along_j, s * along_i + c * along_j
        return found

    def _beyond_noise(self, q: Array) -> Array:
        """Return the covariance (5, 5) from the model's error without noise and from the fillet."""
        x, y, along_i, along_j, rotation = self.skirt_prior.systematic**2
        c, s = math.cos(q[4]) ** 2, math.sin(q[4]) ** 2
        missed = np.diag([x, y, c * along_i + s * along_j, s * along_i + c * along_j, rotation])
        by_fillet = np.array([0.0, 0.0, *(2.0 * part for part in _inset(self.rim(q).slopes(q[SKIRT]))), 0.0])
        return missed + np.outer(by_fillet, by_fillet) * self.context.fillet_sd**2


def _inset(slopes: tuple[float, float]) -> list[float]:
    """Return how far the hinge lies inside the object's edge, over the fillet, for both sides."""
    return [1.0 - math.tan(0.5 * math.atan(abs(slope))) for slope in slopes]


def _width(q: Array, covariance: Array, direction: float) -> tuple[float, float]:
    """Return the width through the centre in a direction and its standard deviation, m."""
    c, s = abs(math.cos(direction - q[4])), abs(math.sin(direction - q[4]))
    by = np.zeros(5)
    if q[2] * s < q[3] * c:
        width, by[2] = q[2] / c, 1.0 / c
        by[4] = width * math.tan(direction - q[4])
    else:
        width, by[3] = q[3] / s, 1.0 / s
        by[4] = -width / math.tan(direction - q[4])
    by[4] *= -1.0
    return float(width), math.sqrt(float(by @ covariance @ by))
