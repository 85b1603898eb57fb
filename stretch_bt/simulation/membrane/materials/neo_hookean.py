"""The neo-Hookean material."""

from __future__ import annotations

from dataclasses import dataclass

from stretch_bt.simulation.membrane.materials.base import positive_modulus

__all__ = ["NeoHookean"]


@dataclass(frozen=True, slots=True)
class NeoHookean:
    """W = mu/2 (I1 - 3), with the shear modulus mu, Pa."""

    shear_modulus: float

    def __post_init__(self) -> None:
        positive_modulus(self.shear_modulus)

    @property
    def coefficients(self) -> tuple[float, float]:
        """(1/2, 0)."""
        return 0.5, 0.0
