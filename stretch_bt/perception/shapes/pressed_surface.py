"""A membrane over a body that is pressed into it: the body's top inside an ellipse, the free membrane around it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.shapes.pressed_kernel import CONE, FACE, LIFT_AT, SPHERE, fill_pressed, fill_pressed_jacobian

__all__ = ["COMMON", "CONE", "FACE", "LENGTH", "LIFT_AT", "SPHERE", "PressedSurface", "prior_of"]

Array = npt.NDArray[np.float64]

COMMON = 15  # parameters that all bodies have
WIDE = (1.0, 1.0, 1.0, 3.0, 3.0, 3.0, 1.0, 1.0)  # standard deviations that say no more than where the contact is
RATIO = (0.6, 0.6)  # mean and deviation of ln(T_j / T_i) / 2: from a sheet pulled alike to one pulled along j only
# How far the skirt of a stretched sheet departs from one of constant tensions, over its fall from the rim, for every tau^2:
# alike around, twice around (even and odd), once around, and alike around as tau^3. Neo-Hookean sheets stretched by 5 to 50 % at the pole.
BENT, BENT_SD = (-0.12, 0.0, 0.0, 0.0, 0.0, 0.0), (0.2, 0.2, 0.05, 0.08, 0.08, 0.1)
# A sheet that bends leaves a ball a bending length, sqrt(D / T), before one that does not, and is higher from there on, by LIFT times what the plate
# equation gives: mean and deviation of this factor, so that one that hardly bends is covered, and of the length, m, for 2 mm of pulled silicone.
LIFT, LENGTH = (0.6, 0.4), (1.8e-3, 0.4e-3)
FLAT = 0.1  # standard deviation of the curvature of a face times the size
KINK_SD = (0.3, 0.1)
ROUND, ROUND_SD = (
    0.3e-3,
    0.4e-3,
)  # m, over which the edge of a face bends the membrane: its fillet times the sine of the slope


@dataclass(frozen=True, slots=True)
class PressedSurface:
    """A sphere, a face with an edge, or a cone, and the membrane that it presses up; `q` are its parameters.

    q[:4] is (c, p1, p2, k) of a SphereSurface, or height, slopes and steepness of a cone about its tip. The membrane leaves the
    body on an ellipse: the logarithms of its semi-axes q[4:6], its middle q[6:8], and q[8] half the logarithm of the ratio of
    the tensions along y and x. Beyond it the membrane obeys T_i z_xx + T_j z_yy = 0 with the height and the slope that the body
    hands on, which determine it (Cauchy's problem): in the elliptic coordinates (tau, psi) of the ellipse whose y is divided
    by sqrt(T_j / T_i), harmonic by harmonic. The part that is alike all around falls as a catenoid does, which holds for steep
    skirts as well. q[9:15] let it depart from that by (1, cos 2 psi, sin 2 psi, cos psi, sin psi, tau) tau^2. At the edge of a
    face, whose k is about 0, the slope changes by q[15:17], in harmonics 0 and 2, over a width q[17]. Around a sphere the sheet bends by q[15]
    times what the plate equation gives for a bending length q[16].
    """

    kind: int
    q: Array

    def heights(self, x: Array, y: Array) -> Array:
        """Return the height (n,) at places (n,)."""
        height = np.empty(x.size)
        fill_pressed(self.kind, self.q, x, y, height)
        return height

    def derivatives(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Return the height (n,) and its derivatives (p, n)."""
        height, jacobian = np.empty(x.size), np.empty((self.q.size, x.size))
        fill_pressed_jacobian(self.kind, self.q, x, y, height, jacobian)
        return height, jacobian

    @property
    def rim(self) -> float:
        """Mean radius of the rim."""
        return math.exp(0.5 * float(self.q[4] + self.q[5]))

    def like(self, other: PressedSurface) -> bool:
        """Whether two surfaces of one kind are the same to a twentieth."""
        return self.kind == other.kind and float(np.abs(self.q[:9] - other.q[:9]).max()) < 0.05


def prior_of(kind: int, size: float) -> tuple[Array, Array]:
    """Return mean and standard deviation (p,) of the parameters, lengths in units of `size`, m."""
    edge, edge_sd = _edge(kind, size)
    mean, sd = np.array([*(0.0,) * 8, RATIO[0], *BENT, *edge]), np.array([*WIDE, RATIO[1], *BENT_SD, *edge_sd])
    if kind == FACE:
        sd[3] = FLAT
    return mean, sd


def _edge(kind: int, size: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return mean and standard deviation of the parameters that only this kind has."""
    if kind == FACE:
        return (0.0, 0.0, ROUND / size), (*KINK_SD, ROUND_SD / size)
    if kind == SPHERE:
        return (LIFT[0], LENGTH[0] / size), (LIFT[1], LENGTH[1] / size)
    return (), ()
