"""The force law of a soft object: a power of its deflection whose exponent grows with the deflection."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

__all__ = ["MM", "SOFTEST", "ObjectLaw"]

Array = npt.NDArray[np.float64]

MM = 1e-3  # m, the deflection over which `stiffening` adds to the exponent
SOFTEST = (
    -0.25
)  # least ratio of stiffening to power at the reference, below which the force of a larger deflection would fall
ROUNDS = 50
EXACT = 1e-13


@dataclass(frozen=True, slots=True)
class ObjectLaw:
    """F = F_ref (d / c)^n exp(s (d - c) / 1 mm), with the deflection d and the one at F_ref, `compliance` c, m.

    The local exponent is n + s d / 1 mm. A spring has n = 1, an elastic ball n = 1.5, both without stiffening; a filled skin begins nearly
    linear and stiffens by 0.1 to 0.2 a millimetre.
    """

    compliance: float
    power: float
    stiffening: float = 0.0

    @property
    def bend(self) -> float:
        """The part of the exponent that stiffening adds at the reference."""
        return max(self.stiffening * self.compliance / MM, SOFTEST * self.power)

    def deflection(self, log_force: Array) -> tuple[Array, Array, Array]:
        """Return deflections (n,), m, at logarithms of F / F_ref (n,), local exponents (n,), and derivatives by c, n and s (n, 3)."""
        bend, r = self.bend, np.exp(np.clip(log_force / (self.power + max(self.bend, 0.0)), -700, 50))
        highest = (
            0.9 * self.power / -bend if bend < 0 else np.inf
        )  # beyond it the force of one that softens falls again
        for _ in range(ROUNDS):
            exponent = self.power + bend * r
            step = (self.power * np.log(r) + bend * (r - 1) - log_force) / np.maximum(exponent, 0.1 * self.power)
            r = np.minimum(r * np.exp(np.clip(-step, -1.0, 1.0)), highest)
            if np.max(np.abs(step), initial=0.0) < EXACT:
                break
        exponent = np.maximum(self.power + bend * r, 0.1 * self.power)
        found = self.compliance * r
        rows = np.stack(
            [
                r * (self.power + bend) / exponent,
                -found * np.log(r) / exponent,
                -found * self.compliance / MM * (r - 1) / exponent,
            ],
            axis=-1,
        )
        return found, exponent, rows

    def log_force(self, deflection: float) -> tuple[float, Array]:
        """Return the logarithm of F / F_ref at a deflection, m, and its derivatives by c, n and s (3,)."""
        r, c = deflection / self.compliance, self.compliance
        value = self.power * np.log(r) + self.bend * (r - 1)
        row = np.array([-(self.power + self.bend) / c, np.log(r), c / MM * (r - 1)])
        return float(value), row
