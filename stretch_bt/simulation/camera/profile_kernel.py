"""The depth that each pixel sees of a round bump on a flat sheet, and of the table beside a sheet, compiled."""

from __future__ import annotations

import math
from typing import Any

from stretch_bt.compiled import kernel

__all__ = ["look_at_profile", "look_beside"]

_STEPS = 60
_CLOSE = 1e-8  # m; the error left after such a step is far less


@kernel()
def rise(table: Any, scale: Any, r: Any) -> Any:
    """Return height and slope at a distance from the axis, from heights at even distances; flat beyond them."""
    position = r * scale
    if position >= table.shape[0] - 1:
        return 0.0, 0.0
    i = int(position)
    step = table[i + 1] - table[i]
    return table[i] + (position - i) * step, step * scale


@kernel()
def meet(o: Any, dx: Any, dy: Any, dz: Any, table: Any, scale: Any, near: Any, far: Any) -> Any:
    """Return the depth between two at which a ray from o (3,) goes through the profile; its axis is at x = y = 0.

    At `near` it is above the profile and at `far` on the flat sheet's plane: Newton's method between them, halving where it
    would leave them.
    """
    x, y = o[0] + far * dx, o[1] + far * dy
    d = max(far + rise(table, scale, math.sqrt(x * x + y * y))[0] / dz, near)
    for _ in range(_STEPS):
        x, y = o[0] + d * dx, o[1] + d * dy
        r = math.sqrt(x * x + y * y)
        z, slope = rise(table, scale, r)
        off = o[2] + d * dz - z
        if off > 0.0:
            near = d
        else:
            far = d
        rate = dz - slope * (x * dx + y * dy) / max(r, 1e-9)
        following = d - off / min(rate, -1e-6)
        if not near <= following <= far:
            following = 0.5 * (near + far)
        if abs(following - d) < _CLOSE:
            return following
        d = following
    return d


@kernel(
    "void(float64[:,::1],float64[:,::1],float64[:,::1],float64[::1],float64[::1],float64,float64,float64,float64,"
    "float32[:,::1])"
)
def look_at_profile(
    x: Any, y: Any, axes: Any, place: Any, table: Any, scale: Any, level: Any, side: Any, end: Any, image: Any
) -> Any:
    """Fill the image (h, w), m, where a ray meets the sheet of half width `side` and half length `end`.

    Rays are (x, y, 1) @ axes (3, 3) from place (3,), whose x and y count from the bump's axis (place[3], place[4]). The
    sheet lies at z = level beside the bump, and the bump ends where its table does.
    """
    top = table[0] - level
    reach = (table.shape[0] - 1) / scale
    for v in range(image.shape[0]):
        for u in range(image.shape[1]):
            a, b = x[v, u], y[v, u]
            dx = a * axes[0, 0] + b * axes[1, 0] + axes[2, 0]
            dy = a * axes[0, 1] + b * axes[1, 1] + axes[2, 1]
            dz = a * axes[0, 2] + b * axes[1, 2] + axes[2, 2]
            if dz >= 0.0:
                continue
            far = (level - place[2]) / dz
            px, py = place[0] + far * dx, place[1] + far * dy
            near = far + top / dz
            hit = far
            nx, ny = place[0] + near * dx, place[1] + near * dy
            if top > 0.0 and min(px * px + py * py, nx * nx + ny * ny) < reach * reach:
                hit = meet(place, dx, dy, dz, table, scale, near, far)
            cx, cy = place[3] + place[0] + hit * dx, place[4] + place[1] + hit * dy
            if abs(cx) <= side and abs(cy) <= end:
                image[v, u] = hit


@kernel(
    "void(float64[:,::1],float64[:,::1],float64[:,::1],float64[::1],float64[::1],float64,float64,float64,float32[:,::1])"
)
def look_beside(
    x: Any, y: Any, axes: Any, place: Any, normal: Any, offset: Any, first: Any, last: Any, image: Any
) -> Any:
    """Fill the image (h, w), m, where it is 0, with the plane normal . p = offset; not beyond the fingers.

    The fingers hide everything seen through z = 0 beyond y from `first` to `last`.
    """
    room = offset - (normal[0] * place[0] + normal[1] * place[1] + normal[2] * place[2])
    for v in range(image.shape[0]):
        for u in range(image.shape[1]):
            if image[v, u] != 0.0:
                continue
            a, b = x[v, u], y[v, u]
            dx = a * axes[0, 0] + b * axes[1, 0] + axes[2, 0]
            dy = a * axes[0, 1] + b * axes[1, 1] + axes[2, 1]
            dz = a * axes[0, 2] + b * axes[1, 2] + axes[2, 2]
            rate = normal[0] * dx + normal[1] * dy + normal[2] * dz
            if dz >= 0.0 or not rate * room > 0.0:
                continue
            along = place[1] - place[2] / dz * dy
            if first <= along <= last:
                image[v, u] = room / rate
