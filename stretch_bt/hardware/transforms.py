"""Rotation vectors and rigid transforms.

A controller writes a pose as six numbers: position, m, and rotation vector, rad. Here a transform is (4, 4) float.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from stretch_bt.frames import Pose

__all__ = ["Array", "inverse", "pose_of", "rotation_vector", "six", "transform", "transform_of"]

Array = npt.NDArray[np.float64]


def transform(six: Sequence[float]) -> Array:
    """Return the (4, 4) transform of position, m, and rotation vector, rad."""
    x, y, z, a, b, c = (float(v) for v in six)
    return transform_of(Pose((x, y, z), (a, b, c)))


def transform_of(pose: Pose) -> Array:
    """Return the (4, 4) transform of a pose."""
    made = np.eye(4)
    made[:3, :3] = pose.matrix()
    made[:3, 3] = pose.position
    return made


def six(made: Array) -> list[float]:
    """Return position, m, and rotation vector, rad, of a (4, 4) transform."""
    return [float(v) for v in (*made[:3, 3], *rotation_vector(made[:3, :3]))]


def pose_of(made: Array) -> Pose:
    """Return the pose of a (4, 4) transform."""
    x, y, z, a, b, c = six(made)
    return Pose((x, y, z), (a, b, c))


def inverse(made: Array) -> Array:
    """Return the inverse of a rigid (4, 4) transform."""
    back = np.eye(4)
    back[:3, :3] = made[:3, :3].T
    back[:3, 3] = -made[:3, :3].T @ made[:3, 3]
    return back


def rotation_vector(matrix: Array) -> Array:
    """Return the rotation vector (3,), rad, of a rotation (3, 3), its angle at most pi.

    By way of the quaternion's largest component (Shepperd, J. Guidance and Control 1, 1978), so that it holds at any angle.
    """
    m = matrix
    trace = float(np.trace(m))
    squares = [trace, *(2 * float(m[i, i]) - trace for i in range(3))]
    k = int(np.argmax(squares))
    q = np.empty(4)
    q[k] = 1 + squares[k]
    if k == 0:
        q[1:] = m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]
    else:
        i, j, n = k - 1, k % 3, (k + 1) % 3
        q[0] = m[n, j] - m[j, n]
        q[1 + j] = m[j, i] + m[i, j]
        q[1 + n] = m[n, i] + m[i, n]
    q *= math.copysign(1.0, q[0]) / np.linalg.norm(q)
    sine = float(np.linalg.norm(q[1:]))
    if sine < 1e-12:
        return np.zeros(3)
    vector: Array = q[1:] * (2 * math.atan2(sine, float(q[0])) / sine)
    return vector
