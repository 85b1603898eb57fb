"""Hertz contact of the membrane, taken as an elastic half-space, with three indenters, and its exact inverse.

The three formulas are those that the StRETcH paper prints, section "Model"; its cylinder carries no (1 - v^2).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput, shown
from stretch_bt.frames import as_reals
from stretch_bt.plain_numbers import is_number

__all__ = ["SHAPES", "hertz_depth", "hertz_force"]


def hertz_force(
    shape: str,
    depth: npt.ArrayLike,
    modulus: npt.ArrayLike,
    *,
    radius: npt.ArrayLike | None = None,
    angle: npt.ArrayLike | None = None,
    poisson: float = 0.5,
    object_modulus: float = math.inf,
    object_poisson: float = 0.5,
) -> Any:
    """Return the contact force, N, of an indenter pressed into the membrane.

    With modulus E, radius R, depth d, Poisson ratio v and angle theta to the membrane plane::

        sphere    4/3 sqrt(d^3 R) / ((1 - v^2)/E + (1 - v_o^2)/E_o)
        cylinder  2 R d E                                   flat-ended and rigid
        cone      2 d^2 E / (pi (1 - v^2) tan(theta))       rigid

    Parameters
    ----------
    shape
        "sphere", "cylinder" or "cone".
    depth
        How far the indenter has sunk in, m, 0 or more.
    modulus
        Effective modulus of the membrane, Pa.
    radius
        Radius of a sphere or cylinder, m.
    angle
        Angle between the surface of a cone and the membrane plane, rad, between 0 and pi/2.
    poisson, object_poisson
        Poisson ratios of the membrane and of an elastic sphere.
    object_modulus
        Young's modulus of an elastic sphere, Pa; infinite when rigid.

    Returns
    -------
    float, or an array where an argument is one
    """
    law = _law(shape, modulus, radius, angle, poisson, object_modulus, object_poisson)
    return _plain(law.factor * _non_negative("depth", depth, "m") ** law.power)


def hertz_depth(
    shape: str,
    force: npt.ArrayLike,
    modulus: npt.ArrayLike,
    *,
    radius: npt.ArrayLike | None = None,
    angle: npt.ArrayLike | None = None,
    poisson: float = 0.5,
    object_modulus: float = math.inf,
    object_poisson: float = 0.5,
) -> Any:
    """Return the depth, m, at which `hertz_force` gives this force, N; the other arguments are the same."""
    law = _law(shape, modulus, radius, angle, poisson, object_modulus, object_poisson)
    return _plain((_non_negative("force", force, "N") / law.factor) ** (1 / law.power))


class _Law(NamedTuple):
    """Every Hertz form is factor * depth^power."""

    factor: Any
    power: float


def _sphere(modulus: Any, size: Any, softness: float, object_softness: float) -> _Law:
    return _Law(4 / 3 * np.sqrt(size) / (softness / modulus + object_softness), 1.5)


def _cylinder(modulus: Any, size: Any, softness: float, object_softness: float) -> _Law:
    return _Law(2 * size * modulus, 1.0)


def _cone(modulus: Any, size: Any, softness: float, object_softness: float) -> _Law:
    return _Law(2 * modulus / (math.pi * softness * np.tan(size)), 2.0)


SHAPES: dict[str, tuple[str, Callable[[Any, Any, float, float], _Law]]] = {
    "sphere": ("radius", _sphere),
    "cylinder": ("radius", _cylinder),
    "cone": ("angle", _cone),
}


def _law(
    shape: str, modulus: Any, radius: Any, angle: Any, poisson: float, object_modulus: float, object_poisson: float
) -> _Law:
    if not isinstance(shape, str) or shape not in SHAPES:
        raise InvalidInput(f"shape must be one of {', '.join(SHAPES)}, not {shown(shape)[:80]}")
    wanted, law = SHAPES[shape]
    size = _size(shape, wanted, radius=radius, angle=angle)
    softness = 1 - _poisson("poisson", poisson) ** 2
    object_softness = (1 - _poisson("object_poisson", object_poisson) ** 2) / _object_modulus(shape, object_modulus)
    return law(_positive("modulus", modulus, "Pa"), size, softness, object_softness)


def _size(shape: str, wanted: str, **given: Any) -> Any:
    extra = [name for name, value in given.items() if value is not None and name != wanted]
    if extra or given[wanted] is None:
        raise InvalidInput(f"a {shape} needs {wanted}" + (f", and no {extra[0]}" if extra else ""))
    size = _positive(wanted, given[wanted], "rad" if wanted == "angle" else "m")
    if wanted == "angle" and np.any(size >= math.pi / 2):
        raise InvalidInput(f"angle must lie between 0 and pi/2 rad, not {given[wanted]}")
    return size


def _object_modulus(shape: str, value: float) -> float:
    rigid = isinstance(value, float | np.floating) and value == math.inf
    if not (rigid or (is_number(value) and value > 0)):
        raise InvalidInput(
            f"object_modulus must be above 0 Pa, or infinite for a rigid object, not {shown(value)[:80]}"
        )
    if shape != "sphere" and not rigid:
        raise InvalidInput(f"the {shape} is rigid: object_modulus must be infinite, not {value}")
    return float(value)


def _poisson(name: str, value: float) -> float:
    if not (is_number(value) and -1 < value <= 0.5):
        raise InvalidInput(f"{name} must lie above -1 and at most at 0.5, not {shown(value)[:80]}")
    return float(value)


def _finite(name: str, value: Any, unit: str) -> Any:
    array = as_reals(f"{name} must be", value, unit)
    if not np.all(np.isfinite(array)):
        raise InvalidInput(f"{name} must be finite, {unit}, not {value}")
    return array


def _positive(name: str, value: Any, unit: str) -> Any:
    array = _finite(name, value, unit)
    if not np.all(array > 0):
        raise InvalidInput(f"{name} must be above 0 {unit}, not {value}")
    return array


def _non_negative(name: str, value: Any, unit: str) -> Any:
    array = _finite(name, value, unit)
    if not np.all(array >= 0):
        raise InvalidInput(f"{name} must be at least 0 {unit}, not {value}")
    return array


def _plain(value: Any) -> Any:
    return float(value) if np.ndim(value) == 0 else value
