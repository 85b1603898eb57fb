"""The two-term Mooney-Rivlin material."""

from __future__ import annotations

from dataclasses import dataclass

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.membrane.materials.base import positive_modulus

__all__ = ["MooneyRivlin"]


@dataclass(frozen=True, slots=True)
class MooneyRivlin:
    """W = mu/2 [(1 - share)(I1 - 3) + share (I2 - 3)], with the shear modulus mu, Pa, and the share of I2, 0 to 1."""

    shear_modulus: float
    share: float

    def __post_init__(self) -> None:
        positive_modulus(self.shear_modulus)
        if not 0 <= self.share <= 1:
            raise InvalidInput(f"the share of the second invariant must lie from 0 to 1, not {self.share!r}")

    @property
    def coefficients(self) -> tuple[float, float]:
        """((1 - share)/2, share/2)."""
        return (1 - self.share) / 2, self.share / 2
