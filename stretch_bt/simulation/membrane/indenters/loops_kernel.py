"""Signed distance, outward normal and curvature of a vault and of closed wires, compiled; results as of distance_kernel."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stretch_bt.compiled import kernel
from stretch_bt.simulation.membrane.indenters.distance_kernel import bend

__all__ = ["polygon", "ring", "vault"]


@kernel("void(float64[:,::1],float64,float64,float64,float64[::1],float64[:,::1],float64[:,::1])")
def vault(points: Any, half: Any, core: Any, rounding: Any, gap: Any, normal: Any, curvature: Any) -> Any:
    """Fill for a half-cylinder of radius core + rounding, its axis along x at z = 0, on a shank, its ends filleted."""
    curvature[:] = 0.0
    for q in range(points.shape[0]):
        x, y, z = points[q, 0], points[q, 1], points[q, 2]
        rise = max(z, 0.0)
        rho = math.sqrt(y * y + rise * rise)
        uy, uz = (y / rho, rise / rho) if rho > 1e-300 else (0.0, 1.0)
        side = 1.0 if x >= 0.0 else -1.0
        out, end = rho - core, abs(x) - half
        if out > 0.0 and end > 0.0:
            away = math.sqrt(out * out + end * end)
            nr, nx = out / away, side * end / away
            s = math.sqrt(1.0 / away)
            bend(curvature, q, 1.0, s * nr, -s * nx * uy, -s * nx * uz)
        elif out >= end:
            away, nr, nx = out, 1.0, 0.0
        else:
            away, nr, nx = end, 0.0, side
        if nr > 0.0 and z > 0.0:
            s = math.sqrt(nr / max(rho, 0.1 * (core + rounding)))
            bend(curvature, q, 1.0, 0.0, -s * uz, s * uy)
        gap[q] = away - rounding
        normal[q, 0], normal[q, 1], normal[q, 2] = nx, nr * uy, nr * uz


@kernel("void(float64[:,::1],float64,float64,float64[::1],float64[:,::1],float64[:,::1])")
def ring(points: Any, radius: Any, rounding: Any, gap: Any, normal: Any, curvature: Any) -> Any:
    """Fill for a torus of radius `radius` about z, of a wire of radius `rounding`."""
    curvature[:] = 0.0
    for q in range(points.shape[0]):
        x, y, z = points[q, 0], points[q, 1], points[q, 2]
        rho = math.sqrt(x * x + y * y)
        ux, uy = (x / rho, y / rho) if rho > 1e-300 else (1.0, 0.0)
        out = rho - radius
        away = math.sqrt(out * out + z * z)
        nr, nz = (out / away, z / away) if away > 1e-300 else (0.0, 1.0)
        gap[q] = away - rounding
        normal[q, 0], normal[q, 1], normal[q, 2] = nr * ux, nr * uy, nz
        s = math.sqrt(1.0 / max(away, 0.1 * rounding))
        bend(curvature, q, 1.0, s * nz * ux, s * nz * uy, -s * nr)
        s = 1.0 / max(rho, 0.1 * radius)
        bend(curvature, q, s * nr, -uy, ux, 0.0)


@kernel("void(float64[:,::1],float64[:,::1],float64,float64,float64[::1],float64[:,::1],float64[:,::1])")
def polygon(points: Any, corners: Any, radius: Any, rounding: Any, gap: Any, normal: Any, curvature: Any) -> Any:
    """Fill for a round wire, of radius `rounding`, that runs `radius` outside a convex polygon at z = 0.

    Its corners (k, 2) are counter-clockwise; around them the wire bends.
    """
    curvature[:] = 0.0
    count = corners.shape[0]
    for q in range(points.shape[0]):
        x, y, z = points[q, 0], points[q, 1], points[q, 2]
        least, most, ux, uy, fx, fy, at_corner = np.inf, -np.inf, 1.0, 0.0, 1.0, 0.0, False
        for k in range(count):
            ax, ay = corners[k, 0], corners[k, 1]
            ex, ey = corners[(k + 1) % count, 0] - ax, corners[(k + 1) % count, 1] - ay
            length = math.sqrt(ex * ex + ey * ey)
            ex, ey = ex / length, ey / length
            along, beside = (x - ax) * ex + (y - ay) * ey, (x - ax) * ey - (y - ay) * ex
            if beside > most:
                most, fx, fy = beside, ey, -ex
            on = min(max(along, 0.0), length)
            dx, dy = x - ax - on * ex, y - ay - on * ey
            square = dx * dx + dy * dy
            if square < least:
                least, ux, uy, at_corner = square, dx, dy, on != along
        far = math.sqrt(least)
        if most <= 0.0 or not at_corner or far < 1e-300:
            far, ux, uy, at_corner = most, fx, fy, False
        else:
            ux, uy = ux / far, uy / far
        out = far - radius
        away = math.sqrt(out * out + z * z)
        nr, nz = (out / away, z / away) if away > 1e-300 else (0.0, 1.0)
        gap[q] = away - rounding
        normal[q, 0], normal[q, 1], normal[q, 2] = nr * ux, nr * uy, nz
        s = math.sqrt(1.0 / max(away, 0.1 * rounding))
        bend(curvature, q, 1.0, s * nz * ux, s * nz * uy, -s * nr)
        if at_corner:
            bend(curvature, q, nr / far, -uy, ux, 0.0)
