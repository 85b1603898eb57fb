"""The material of a dough, and the hand that presses it, as the kernels need them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput

__all__ = ["Dough"]


@dataclass(frozen=True, slots=True)
class Dough:
    """An elastic-plastic dough that does not lose volume, under a soft hand.

    `yield_stress` and `modulus`, Pa, are of uniaxial compression, the modulus infinite for a dough that does not spring
    back; the yield stress rises by `thickening`, Pa, at a plastic strain rate of 1/s, with the `power` of the rate.
    `foundation`, N/m^3, is the hand's pressure per depth, `tension`, N/m, its membrane's tension, `friction` the friction on plates,
    from 0 to 1, and `relaxation` the part of an excess that smoothing takes away in a step of the usual length.
    """

    yield_stress: float
    modulus: float = math.inf
    thickening: float = 0.0
    power: float = 0.4
    foundation: float = 2.6e5
    tension: float = 20.0
    friction: float = 0.5
    relaxation: float = 0.5

    def __post_init__(self) -> None:
        positive = (self.yield_stress, self.modulus, self.foundation, self.power, self.relaxation)
        if not (all(v > 0 for v in positive) and math.isfinite(self.yield_stress)):
            raise InvalidInput(f"a dough needs a finite yield stress and other numbers above 0, not {self}")
        if not (self.thickening >= 0 and self.tension >= 0 and 0 <= self.friction <= 1 and self.relaxation <= 1):
            raise InvalidInput(f"thickening and tension are at least 0, friction and relaxation at most 1, not {self}")

    def numbers(self, rate: float = 0.0, steps: float = 1.0) -> npt.NDArray[np.float64]:
        """Return the numbers (8,) that the kernels take, with the yield stress at a plastic strain rate, 1/s, and as much smoothing as in `steps`."""
        flows = self.yield_stress + self.thickening * rate**self.power
        compliant = self.modulus / 0.75  # of plane strain, Poisson's ratio 0.5
        return np.array(
            [
                float(f"{flows:.9g}"),
                compliant,
                self.foundation,
                self.tension,
                self.relaxation if steps == 1.0 else 1.0 - (1.0 - self.relaxation) ** steps,
                self.friction,
                self.thickening,
                self.power,
            ]
        )
