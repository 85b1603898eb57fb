"""From the direction of a point to the pixel that a distorting lens sees it with, compiled."""

from __future__ import annotations

from typing import Any

from stretch_bt.compiled import kernel

__all__ = ["bend"]

_STEPS = 30
_MET = 1e-10  # of a unit of depth; far less than a pixel
_NOWHERE = 1e6


@kernel("void(float64[::1],float64[::1],float64[::1])")
def bend(x: Any, y: Any, k: Any) -> Any:
    """Change undistorted coordinates (n,) into the distorted ones that the inverse Brown-Conrady model takes to them.

    By Newton's method; k (5,) is (k1, k2, p1, p2, k3). Where the lens folds there are none, and they end far off any image.
    """
    for n in range(len(x)):
        u, v = x[n], y[n]
        met = False
        for _ in range(_STEPS):
            r2 = u * u + v * v
            radial = 1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]))
            rate = 2.0 * (k[0] + r2 * (2.0 * k[1] + 3.0 * r2 * k[4]))
            off_x = u * radial + 2.0 * k[2] * u * v + k[3] * (r2 + 2.0 * u * u) - x[n]
            off_y = v * radial + 2.0 * k[3] * u * v + k[2] * (r2 + 2.0 * v * v) - y[n]
            if abs(off_x) + abs(off_y) < _MET:
                met = True
                break
            xx = radial + rate * u * u + 2.0 * k[2] * v + 6.0 * k[3] * u
            yy = radial + rate * v * v + 2.0 * k[3] * u + 6.0 * k[2] * v
            xy = rate * u * v + 2.0 * k[2] * u + 2.0 * k[3] * v
            area = xx * yy - xy * xy
            if not area > 1e-6:
                break
            u -= (off_x * yy - off_y * xy) / area
            v -= (off_y * xx - off_x * xy) / area
        x[n], y[n] = (u, v) if met else (_NOWHERE, _NOWHERE)
