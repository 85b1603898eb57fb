"""The sheet itself: its size, its material and the effects that are on."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from stretch_bt.errors import InvalidInput
from stretch_bt.plain_numbers import is_number
from stretch_bt.simulation.membrane.materials import Material, NeoHookean
from stretch_bt.simulation.membrane.sheet.effects import Effects
from stretch_bt.simulation.membrane.sheet.outline import Rectangle, SheetOutline
from stretch_bt.simulation.membrane.sheet.spline import Array

__all__ = ["Sheet"]

_GRAVITY = 9.81  # m/s^2


def _default_material() -> Material:
    return NeoHookean(47.4e3)


@dataclass(frozen=True, slots=True)
class Sheet:
    """A membrane between two clamps, rectangular unless it has another outline: lengths in m.

    `gauge` is its unstressed length between the clamps, `width` the length of the clamps, which hold that width. A
    stretch and the `mount_prestretch` both move the clamps apart from there.
    """

    gauge: float = 0.1
    width: float = 0.09
    thickness: float = 0.002
    material: Material = field(default_factory=_default_material)
    mount_prestretch: float = 0.0
    effects: Effects = field(default_factory=Effects)
    outline: SheetOutline = field(default_factory=Rectangle)

    def __post_init__(self) -> None:
        for name in ("gauge", "width", "thickness"):
            value = getattr(self, name)
            if not (is_number(value) and value > 0):
                raise InvalidInput(f"the {name} of a sheet must be a finite length above 0 m, not {value!r}")
        if not 0.05 <= self.width / self.gauge <= 20:
            raise InvalidInput("a sheet must be at most 20 times as long as wide, or as wide as long")
        if not is_number(self.mount_prestretch) or self.mount_prestretch < 0:
            raise InvalidInput(f"the mount pre-stretch must be a length of at least 0 m, not {self.mount_prestretch!r}")

    @property
    def unit(self) -> float:
        """The sheet's own unit of length, m: a hundredth of the gauge, so that results scale exactly."""
        return self.gauge / 100

    @property
    def force_unit(self) -> float:
        """Shear modulus x thickness x unit, N."""
        return self.material.shear_modulus * self.thickness * self.unit

    def span(self, stretch: float) -> float:
        """Return the distance between the clamps, sheet units."""
        return (self.gauge + self.mount_prestretch + stretch) / self.unit

    def law(self) -> Array:
        """Return the parameters of the strain energy as the kernels take them."""
        return np.array([*self.material.coefficients, *self.effects.law()])

    @property
    def weight(self) -> float:
        """Weight per area over shear modulus x thickness, per sheet unit of height."""
        return self.effects.sag * _GRAVITY * self.unit / self.material.shear_modulus
