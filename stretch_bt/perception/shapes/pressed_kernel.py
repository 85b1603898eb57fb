"""Heights of a membrane over a body that is pressed into it, compiled; pressed_surface.py says what they are."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stretch_bt.compiled import kernel

__all__ = ["CONE", "FACE", "SPHERE", "fill_pressed", "fill_pressed_jacobian"]

SPHERE, FACE, CONE = 0, 1, 2

NODES = 16  # on the rim, by which what the top hands on to the skirt is taken apart into harmonics
HARMONICS = 5
BENT = 6  # ways in which the skirt may bend otherwise
FREE = 3  # harmonics below this are continued as they are; those above decay, which their continuation does not
STEEPEST = 1e-2  # least squared cosine between z and a sphere's normal
TIP = 0.02  # radius, in units of the size, by which the tip of a cone is rounded
LEAST_SLOPE = 1e-4
STEP = 1e-5  # of a parameter, for derivatives

_COS = np.cos(2.0 * np.pi * np.arange(NODES) / NODES)
_SIN = np.sin(2.0 * np.pi * np.arange(NODES) / NODES)


@kernel("UniTuple(float64,3)(int64,float64[::1],float64,float64)")
def top_at(kind: Any, q: Any, x: Any, y: Any) -> Any:
    """Return the height of the body's top at a place, and its slopes along x and y."""
    c, p1, p2, k = q[0], q[1], q[2], q[3]
    if kind == CONE:
        dx, dy = x - q[6], y - q[7]
        r = math.sqrt(dx * dx + dy * dy + TIP * TIP)
        return c + p1 * dx + p2 * dy - k * (r - TIP), p1 - k * dx / r, p2 - k * dy / r
    d0 = 1.0 / math.sqrt(1.0 + p1 * p1 + p2 * p2)
    sx, sy = p1 * d0, p2 * d0
    ux, uy = k * x - sx, k * y - sy
    d = math.sqrt(max(1.0 - ux * ux - uy * uy, STEEPEST))
    return c + (2.0 * (sx * x + sy * y) - k * (x * x + y * y)) / (d + d0), -ux / d, -uy / d


@kernel("UniTuple(float64,5)(int64,float64[::1],float64[:,::1])")
def rim_of(kind: Any, q: Any, harmonics: Any) -> Any:
    """Fill the harmonics (4, n) of the top's height and of its slope across the rim, less the plane at its middle.

    Return that plane's height and slopes, by how much the skirt falls at first, and how steep it is there.
    """
    a, b, k = math.exp(q[4]), math.exp(q[5]), math.exp(q[8])
    h0, p, s = top_at(kind, q, q[6], q[7])
    if kind == CONE:
        p, s = q[1], q[2]
    harmonics[:] = 0.0
    steep = 0.0
    for j in range(NODES):
        rx, ry = a * _COS[j], b * _SIN[j]
        h, gx, gy = top_at(kind, q, q[6] + rx, q[7] + ry)
        gx, gy = gx - p, gy - s
        value = (h - h0 - p * rx - s * ry) / NODES
        across = (gx * b / k * _COS[j] + gy * k * a * _SIN[j]) / NODES
        steep += (gx * gx + gy * gy) / NODES
        for n in range(HARMONICS):
            at = (n * j) % NODES
            harmonics[0, n] += value * _COS[at]
            harmonics[1, n] -= value * _SIN[at]
            harmonics[2, n] += across * _COS[at]
            harmonics[3, n] -= across * _SIN[at]
    fall, slope = -harmonics[2, 0], math.sqrt(steep)
    if kind == FACE:
        fall += q[15]
        slope += abs(q[15]) / (0.5 * (a + b / k))
    return h0, p, s, fall, slope


@kernel("void(float64[::1],float64[::1],float64[::1],float64[:,::1])")
def fill_places(q: Any, x: Any, y: Any, place: Any) -> None:
    """Fill the elliptic coordinates (4, n) of places (n,): exp(tau), tau, cos psi and sin psi; exp(tau) is 0 inside the rim."""
    a, b, k = math.exp(q[4]), math.exp(q[5]), math.exp(q[8])
    size, flat = 0.5 * (a + b / k), (a - b / k) / (a + b / k)
    for i in range(x.size):
        dx, dy = x[i] - q[6], y[i] - q[7]
        if dx * dx / (a * a) + dy * dy / (b * b) <= 1.0:
            place[0, i] = 0.0
            continue
        w = complex(dx / size, dy / (k * size))
        root = (w * w - 4.0 * flat) ** 0.5
        if w.real * root.real + w.imag * root.imag < 0.0:
            root = -root
        z = 0.5 * (w + root)
        far = abs(z)
        place[0, i] = max(far, 1.0)
        place[1, i] = math.log(place[0, i])
        place[2, i], place[3, i] = z.real / far, z.imag / far


@kernel("void(int64,float64[::1],float64[::1],float64[::1],float64[:,::1],float64[::1],float64[:,::1])")
def fill_over(kind: Any, q: Any, x: Any, y: Any, place: Any, height: Any, bent: Any) -> None:
    """Fill the height (n,) of a membrane over a body at places (n,) with their coordinates, and its derivatives (6, n) by q[9:15]."""
    a, b, k = math.exp(q[4]), math.exp(q[5]), math.exp(q[8])
    harmonics = np.empty((4, HARMONICS))
    h0, p, s, fall, slope = rim_of(kind, q, harmonics)
    angle = math.atan(slope)
    sine, cosine = max(math.sin(angle), LEAST_SLOPE), math.cos(angle)
    begin = math.acosh(1.0 / sine)
    size = 0.5 * (a + b / k)
    width = abs(q[17]) / size if kind == FACE else 0.0
    for i in range(x.size):
        grown, tau = place[0, i], place[1, i]
        if grown == 0.0:
            height[i] = top_at(kind, q, x[i], y[i])[0]
            bent[:, i] = 0.0
            continue
        dx, dy = x[i] - q[6], y[i] - q[7]
        e = complex(place[2, i], place[3, i])
        e2 = e * e
        rounded, far = tau, grown
        if width > 0.0:
            rounded = 0.5 * tau * tau / width if tau < width else tau - 0.5 * width
            far = math.exp(rounded)
        h = h0 + p * dx + s * dy + harmonics[0, 0] - fall * cosine * (math.acosh(far / sine) - begin)
        turn = e
        up, down = grown, 1.0 / grown
        for n in range(1, HARMONICS):
            if n < FREE:
                even, odd = 0.5 * (up + down), 0.5 * (up - down) / n
            else:
                even, odd = (1.0 + n * tau) * down, tau * down
            real = even * harmonics[0, n] + odd * harmonics[2, n]
            imag = even * harmonics[1, n] + odd * harmonics[3, n]
            h += 2.0 * (turn.real * real - turn.imag * imag)
            turn, up, down = turn * e, up * grown, down / grown
        if kind == FACE:
            h -= q[16] * 0.25 * (grown * grown - 1.0 / (grown * grown)) * e2.real * (rounded / max(tau, 1e-9))
        square = fall * tau * tau
        bent[0, i], bent[1, i], bent[2, i] = square, square * e2.real, square * e2.imag
        bent[3, i], bent[4, i], bent[5, i] = square * e.real, square * e.imag, square * tau
        for m in range(BENT):
            h += q[9 + m] * bent[m, i]
        height[i] = h


@kernel("void(int64,float64[::1],float64[::1],float64[::1],float64[::1])")
def fill_pressed(kind: Any, q: Any, x: Any, y: Any, height: Any) -> None:
    """Fill the height (n,) of a membrane over a body at places (n,)."""
    place = np.empty((4, x.size))
    fill_places(q, x, y, place)
    fill_over(kind, q, x, y, place, height, np.empty((BENT, x.size)))


@kernel("void(int64,float64[::1],float64[::1],float64[::1],float64[::1],float64[:,::1])")
def fill_pressed_jacobian(kind: Any, q: Any, x: Any, y: Any, height: Any, jacobian: Any) -> None:
    """Fill the height (n,) and its derivatives (p, n) by the parameters, by differences where it is not linear in them.

    The coordinates of the places change with the rim alone, q[4:9].
    """
    place, other = np.empty((4, x.size)), np.empty((4, x.size))
    fill_places(q, x, y, place)
    fill_over(kind, q, x, y, place, height, jacobian[9 : 9 + BENT])
    jacobian[0] = 1.0
    moved, unused = q.copy(), np.empty((BENT, x.size))
    for p in range(1, q.size):
        if 9 <= p < 9 + BENT:
            continue
        moved[p] = q[p] + STEP
        if 4 <= p < 9:
            fill_places(moved, x, y, other)
            fill_over(kind, moved, x, y, other, jacobian[p], unused)
        else:
            fill_over(kind, moved, x, y, place, jacobian[p], unused)
        moved[p] = q[p]
        for i in range(x.size):
            jacobian[p, i] = (jacobian[p, i] - height[i]) / STEP
