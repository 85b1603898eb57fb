"""One step of a fit of a pressed surface, and what cells are above it, compiled."""

from __future__ import annotations

from typing import Any

import numpy as np

from stretch_bt.compiled import kernel
from stretch_bt.perception.arrays_kernel import solve_in_place
from stretch_bt.perception.shapes.pressed_kernel import fill_pressed, fill_pressed_jacobian

__all__ = ["damped_step", "fill_left", "fill_left_jacobian"]

LARGEST = (0.4, 0.4, 0.4, 0.4, 0.5)  # steps of q[4:9]


@kernel("boolean(float64[::1],float64[:,::1],float64[::1],float64,float64[::1])")
def damped_step(q: Any, normal: Any, slope: Any, damping: Any, moved: Any) -> Any:
    """Fill parameters (p,) after a step by normal equations (p, p) whose diagonal is raised by a share; False where they have no solution.

    The step is shortened where the rim would move by much.
    """
    damped, step, share = normal.copy(), slope.copy(), 1.0
    for p in range(slope.size):
        damped[p, p] += damping * normal[p, p]
    if not solve_in_place(damped, step):
        return False
    for p in range(4, 9):
        share = max(share, abs(step[p]) / LARGEST[p - 4])
    for p in range(slope.size):
        moved[p] = q[p] + step[p] / share
    return True


@kernel("void(float64[::1],float64[::1],float64[:,:],float64[::1],float64[::1],float64[::1])")
def fill_met(x: Any, y: Any, lean: Any, left: Any, met_x: Any, met_y: Any) -> None:
    """Fill where the rays of cells (n,) that lean (2, n) come down on a surface which they are `left` (n,) above."""
    for i in range(x.size):
        met_x[i] = x[i] - lean[0, i] * left[i]
        met_y[i] = y[i] - lean[1, i] * left[i]


@kernel(
    "void(int64,float64[::1],float64[::1],float64[::1],float64[::1],float64[:,:],float64[::1],float64[::1])",
)
def fill_left(kind: Any, q: Any, x: Any, y: Any, z: Any, lean: Any, before: Any, left: Any) -> None:
    """Fill what cells are above a surface (n,), each where its own ray meets it, as far as `before` (n,) says where."""
    met_x, met_y = np.empty(x.size), np.empty(x.size)
    fill_met(x, y, lean, before, met_x, met_y)
    fill_pressed(kind, q, met_x, met_y, left)
    for i in range(x.size):
        left[i] = z[i] - left[i]


@kernel("void(int64,float64[::1],float64[::1],float64[::1],float64[:,:],float64[::1],float64[:,::1])")
def fill_left_jacobian(kind: Any, q: Any, x: Any, y: Any, lean: Any, left: Any, jacobian: Any) -> None:
    """Fill the derivatives (p, n) of a surface's height, each where the ray of a cell meets it."""
    met_x, met_y = np.empty(x.size), np.empty(x.size)
    fill_met(x, y, lean, left, met_x, met_y)
    fill_pressed_jacobian(kind, q, met_x, met_y, np.empty(x.size), jacobian)
