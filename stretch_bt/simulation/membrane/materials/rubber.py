"""The material of a hand, by its two numbers."""

from __future__ import annotations

from stretch_bt.simulation.membrane.materials.base import Material
from stretch_bt.simulation.membrane.materials.mooney_rivlin import MooneyRivlin
from stretch_bt.simulation.membrane.materials.neo_hookean import NeoHookean

__all__ = ["rubber"]


def rubber(shear_modulus: float, share: float = 0.0) -> Material:
    """Return Mooney and Rivlin's material with a share of the second invariant, and without one the neo-Hookean, which costs less."""
    return MooneyRivlin(shear_modulus, share) if share else NeoHookean(shear_modulus)
