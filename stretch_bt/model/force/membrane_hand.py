"""The parameters in which one hand differs from another, and their effect on the table of forces."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from stretch_bt.model.force.membrane_table import read_table

__all__ = ["BOUNDS", "PARAMETERS", "MembraneHand"]

Array = npt.NDArray[np.float64]

GRAVITY = 9.81  # m/s^2
_MIDDLE = 0.905  # sag of a sheet 90 mm wide and 100 mm long, over a strip's
_SOFTENED = 0.5  # part of its stress that the table's softened membrane has lost


class MembraneHand(NamedTuple):
    """The parameters of a hand that a calibration finds: Pa, m, m, and three numbers without a unit.

    `second_invariant` is the share of I2 in Mooney and Rivlin's energy, and `friction` the share of the force which the table's
    coefficient of 0.5 adds. `softening` is the part of its stress that the membrane has lost where it was stretched much
    further before (Mullins).
    """

    shear_modulus: float
    thickness: float
    mount_prestretch: float
    second_invariant: float = 0.0
    friction: float = 0.0
    softening: float = 0.0

    @property
    def tension(self) -> float:
        """Shear modulus times thickness, N/m: all forces are proportional to it."""
        return self.shear_modulus * self.thickness

    def hang(self, stretch: float, conditioned: float) -> float:
        """Return the sag of the free membrane in its middle, m, at a stretch, m, after one to `conditioned`, m, softened it.

        A strip pulled along by s = (mu (1 - c) + mu c / l) (l - 1 / l^2) hangs by rho g l L^2 / 8 s, and so do the sides of the
        solved sheet, within 3 % from 4 mm of stretch on; its middle, which the clamps keep wide, by 0.905 of that.
        """
        table = read_table()
        drawn = 1 + (self.mount_prestretch + stretch) / table.gauge
        modulus = self.shear_modulus * (1 - self.second_invariant + self.second_invariant / drawn)
        stress = modulus * (drawn - drawn**-2) * (1 - (self.softening if stretch < conditioned else 0.0))
        return _MIDDLE * table.density * GRAVITY * drawn * table.gauge**2 / (8 * stress)

    def logarithms(self, stretches: Array, conditioned: float) -> Array:
        """Return (diameters, n, depths) float, the logarithm of the force over tension and unit, at stretches (n,), m.

        `conditioned` is the stretch, m, up to which the membrane was pressed before.
        """
        table = read_table()
        return table.logarithms(
            self.mount_prestretch + stretches,
            share=self.second_invariant,
            friction=self.friction,
            bending=(self.thickness / table.thickness) ** 2,
            weight=table.modulus / self.shear_modulus,
            softening=self.softening / _SOFTENED,
            softened=self.mount_prestretch + conditioned,
        )


PARAMETERS = MembraneHand._fields
#: least and most of each parameter of a hand: beyond, it is no such membrane
BOUNDS: dict[str, tuple[float, float]] = {
    "shear_modulus": (1e3, 1e7),
    "thickness": (2e-4, 0.02),
    "mount_prestretch": (0.0, 0.04),
    "second_invariant": (0.0, 0.6),
    "friction": (0.0, 2.0),
    "softening": (0.0, 0.5),
}
