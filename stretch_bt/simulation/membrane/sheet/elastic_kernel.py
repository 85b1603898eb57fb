"""Energy, gradient and Hessian of the stretched sheet, element by element, compiled.

Units: lengths in the sheet's own unit, energy in shear modulus x thickness x unit^2. Control points (ny, nx, 3); the
first and last row are clamped, the Hessian of the others goes straight into lower band storage band[column, row - column].
With F the (3, 2) gradient, i = C^-1, P = F i and Q = P F^T, the second variation of W(t, J) between directions a and b is
A_ab = S_ab 1 + 4 [W_tt f_a f_b' + J W_tJ (f_a p_b' + p_a f_b') + (J^2 W_JJ + J W_J) p_a p_b'] - 2 J W_J [i_ab Q + p_b p_a'].
"""

from __future__ import annotations

from typing import Any

import numpy as np

from stretch_bt.compiled import kernel
from stretch_bt.simulation.membrane.sheet.energy_kernel import strain_energy

__all__ = ["EXACT", "GRADIENT", "PROJECTED", "elastic", "peaks"]

GRADIENT, EXACT, PROJECTED = 0, 1, 2


@kernel()
def tensile(s11: Any, s12: Any, s22: Any) -> Any:
    """Return the part of a symmetric (2, 2) stress that pulls."""
    mean, half = 0.5 * (s11 + s22), 0.5 * (s11 - s22)
    radius = np.sqrt(half * half + s12 * s12)
    if mean >= radius:
        return s11, s12, s22
    if mean <= -radius:
        return 0.0, 0.0, 0.0
    f = 0.5 * (mean + radius) / radius
    return f * (half + radius), f * s12, f * (radius - half)


@kernel()
def blocks(
    f1: Any,
    f2: Any,
    s11: Any,
    s12: Any,
    s22: Any,
    i11: Any,
    i12: Any,
    i22: Any,
    k_tt: Any,
    k_tj: Any,
    k_jj: Any,
    k_q: Any,
    weight: Any,
    out: Any,
) -> Any:
    """Fill out (2, 2, 9) with the second variation: out[b, a, 3 c + d] is between direction a, c and direction b, d."""
    for c in range(3):
        p1c, p2c = i11 * f1[c] + i12 * f2[c], i12 * f1[c] + i22 * f2[c]
        for d in range(3):
            p1d, p2d = i11 * f1[d] + i12 * f2[d], i12 * f1[d] + i22 * f2[d]
            q, k = k_q * (p1c * f1[d] + p2c * f2[d]), 3 * c + d
            out[0, 0, k] = weight * (
                k_tt * f1[c] * f1[d] + k_tj * (f1[c] * p1d + p1c * f1[d]) + (k_jj + k_q) * p1c * p1d + i11 * q
            )
            mixed = weight * (
                k_tt * f1[c] * f2[d] + k_tj * (f1[c] * p2d + p1c * f2[d]) + k_jj * p1c * p2d + k_q * p2c * p1d + i12 * q
            )
            out[1, 0, k] = mixed
            out[0, 1, 3 * d + c] = mixed
            out[1, 1, k] = weight * (
                k_tt * f2[c] * f2[d] + k_tj * (f2[c] * p2d + p2c * f2[d]) + (k_jj + k_q) * p2c * p2d + i22 * q
            )
    for k in (0, 4, 8):
        out[0, 0, k] += weight * s11
        out[0, 1, k] += weight * s12
        out[1, 0, k] += weight * s12
        out[1, 1, k] += weight * s22


@kernel()
def rank_update(slopes: Any, variation: Any, rows: Any, local: Any) -> Any:
    """Fill local (9, 81), column function b and then 9 a + 3 c + d for a >= b, from the four Gauss points of an element.

    slopes (8, 9) holds d/dx and d/dy of the nine functions at each point, variation (4, 2, 2, 9) the blocks, rows (8, 81)
    is room. The loops run along contiguous memory, which makes this four times faster than node pair by node pair.
    """
    for g in range(4):
        for a in range(9):
            x, y = slopes[2 * g, a], slopes[2 * g + 1, a]
            for k in range(9):
                rows[2 * g, 9 * a + k] = x * variation[g, 0, 0, k] + y * variation[g, 0, 1, k]
                rows[2 * g + 1, 9 * a + k] = x * variation[g, 1, 0, k] + y * variation[g, 1, 1, k]
    for b in range(9):
        x0, y0, x1, y1 = slopes[0, b], slopes[1, b], slopes[2, b], slopes[3, b]
        x2, y2, x3, y3 = slopes[4, b], slopes[5, b], slopes[6, b], slopes[7, b]
        for r in range(9 * b, 81):
            local[b, r] = (
                rows[0, r] * x0 + rows[1, r] * y0 + rows[2, r] * x1 + rows[3, r] * y1
                + rows[4, r] * x2 + rows[5, r] * y2 + rows[6, r] * x3 + rows[7, r] * y3
            )  # fmt: skip


@kernel()
def scatter(local: Any, ex: Any, ey: Any, nx: Any, ny: Any, band: Any) -> Any:
    """Add an element's matrix, local (9, 81) as above, to the lower band of the unknowns."""
    for b in range(9):
        jb = ey + b // 3 - 1
        if jb < 0:
            continue
        col = 3 * (jb * nx + ex + b % 3)
        for a in range(b, 9):
            ja = ey + a // 3 - 1
            if ja >= ny - 2:
                break
            row = 3 * (ja * nx + ex + a % 3)
            for d in range(3):
                for c in range(d if a == b else 0, 3):
                    band[col + d, row + c - col - d] += local[b, 9 * a + 3 * c + d]


@kernel()
def lines_at(control: Any, ey: Any, vy: Any, sy: Any, lines: Any) -> Any:
    """Fill lines (4, nx, 3): place and slope along y of each column of control points at the two Gauss points of row ey.

    Summing along y once a row, and along x once a point, costs a third of summing over nine functions at each point.
    """
    for q in range(2):
        for i in range(control.shape[1]):
            for c in range(3):
                k0, k1, k2 = control[ey, i, c], control[ey + 1, i, c], control[ey + 2, i, c]
                lines[2 * q, i, c] = vy[ey, q, 0] * k0 + vy[ey, q, 1] * k1 + vy[ey, q, 2] * k2
                lines[2 * q + 1, i, c] = sy[ey, q, 0] * k0 + sy[ey, q, 1] * k1 + sy[ey, q, 2] * k2


@kernel()
def gradient_of(lines: Any, ex: Any, qx: Any, qy: Any, vx: Any, sx: Any, f1: Any, f2: Any) -> Any:
    """Fill f1 and f2 (3,), the derivatives of the place by x and y at a Gauss point, from the lines of its row."""
    for c in range(3):
        u = v = 0.0
        for i in range(3):
            u += sx[ex, qx, i] * lines[2 * qy, ex + i, c]
            v += vx[ex, qx, i] * lines[2 * qy + 1, ex + i, c]
        f1[c], f2[c] = u, v


@kernel()
def pull(
    ex: Any,
    qx: Any,
    qy: Any,
    vx: Any,
    sx: Any,
    f1: Any,
    f2: Any,
    s11: Any,
    s12: Any,
    s22: Any,
    inverse: Any,
    out: Any,
) -> Any:
    """Add the forces of a stress at one Gauss point to out (4, nx, 3), which belongs to the lines.

    `inverse` (5,) is Mesh's, empty where the mesh lies on the sheet as it is.
    """
    for c in range(3):
        u, v = s11 * f1[c] + s12 * f2[c], s12 * f1[c] + s22 * f2[c]
        if inverse.shape[0] > 0:
            u, v = inverse[0] * u + inverse[2] * v, inverse[1] * u + inverse[3] * v
        for i in range(3):
            out[2 * qy, ex + i, c] += sx[ex, qx, i] * u
            out[2 * qy + 1, ex + i, c] += vx[ex, qx, i] * v


@kernel()
def map_point(inverse: Any, f1: Any, f2: Any) -> Any:
    """Turn derivatives (3,) along the mesh into derivatives on the unstretched sheet; return the area the map gives."""
    for c in range(3):
        u, v = f1[c], f2[c]
        f1[c] = inverse[0] * u + inverse[1] * v
        f2[c] = inverse[2] * u + inverse[3] * v
    return inverse[4]


@kernel()
def add_lines(forces: Any, ey: Any, vy: Any, sy: Any, grad: Any) -> Any:
    """Add the forces (4, nx, 3) on the lines of row ey to the gradient, and set them to zero."""
    for i in range(grad.shape[1]):
        for c in range(3):
            for j in range(3):
                grad[ey + j, i, c] += (
                    vy[ey, 0, j] * forces[0, i, c]
                    + sy[ey, 0, j] * forces[1, i, c]
                    + vy[ey, 1, j] * forces[2, i, c]
                    + sy[ey, 1, j] * forces[3, i, c]
                )
            for q in range(4):
                forces[q, i, c] = 0.0


@kernel()
def slopes_at(ex: Any, ey: Any, vx: Any, sx: Any, vy: Any, sy: Any, inverse: Any, slopes: Any) -> Any:
    """Fill slopes (8, 9): d/dx and d/dy of an element's nine functions at each of its four Gauss points."""
    for g in range(4):
        qy, qx = g // 2, g % 2
        for j in range(3):
            for i in range(3):
                u, v = sx[ex, qx, i] * vy[ey, qy, j], vx[ex, qx, i] * sy[ey, qy, j]
                if inverse.shape[0] > 0:
                    m = inverse[ey, ex, qy, qx]
                    u, v = m[0] * u + m[1] * v, m[2] * u + m[3] * v
                slopes[2 * g, 3 * j + i], slopes[2 * g + 1, 3 * j + i] = u, v


@kernel(
    "float64(float64[:,:,::1],float64[:,:,::1],float64[:,:,::1],float64[:,::1],float64[:,:,::1],"
    "float64[:,:,::1],float64[:,::1],float64[:,:,:,:,::1],float64[::1],float64[:,:,:,::1],int64,float64[:,:,::1],"
    "float64[:,::1])"
)
def elastic(
    control: Any,
    vx: Any,
    sx: Any,
    wx: Any,
    vy: Any,
    sy: Any,
    wy: Any,
    inverse: Any,
    law: Any,
    peak: Any,
    mode: Any,
    grad: Any,
    band: Any,
) -> Any:
    """Return the energy, inf where an element has collapsed; adds to grad (ny, nx, 3) and, unless GRADIENT, to band.

    `inverse` (ey, ex, qy, qx, 5) is Mesh's; it has no rows where the mesh lies on the sheet as it is.
    PROJECTED keeps only the tensile part of the stress in the Hessian, which makes it positive in practice.
    """
    ny, nx = control.shape[0], control.shape[1]
    energy = 0.0
    f1, f2, slopes = np.empty(3), np.empty(3), np.empty((8, 9))
    variation, rows, local = np.empty((4, 2, 2, 9)), np.empty((8, 81)), np.empty((9, 81))
    lines, forces = np.empty((4, nx, 3)), np.zeros((4, nx, 3))
    remembers, mapped, plain = law[3] > 0.0, inverse.shape[0] > 0, np.empty(0)
    for ey in range(wy.shape[0]):
        lines_at(control, ey, vy, sy, lines)
        for ex in range(wx.shape[0]):
            for g in range(4):
                qy, qx = g // 2, g % 2
                gradient_of(lines, ex, qx, qy, vx, sx, f1, f2)
                weight = wx[ex, qx] * wy[ey, qy]
                if mapped:
                    weight *= map_point(inverse[ey, ex, qy, qx], f1, f2)
                c11 = f1[0] * f1[0] + f1[1] * f1[1] + f1[2] * f1[2]
                c12 = f1[0] * f2[0] + f1[1] * f2[1] + f1[2] * f2[2]
                c22 = f2[0] * f2[0] + f2[1] * f2[1] + f2[2] * f2[2]
                det = c11 * c22 - c12 * c12
                if not det > 1e-10:
                    return np.inf
                seen = peak[ey, ex, qy, qx] if remembers else 0.0
                w, wt, wj, wtt, wtj, wjj = strain_energy(c11 + c22, det, seen, law)
                energy += weight * w
                i11, i12, i22 = c22 / det, -c12 / det, c11 / det
                h = 2.0 * det * wj
                s11, s12, s22 = 2.0 * wt + h * i11, h * i12, 2.0 * wt + h * i22
                back = inverse[ey, ex, qy, qx] if mapped else plain
                pull(ex, qx, qy, vx, sx, f1, f2, weight * s11, weight * s12, weight * s22, back, forces)
                if mode != 0:
                    if mode == 2:
                        s11, s12, s22 = tensile(s11, s12, s22)
                    blocks(
                        f1, f2, s11, s12, s22, i11, i12, i22,
                        4.0 * wtt, 4.0 * det * wtj, 4.0 * det * (det * wjj + wj), -h, weight, variation[g],
                    )  # fmt: skip
            if mode != 0:
                slopes_at(ex, ey, vx, sx, vy, sy, inverse, slopes)
                rank_update(slopes, variation, rows, local)
                scatter(local, ex, ey, nx, ny, band)
        add_lines(forces, ey, vy, sy, grad)
    return energy


@kernel(
    "void(float64[:,:,::1],float64[:,:,::1],float64[:,:,::1],float64[:,:,::1],float64[:,:,::1],"
    "float64[:,:,:,:,::1],float64[::1],float64[:,:,:,::1])"
)
def peaks(control: Any, vx: Any, sx: Any, vy: Any, sy: Any, inverse: Any, law: Any, peak: Any) -> Any:
    """Raise the largest energy seen at each Gauss point, peak (ey, ex, qy, qx), to the present shape's."""
    virgin = law.copy()
    virgin[3] = 0.0
    f, lines = np.empty((2, 3)), np.empty((4, control.shape[1], 3))
    for ey in range(peak.shape[0]):
        lines_at(control, ey, vy, sy, lines)
        for ex in range(peak.shape[1]):
            for qy in range(peak.shape[2]):
                for qx in range(peak.shape[3]):
                    gradient_of(lines, ex, qx, qy, vx, sx, f[0], f[1])
                    if inverse.shape[0] > 0:
                        map_point(inverse[ey, ex, qy, qx], f[0], f[1])
                    c11, c12, c22 = np.sum(f[0] * f[0]), np.sum(f[0] * f[1]), np.sum(f[1] * f[1])
                    w = strain_energy(c11 + c22, c11 * c22 - c12 * c12, 0.0, virgin)[0]
                    peak[ey, ex, qy, qx] = max(peak[ey, ex, qy, qx], w)
