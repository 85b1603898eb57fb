"""A material: an incompressible isotropic energy that both solvers understand."""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

from stretch_bt.errors import InvalidInput
from stretch_bt.plain_numbers import is_number

__all__ = ["Material", "energy", "positive_modulus", "tensions"]


@runtime_checkable
class Material(Protocol):
    """An incompressible hyperelastic material, W = mu [c1 (I1 - 3) + c2 (I2 - 3)]."""

    @property
    def shear_modulus(self) -> float:
        """Initial shear modulus mu, Pa."""
        ...

    @property
    def coefficients(self) -> tuple[float, float]:
        """(c1, c2), without dimension; c1 + c2 = 1/2 makes mu the initial shear modulus."""
        ...


def energy(material: Material, l1: Any, l2: Any) -> Any:
    """Return W/mu at in-plane principal stretches l1 and l2; the third is 1/(l1 l2)."""
    c1, c2 = material.coefficients
    a, b = l1 * l1, l2 * l2
    return c1 * (a + b + 1 / (a * b) - 3) + c2 * (a * b + 1 / a + 1 / b - 3)


def tensions(material: Material, l1: Any, l2: Any) -> tuple[Any, Any, Any, Any]:
    """Return n1 = dW/dl1 and n2 = dW/dl2 over mu, and the derivatives of n1 by l1 and by l2."""
    c1, c2 = material.coefficients
    i = 1 / (l1 * l1 * l2 * l2)
    n1 = 2 * c1 * (l1 - i / l1) + 2 * c2 * (l1 * l2 * l2 - 1 / l1**3)
    n2 = 2 * c1 * (l2 - i / l2) + 2 * c2 * (l2 * l1 * l1 - 1 / l2**3)
    a11 = 2 * c1 * (1 + 3 * i / (l1 * l1)) + 2 * c2 * (l2 * l2 + 3 / l1**4)
    a12 = 4 * c1 * i / (l1 * l2) + 4 * c2 * l1 * l2
    return n1, n2, a11, a12


def positive_modulus(value: float) -> None:
    """Raise InvalidInput unless the value is a finite modulus above 0."""
    if not (is_number(value) and value > 0):
        raise InvalidInput(f"the shear modulus must be a finite number above 0 Pa, not {value!r}")
