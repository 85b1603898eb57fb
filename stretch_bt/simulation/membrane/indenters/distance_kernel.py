"""Signed distance, outward normal and curvature of the closed-form bodies, compiled.

Every body is a core, open or bounded, that is rounded by a radius; the core's top lies at z = 0 of the body's frame and
the body goes on downwards. Results: gap (n,), normal (n, 3), curvature (n, 6) in the order xx, xy, xz, yy, yz, zz.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stretch_bt.compiled import kernel

__all__ = ["capsule", "cone", "prism", "rotate", "shaft"]


@kernel()
def bend(curvature: Any, q: Any, sign: Any, x: Any, y: Any, z: Any) -> Any:
    """Add sign times the dyad of (x, y, z) to a curvature."""
    curvature[q, 0] += sign * x * x
    curvature[q, 1] += sign * x * y
    curvature[q, 2] += sign * x * z
    curvature[q, 3] += sign * y * y
    curvature[q, 4] += sign * y * z
    curvature[q, 5] += sign * z * z


@kernel("void(float64[:,::1],float64,float64,float64[::1],float64[:,::1],float64[:,::1])")
def shaft(points: Any, core: Any, rounding: Any, gap: Any, normal: Any, curvature: Any) -> Any:
    """Fill for a round shaft of radius core + rounding with a filleted flat end; core 0 makes it a hemisphere."""
    curvature[:] = 0.0
    for q in range(points.shape[0]):
        x, y, z = points[q, 0], points[q, 1], points[q, 2]
        rho = math.sqrt(x * x + y * y)
        out = rho - core
        if z > 0.0 and out > 0.0:  # the fillet
            away = math.sqrt(out * out + z * z)
            nr, nz = out / away, z / away
        elif z > 0.0 or (out <= 0.0 and z > out):  # the face, or inside the core and nearer to it than to the side
            away, nr, nz = z, 0.0, 1.0
        else:
            away, nr, nz = out, 1.0, 0.0
        gap[q] = away - rounding
        ux, uy = (x / rho, y / rho) if rho > 1e-300 else (1.0, 0.0)
        normal[q, 0], normal[q, 1], normal[q, 2] = nr * ux, nr * uy, nz
        if nr > 0.0 and nz > 0.0:
            s = math.sqrt(1.0 / away)
            bend(curvature, q, 1.0, s * nz * ux, s * nz * uy, -s * nr)
        if nr > 0.0 and rho > 1e-300:
            s = math.sqrt(nr / rho)
            bend(curvature, q, 1.0, -s * uy, s * ux, 0.0)
        elif core == 0.0 and z > 0.0:  # the very top of a sphere
            bend(curvature, q, 1.0, 1.0 / math.sqrt(z), 0.0, 0.0)
            bend(curvature, q, 1.0, 0.0, 1.0 / math.sqrt(z), 0.0)


@kernel("void(float64[:,::1],float64,float64,float64[::1],float64[:,::1],float64[:,::1])")
def cone(points: Any, angle: Any, rounding: Any, gap: Any, normal: Any, curvature: Any) -> Any:
    """Fill for a cone whose surface makes `angle` with the horizontal, with a spherical tip of radius rounding."""
    curvature[:] = 0.0
    sine, cosine = math.sin(angle), math.cos(angle)
    for q in range(points.shape[0]):
        x, y, z = points[q, 0], points[q, 1], points[q, 2]
        rho = math.sqrt(x * x + y * y)
        ux, uy = (x / rho, y / rho) if rho > 1e-300 else (1.0, 0.0)
        if rho * cosine <= z * sine:
            away = math.sqrt(rho * rho + z * z)
            nr, nz = (rho / away, z / away) if away > 1e-300 else (0.0, 1.0)
            gap[q] = away - rounding
            s = 1.0 / math.sqrt(max(away, 1e-300))
            bend(curvature, q, 1.0, s * nz * ux, s * nz * uy, -s * nr)
            bend(curvature, q, 1.0, -s * uy, s * ux, 0.0)
        else:
            nr, nz = sine, cosine
            gap[q] = rho * sine + z * cosine - rounding
            s = math.sqrt(sine / max(rho, 0.1 * rounding))  # deep inside, the axis is no place to be stiff at
            bend(curvature, q, 1.0, -s * uy, s * ux, 0.0)
        normal[q, 0], normal[q, 1], normal[q, 2] = nr * ux, nr * uy, nz


@kernel("void(float64[:,::1],float64,float64,float64,float64[::1],float64[:,::1],float64[:,::1])")
def prism(points: Any, half_x: Any, half_y: Any, rounding: Any, gap: Any, normal: Any, curvature: Any) -> Any:
    """Fill for a rectangular post with all edges of its upper end and sides filleted; halves are of the core."""
    curvature[:] = 0.0
    for q in range(points.shape[0]):
        x, y, z = points[q, 0], points[q, 1], points[q, 2]
        sx, sy = (1.0 if x >= 0.0 else -1.0), (1.0 if y >= 0.0 else -1.0)
        ox, oy = abs(x) - half_x, abs(y) - half_y
        dx, dy, dz = max(ox, 0.0), max(oy, 0.0), max(z, 0.0)
        away = math.sqrt(dx * dx + dy * dy + dz * dz)
        if away > 0.0:
            nx, ny, nz = dx / away, dy / away, dz / away
            s = 1.0 / away
            if dx > 0.0:
                curvature[q, 0] = s
            if dy > 0.0:
                curvature[q, 3] = s
            if dz > 0.0:
                curvature[q, 5] = s
            normal[q, 0], normal[q, 1], normal[q, 2] = sx * nx, sy * ny, nz
            bend(curvature, q, -s, sx * nx, sy * ny, nz)
        else:
            away = max(ox, oy, z)
            top, side = away == z, away == ox
            normal[q, 0] = 0.0 if top or not side else sx
            normal[q, 1] = 0.0 if top or side else sy
            normal[q, 2] = 1.0 if top else 0.0
        gap[q] = away - rounding


@kernel("void(float64[:,::1],float64,float64,float64[::1],float64[:,::1],float64[:,::1])")
def capsule(points: Any, half_length: Any, rounding: Any, gap: Any, normal: Any, curvature: Any) -> Any:
    """Fill for a straight round rod along x with spherical ends, around its axis at z = 0."""
    curvature[:] = 0.0
    for q in range(points.shape[0]):
        x, y, z = points[q, 0], points[q, 1], points[q, 2]
        dx = math.copysign(max(abs(x) - half_length, 0.0), x)
        away = math.sqrt(dx * dx + y * y + z * z)
        gap[q] = away - rounding
        if away > 1e-300:
            nx, ny, nz = dx / away, y / away, z / away
        else:
            nx, ny, nz = 0.0, 0.0, 1.0
        normal[q, 0], normal[q, 1], normal[q, 2] = nx, ny, nz
        s = 1.0 / max(away, 0.1 * rounding)
        if dx != 0.0:
            curvature[q, 0] += s
        curvature[q, 3] += s
        curvature[q, 5] += s
        bend(curvature, q, -s, nx, ny, nz)


@kernel("void(float64[:,::1],float64[:,::1],float64[:,::1])")
def rotate(rotation: Any, normal: Any, curvature: Any) -> Any:
    """Turn normals and curvatures by a (3, 3) rotation, in place."""
    full, part = np.empty((3, 3)), np.empty((3, 3))
    for q in range(normal.shape[0]):
        x, y, z = normal[q, 0], normal[q, 1], normal[q, 2]
        for c in range(3):
            normal[q, c] = rotation[c, 0] * x + rotation[c, 1] * y + rotation[c, 2] * z
        k = 0
        for c in range(3):
            for d in range(c, 3):
                full[c, d] = full[d, c] = curvature[q, k]
                k += 1
        for c in range(3):
            for d in range(3):
                part[c, d] = rotation[c, 0] * full[0, d] + rotation[c, 1] * full[1, d] + rotation[c, 2] * full[2, d]
        k = 0
        for c in range(3):
            for d in range(c, 3):
                curvature[q, k] = (
                    part[c, 0] * rotation[d, 0] + part[c, 1] * rotation[d, 1] + part[c, 2] * rotation[d, 2]
                )
                k += 1
