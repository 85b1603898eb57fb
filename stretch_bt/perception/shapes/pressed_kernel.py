"""Heights of a membrane over a body that is pressed into it, compiled; pressed_surface.py says what they are."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stretch_bt.compiled import kernel

__all__ = ["CONE", "FACE", "LIFT_AT", "SPHERE", "fill_pressed", "fill_pressed_jacobian"]

SPHERE, FACE, CONE = 0, 1, 2

NODES = 16  # on the rim, by which what the top hands on to the skirt is taken apart into harmonics
HARMONICS = 5
BENT = 6  # ways in which the skirt may bend otherwise
FREE = 3  # harmonics below this are continued as they are; those above decay, which their continuation does not
STEEPEST = 1e-2  # least squared cosine between z and a sphere's normal
LIFT_AT = 15  # of a sphere, by how much bending lifts the sheet; its bending length follows
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
    """Fill the elliptic coordinates (4, n) of places (n,): exp(tau), tau, cos psi and sin psi; exp(tau) is 0 inside the rim.

    The square root of a complex number is written out, because its power takes a logarithm and an exponential. What stands beside
    the 0 of a place inside the rim means nothing.
    """
    a, b, k = math.exp(q[4]), math.exp(q[5]), math.exp(q[8])
    size, flat = 0.5 * (a + b / k), (a - b / k) / (a + b / k)
    by_a, by_b, along, across, middle_x, middle_y = 1.0 / a, 1.0 / b, 1.0 / size, 1.0 / (k * size), q[6], q[7]
    grown, tau, cosine, sine = place[0], place[1], place[2], place[3]
    for i in range(x.size):
        dx, dy = x[i] - middle_x, y[i] - middle_y
        wx, wy = dx * along, dy * across
        real, imag = wx * wx - wy * wy - 4.0 * flat, 2.0 * wx * wy
        large = math.sqrt(0.5 * (math.sqrt(real * real + imag * imag) + abs(real)))
        small = 0.5 * imag / large
        root_x = large if real >= 0.0 else abs(small)
        root_y = small if real >= 0.0 else math.copysign(large, imag)
        half = -0.5 if wx * root_x + wy * root_y < 0.0 else 0.5
        zx, zy = 0.5 * wx + half * root_x, 0.5 * wy + half * root_y
        far, share_x, share_y = math.sqrt(zx * zx + zy * zy), dx * by_a, dy * by_b
        back = 1.0 / far
        cosine[i], sine[i] = zx * back, zy * back
        grown[i] = 0.0 if share_x * share_x + share_y * share_y <= 1.0 else max(far, 1.0)
    for i in range(x.size):
        tau[i] = math.log(grown[i]) if grown[i] > 0.0 else 0.0


@kernel("void(float64[::1],float64[::1],float64,float64,float64,float64[::1],float64[::1])")
def fill_fall(grown: Any, tau: Any, width: Any, sine: Any, begin: Any, fallen: Any, share: Any) -> None:
    """Fill how far a catenoid falls on the way to places (n,), and the share of tau that the edge of a face leaves."""
    for i in range(tau.size):
        if grown[i] > 0.0:
            rounded, far = tau[i], grown[i]
            if width > 0.0:
                rounded = 0.5 * tau[i] * tau[i] / width if tau[i] < width else tau[i] - 0.5 * width
                far = math.exp(rounded)
            share[i] = rounded / max(tau[i], 1e-9)
            fallen[i] = (
                math.log(far + math.sqrt(far * far - sine * sine)) - begin
            )  # acosh(far / sine) less that at the rim


@kernel("void(int64,float64[:,::1],float64[:,::1],float64[:,::1],float64[::1])")
def add_harmonic(n: Any, harmonics: Any, place: Any, turn: Any, height: Any) -> None:
    """Add to the height (n,) how the skirt goes on from one harmonic of the rim, and turn (5, n) to the next.

    `turn` holds cos and sin of n psi, exp(n tau), exp(-n tau) and exp(-tau).
    """
    even_x, even_y, odd_x, odd_y = harmonics[0, n], harmonics[1, n], harmonics[2, n], harmonics[3, n]
    grown, tau, cosine, sine = place[0], place[1], place[2], place[3]
    turn_x, turn_y, up, down, back, half = turn[0], turn[1], turn[2], turn[3], turn[4], 0.5 / n
    for i in range(height.size):
        even = 0.5 * (up[i] + down[i]) if n < FREE else (1.0 + n * tau[i]) * down[i]
        odd = half * (up[i] - down[i]) if n < FREE else tau[i] * down[i]
        real, imag = even * even_x + odd * odd_x, even * even_y + odd * odd_y
        height[i] += 2.0 * (turn_x[i] * real - turn_y[i] * imag)
    for i in range(height.size):
        x, y = turn_x[i], turn_y[i]
        turn_x[i], turn_y[i] = x * cosine[i] - y * sine[i], x * sine[i] + y * cosine[i]
        up[i], down[i] = up[i] * grown[i], down[i] * back[i]


@kernel("void(float64[::1],float64,float64[:,::1],float64[::1])")
def add_bends(q: Any, fall: Any, place: Any, height: Any) -> None:
    """Add to the height (n,) by how much q[9:15] lets the skirt depart."""
    alike, even, odd, once, aside, steeper = q[9], q[10], q[11], q[12], q[13], q[14]
    tau, cosine, sine = place[1], place[2], place[3]
    for i in range(height.size):
        c, s, square = cosine[i], sine[i], fall * tau[i] * tau[i]
        h = height[i] + alike * square + even * (square * (c * c - s * s)) + odd * (square * (c * s + s * c))
        height[i] = h + once * (square * c) + aside * (square * s) + steeper * (square * tau[i])


@kernel("void(float64[::1],float64[::1],float64[::1],float64[::1])")
def add_lift(q: Any, x: Any, y: Any, height: Any) -> None:
    """Add to the height (n,) by how much bending lifts the sheet.

    The sheet leaves the ball a bending length before the rim, with the ball's curvature, and comes to the skirt's as 1 - exp(-t).
    """
    a, b, wide = math.exp(q[4]), math.exp(q[5]), abs(q[LIFT_AT + 1]) + 1e-9
    rim, size = math.sqrt(a * b), 2.0 * q[LIFT_AT] * q[3] * q[LIFT_AT + 1] * q[LIFT_AT + 1]
    for i in range(x.size):
        share_x, share_y = (x[i] - q[6]) / a, (y[i] - q[7]) / b
        t = (math.sqrt(share_x * share_x + share_y * share_y) - 1.0) * rim / wide + 1.0
        if t > 0.0:
            left = math.exp(-t)
            height[i] += size * (0.5 - left + (0.5 * (1.0 - t) * (1.0 - t) if t < 1.0 else 0.0))


@kernel("float64(int64,float64[::1],float64[::1],float64[::1],float64[:,::1],float64[::1])")
def fill_over(kind: Any, q: Any, x: Any, y: Any, place: Any, height: Any) -> Any:
    """Fill the height (n,) of a membrane over a body at places (n,) with their coordinates; return by how much the skirt falls at first."""
    a, b, k = math.exp(q[4]), math.exp(q[5]), math.exp(q[8])
    harmonics, work, turn = np.empty((4, HARMONICS)), np.empty((2, x.size)), np.empty((5, x.size))
    h0, p, s, fall, slope = rim_of(kind, q, harmonics)
    cosine = 1.0 / math.sqrt(1.0 + slope * slope)
    sine = max(slope * cosine, LEAST_SLOPE)
    begin, width = (
        math.log(1.0 + math.sqrt(1.0 - sine * sine)),
        abs(q[17]) / (0.5 * (a + b / k)) if kind == FACE else 0.0,
    )
    grown, fallen, share = place[0], work[0], work[1]
    fill_fall(grown, place[1], width, sine, begin, fallen, share)
    level, middle_x, middle_y, steep = harmonics[0, 0], q[6], q[7], fall * cosine
    for i in range(x.size):
        height[i] = h0 + p * (x[i] - middle_x) + s * (y[i] - middle_y) + level - steep * fallen[i]
    turn[0], turn[1], turn[2] = place[2], place[3], grown
    for i in range(x.size):
        turn[3, i] = 1.0 / grown[i]
    turn[4] = turn[3]
    for n in range(1, HARMONICS):
        add_harmonic(n, harmonics, place, turn, height)
    if kind == FACE:
        for i in range(x.size):
            square, e2 = grown[i] * grown[i], place[2, i] * place[2, i] - place[3, i] * place[3, i]
            height[i] -= q[16] * 0.25 * (square - 1.0 / square) * e2 * share[i]
    add_bends(q, fall, place, height)
    for i in range(x.size):
        if grown[i] == 0.0:
            height[i] = top_at(kind, q, x[i], y[i])[0]
    if kind == SPHERE and q.size > LIFT_AT + 1:
        add_lift(q, x, y, height)
    return fall


@kernel("void(int64,float64[::1],float64[::1],float64[::1],float64[::1])")
def fill_pressed(kind: Any, q: Any, x: Any, y: Any, height: Any) -> None:
    """Fill the height (n,) of a membrane over a body at places (n,)."""
    place = np.empty((4, x.size))
    fill_places(q, x, y, place)
    fill_over(kind, q, x, y, place, height)


@kernel("void(float64,float64[:,::1],float64[:,::1])")
def fill_bends(fall: Any, place: Any, by_bends: Any) -> None:
    """Fill the derivatives (6, n) of the height by q[9:15]."""
    for i in range(place.shape[1]):
        c, s, square = place[2, i], place[3, i], fall * place[1, i] * place[1, i]
        if place[0, i] == 0.0:
            c, s, square = 0.0, 0.0, 0.0
        by_bends[0, i], by_bends[1, i], by_bends[2, i] = square, square * (c * c - s * s), square * (c * s + s * c)
        by_bends[3, i], by_bends[4, i], by_bends[5, i] = square * c, square * s, square * place[1, i]


@kernel("void(int64,float64[::1],float64[::1],float64[::1],float64[::1],float64[:,::1])")
def fill_pressed_jacobian(kind: Any, q: Any, x: Any, y: Any, height: Any, jacobian: Any) -> None:
    """Fill the height (n,) and its derivatives (p, n) by the parameters, by differences where it is not linear in them.

    The coordinates of the places change with the rim alone, q[4:9].
    """
    place, other, moved = np.empty((4, x.size)), np.empty((4, x.size)), q.copy()
    fill_places(q, x, y, place)
    fill_bends(fill_over(kind, q, x, y, place, height), place, jacobian[9 : 9 + BENT])
    jacobian[0] = 1.0
    for p in range(1, q.size):
        if 9 <= p < 9 + BENT:
            continue
        moved[p] = q[p] + STEP
        if 4 <= p < 9:
            fill_places(moved, x, y, other)
        fill_over(kind, moved, x, y, other if 4 <= p < 9 else place, jacobian[p])
        moved[p] = q[p]
        difference = jacobian[p]
        for i in range(x.size):
            difference[i] = (difference[i] - height[i]) / STEP
