"""Ring elements of a surface of revolution: energy, gradient and second derivatives of skin, volume and foundation.

Nodes are (r, z), from the axis to the rim; an element is a cone between two of them, its unknowns are (r1, z1, r2, z2). Each
function returns for all elements at once: value (n,), gradient (n, 4), second derivatives (n, 4, 4).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

__all__ = ["Part", "Pushed", "foundation", "skin", "tensions", "volume"]

Array = npt.NDArray[np.float64]

_APART = np.array([[1.0, 0, -1, 0], [0, 1, 0, -1], [-1, 0, 1, 0], [0, -1, 0, 1]])


class Part(NamedTuple):
    """Value (n,), gradient (n, 4) and second derivatives (n, 4, 4)."""

    value: Array
    gradient: Array
    hessian: Array


class Pushed(NamedTuple):
    """The energy of a foundation, its force, N, and the derivative of that force by the nodes (n, 4); by the height of the hand it
    is -`stiffness`, N/m.
    """

    energy: Part
    force: float
    force_gradient: Array
    stiffness: float


def skin(nodes: Array, rest: Array, modulus: float) -> Part:
    """Return the energy, J, of a neo-Hookean skin.

    w = modulus / 2 (l1^2 + l2^2 + 1 / (l1 l2)^2 - 3) over the stress-free area, with l1 along the meridian and l2 around.

    Parameters
    ----------
    nodes, rest
        (n + 1, 2) float, m, deformed and free of stress.
    modulus
        Shear modulus times thickness at rest, N/m.
    """
    span, length, rest_length, rest_radius, l1, l2 = _stretched(nodes, rest)
    area = 2 * math.pi * rest_radius * rest_length
    along = np.concatenate([-span, span], axis=1) / length[:, None]
    curved = (_APART - along[:, :, None] * along[:, None, :]) / (length * rest_length)[:, None, None]
    d1 = along / rest_length[:, None]
    d2 = np.zeros_like(d1)
    d2[:, 0] = d2[:, 2] = 0.5 / rest_radius

    squeeze = (l1 * l2) ** -2
    by1, by2 = l1 - squeeze / l1, l2 - squeeze / l2
    by11, by22, by12 = 1 + 3 * squeeze / l1**2, 1 + 3 * squeeze / l2**2, 2 * squeeze / (l1 * l2)
    cross = d1[:, :, None] * d2[:, None, :]
    hessian = (
        by11[:, None, None] * d1[:, :, None] * d1[:, None, :]
        + by22[:, None, None] * d2[:, :, None] * d2[:, None, :]
        + by12[:, None, None] * (cross + cross.transpose(0, 2, 1))
        + by1[:, None, None] * curved
    )
    scale = modulus * area
    return Part(
        scale * (l1**2 + l2**2 + squeeze - 3) / 2,
        scale[:, None] * (by1[:, None] * d1 + by2[:, None] * d2),
        scale[:, None, None] * hessian,
    )


def tensions(nodes: Array, rest: Array) -> tuple[Array, Array]:
    """Return the first derivatives of w of `skin` by its two stretches, over the modulus: below 0 where it is pressed together."""
    *_, l1, l2 = _stretched(nodes, rest)
    return l1 - l1**-3 * l2**-2, l2 - l2**-3 * l1**-2


def _stretched(nodes: Array, rest: Array) -> tuple[Array, Array, Array, Array, Array, Array]:
    """Return span, length, length and radius at rest, m, and the stretches along and around."""
    span, rest_span = np.diff(nodes, axis=0), np.diff(rest, axis=0)
    length, rest_length = np.hypot(span[:, 0], span[:, 1]), np.hypot(rest_span[:, 0], rest_span[:, 1])
    rest_radius = (rest[1:, 0] + rest[:-1, 0]) / 2
    l1, l2 = length / rest_length, (nodes[1:, 0] + nodes[:-1, 0]) / 2 / rest_radius
    return span, length, rest_length, rest_radius, l1, l2


def volume(nodes: Array) -> Part:
    """Return the volume, m^3, of the frustum between each element and the axis."""
    (r1, z1), (r2, z2) = nodes[:-1].T, nodes[1:].T
    fall, disc = z1 - z2, r1**2 + r1 * r2 + r2**2
    by1, by2 = 2 * r1 + r2, 2 * r2 + r1
    zero = np.zeros_like(fall)
    gradient = np.stack([by1 * fall, disc, by2 * fall, -disc], axis=1)
    rows = [
        [2 * fall, by1, fall, -by1],
        [by1, zero, by2, zero],
        [fall, by2, 2 * fall, -by2],
        [-by1, zero, -by2, zero],
    ]
    hessian = np.stack([np.stack(row, axis=1) for row in rows], axis=1)
    third = math.pi / 3
    return Part(third * disc * fall, third * gradient, third * hessian)


def foundation(nodes: Array, height: float, modulus: float) -> Pushed:
    """Return the push of an elastic foundation above the surface: a pressure of `modulus`, N/m^3, times how far it is entered.

    Its pressure acts along the normal and depends on the height alone, as a liquid's does, so that it has an energy:
    the integral of modulus / 2 (z - height)^2 over the projected area.
    """
    r1, r2 = nodes[:-1, 0], nodes[1:, 0]
    entered = np.maximum(nodes[:, 1] - height, 0.0)
    first, second = entered[:-1], entered[1:]
    inside1, inside2 = first > 0, second > 0
    # each node stands for the area that its share of the ring has
    ring1, ring2 = (r2 - r1) * (2 * r1 + r2), (r2 - r1) * (r1 + 2 * r2)
    ring1_by = np.stack([r2 - 4 * r1, r1 + 2 * r2], axis=1)
    ring2_by = np.stack([-2 * r1 - r2, 4 * r2 - r1], axis=1)
    scale = modulus * math.pi / 6

    value = scale * (first**2 * ring1 + second**2 * ring2)
    force_by = np.zeros((len(r1), 4))
    force_by[:, ::2] = 2 * scale * (first[:, None] * ring1_by + second[:, None] * ring2_by)
    force_by[:, 1], force_by[:, 3] = 2 * scale * inside1 * ring1, 2 * scale * inside2 * ring2
    gradient = np.zeros_like(force_by)
    gradient[:, ::2] = scale * (first[:, None] ** 2 * ring1_by + second[:, None] ** 2 * ring2_by)
    gradient[:, 1], gradient[:, 3] = 2 * scale * first * ring1, 2 * scale * second * ring2

    hessian = np.zeros((len(r1), 4, 4))
    hessian[:, 0, 0] = scale * (-4 * first**2 - 2 * second**2)
    hessian[:, 2, 2] = scale * (2 * first**2 + 4 * second**2)
    hessian[:, 0, 2] = hessian[:, 2, 0] = scale * (first**2 - second**2)
    for k, by in ((0, 0), (2, 1)):
        hessian[:, k, 1] = hessian[:, 1, k] = 2 * scale * first * ring1_by[:, by]
        hessian[:, k, 3] = hessian[:, 3, k] = 2 * scale * second * ring2_by[:, by]
    hessian[:, 1, 1], hessian[:, 3, 3] = force_by[:, 1], force_by[:, 3]
    force = float(2 * scale * (first * ring1 + second * ring2).sum())
    stiffness = float((force_by[:, 1] + force_by[:, 3]).sum())
    return Pushed(Part(value, gradient, hessian), force, force_by, stiffness)
