"""What the circle and the ellipse share: a flat, slightly tilted face, a rounded rim and the harmonic skirt around it."""

from __future__ import annotations

import math
from abc import abstractmethod

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.size.conformal import COUNT, Rim, skirt
from stretch_bt.perception.size.hypothesis import Context, FittedSizes
from stretch_bt.perception.size.start import Start

__all__ = ["RoundShape"]

Array = npt.NDArray[np.float64]

TILT_SD = 0.02  # rad: an object's face lies about parallel to the membrane
STARTS = np.geomspace(4e-3, 18e-3, 8)  # m, radius
LIKELY = 30.0  # sum of squares of eleven residuals of the prior: exceeded in 2 of 1000
SMALLEST = 1.5e-3  # m, radius


class RoundShape:
    """Parameters q: x, y, the radii, then ln ratio, height, two tilts, seven coefficients of the skirt, a correction.

    Radii are the object's, to the end of its fillet. Heights, coefficients and the correction are in m. The
    correction is the error of the radius in noise-free presses; only the prior knows it, and its correlation with the rest.
    """

    name = "round"
    handicap = 0.0
    radii = 1

    def __init__(self, context: Context) -> None:
        self.context = context
        self.ratio = 2 + self.radii
        self.height = self.ratio + 1
        self.skirt = slice(self.height + 3, self.height + 3 + COUNT)
        self.correction = self.skirt.stop
        self.count = self.correction + 1
        self._whitener = np.linalg.inv(np.linalg.cholesky(self.context.prior.covariance(context.stretch)))

    @abstractmethod
    def radii_of(self, q: Array) -> tuple[float, float]:
        """Return the object's half axes along i and j, m."""

    def starts(self, start: Start) -> list[Array]:
        """Return parameters with the prior's skirt for several radii."""
        return [self._start(start, radius) for radius in STARTS]

    def _start(self, start: Start, radius: float) -> Array:
        mean, _ = self.context.prior.mean(self.context.stretch, start.top, radius)
        q = np.zeros(self.count)
        q[:2] = start.x, start.y
        q[2 : self.ratio] = radius
        q[self.ratio] = mean[0]
        q[self.height] = start.top
        q[self.skirt] = mean[1 : 1 + COUNT] * start.top
        q[self.correction] = mean[1 + COUNT]
        return q

    def scales(self, q: Array) -> Array:
        """Return the largest step that is allowed at once: 2 mm in the plane."""
        size = np.full(self.count, 2e-3)
        size[self.ratio] = 0.5
        size[self.height] = 0.3 * abs(q[self.height]) + 1e-3
        size[self.height + 1 : self.height + 3] = 0.2
        size[self.skirt] = 0.5 * abs(q[self.height]) + 1e-3
        return size

    def rim(self, q: Array) -> Rim:
        """Return the hinge of the skirt: inside the object's edge by f - f tan(theta / 2) where it leaves at theta."""
        half = np.maximum(self.radii_of(q), SMALLEST)
        slopes = Rim(q[0], q[1], half[0], half[1], q[self.ratio]).slopes(q[self.skirt])
        inset = [self.context.fillet * (1.0 - math.tan(0.5 * math.atan(abs(s)))) for s in slopes]
        return Rim(q[0], q[1], float(half[0]) - inset[0], float(half[1]) - inset[1], q[self.ratio])

    def model(self, q: Array, x: Array, y: Array) -> tuple[Array, Array]:
        """Return heights (n,), m, and their Jacobian; the inset of the rim is taken as fixed in it."""
        fall, by_rim, basis, _ = skirt(self.rim(q), q[self.skirt], x, y)
        dx, dy = x - q[0], y - q[1]
        tilt = q[self.height + 1 : self.height + 3]
        jacobian = np.empty((self.count, x.size))
        jacobian[0] = -by_rim[0] - tilt[0]
        jacobian[1] = -by_rim[1] - tilt[1]
        jacobian[2 : self.ratio] = -by_rim[2:4] if self.radii == 2 else -by_rim[2] - by_rim[3]
        jacobian[self.ratio] = -by_rim[4]
        jacobian[self.height] = 1.0
        jacobian[self.height + 1] = dx
        jacobian[self.height + 2] = dy
        jacobian[self.skirt] = -basis
        jacobian[self.correction] = 0.0
        return q[self.height] + tilt[0] * dx + tilt[1] * dy - fall, jacobian

    def prior(self, q: Array) -> tuple[Array, Array]:
        """Return the residuals (11,) of q to the prior of the skirt and of the tilts, and their Jacobian."""
        depth, radii = max(q[self.height], 1e-4), np.maximum(self.radii_of(q), SMALLEST)
        radius = math.sqrt(radii[0] * radii[1])
        mean, by = self.context.prior.mean(self.context.stretch, depth, radius)
        scaled = np.concatenate([[q[self.ratio]], q[self.skirt] / depth, [q[self.correction]]])
        slopes = np.zeros((self.count, COUNT + 2))
        slopes[self.ratio, 0] = 1.0
        slopes[self.skirt, 1 : 1 + COUNT] = np.eye(COUNT) / depth
        slopes[self.correction, 1 + COUNT] = 1.0
        slopes[self.height] = -by[:, 0]
        slopes[self.height, 1 : 1 + COUNT] -= q[self.skirt] / depth**2
        slopes[2 : self.ratio] = -by[:, 1] * (radius / (self.radii * radii[: self.radii]))[:, None]
        residuals = np.concatenate([self._whitener @ (scaled - mean), q[self.height + 1 : self.height + 3] / TILT_SD])
        jacobian = np.zeros((self.count, residuals.size))
        jacobian[:, : COUNT + 2] = slopes @ self._whitener.T
        jacobian[self.height + 1, COUNT + 2] = jacobian[self.height + 2, COUNT + 3] = 1.0 / TILT_SD
        return residuals, jacobian

    def log_prior(self, q: Array) -> float:
        """Return the logarithm of the prior density of the skirt and the tilts; a density over L is one over L / depth."""
        against, _ = self.prior(q)
        scale = (
            np.log(np.diag(self._whitener)).sum()
            - 2.0 * math.log(TILT_SD)
            - COUNT * math.log(max(q[self.height], 1e-4))
        )
        return float(scale - 0.5 * against @ against - 0.5 * against.size * math.log(2.0 * math.pi))

    def satisfied(self, q: Array) -> bool:
        """Return whether the prior has little against the skirt and the tilts."""
        against, _ = self.prior(q)
        return bool(against @ against < LIKELY)

    def outside(self, q: Array, x: Array, y: Array) -> Array:
        """Return how far places lie outside the rim, m."""
        return skirt(self.rim(q), q[self.skirt], x, y)[3]

    def measure(self, q: Array, covariance: Array) -> FittedSizes:
        """Return the sizes; raises IllConditioned where the fit shrank to a point or turned into a hollow."""
        radii = self.radii_of(q)
        if min(radii) <= SMALLEST or q[self.height] <= 0.0:
            raise IllConditioned(
                f"no {self.name} fits the contact: it is too shallow or too small for the noise; press deeper, or average more frames"
            )
        sd = np.sqrt(np.diag(covariance))
        sizes = [self._size(2 + min(axis, self.radii - 1), q, covariance) for axis in (0, 1)]
        return FittedSizes(
            center=((float(q[0]), float(sd[0])), (float(q[1]), float(sd[1]))),
            diameter_i=sizes[0],
            diameter_j=sizes[1],
            depth=(float(q[self.height]), float(sd[self.height])),
        )

    def _size(self, place: int, q: Array, covariance: Array) -> tuple[float, float]:
        """Return a diameter and its sd: of the radius at `place`, the correction, and the fillet."""
        slopes = self.rim(q).slopes(q[self.skirt])
        axis = [place - 2] if self.radii == 2 else [0, 1]
        by_fillet = 2.0 * float(np.mean([1.0 - math.tan(0.5 * math.atan(abs(slopes[a]))) for a in axis]))
        chosen = np.ix_([place, self.correction], [place, self.correction])
        variance = 4.0 * float(covariance[chosen].sum()) + (by_fillet * self.context.fillet_sd) ** 2
        return 2.0 * float(q[place] + q[self.correction]), math.sqrt(variance)
