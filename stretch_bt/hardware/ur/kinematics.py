"""Kinematics of the UR5 and the UR5e, by the maker's nominal Denavit-Hartenberg parameters.

A robot's own calibration differs from them by millimetres, so these say whether a pose can be reached and how; where the hand is
says the controller. Parameters: Universal Robots, "DH parameters for calculations of kinematics and dynamics".
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.hardware.transforms import Array, rotation_vector

__all__ = ["JOINTS", "MODELS", "Kinematics"]

JOINTS = ("base", "shoulder", "elbow", "wrist 1", "wrist 2", "wrist 3")
Joints = Sequence[float] | Array
_STEPS = 30
_NEAR = 1e-10
_LONGEST_STEP = 0.3


@dataclass(frozen=True)
class Kinematics:
    """Where the flange is for six joint angles, and back.

    Parameters
    ----------
    name
        Name of the model.
    d, a, alpha
        Six offsets, m, lengths, m, and twists, rad.
    """

    name: str
    d: tuple[float, ...]
    a: tuple[float, ...]
    alpha: tuple[float, ...] = (math.pi / 2, 0.0, 0.0, math.pi / 2, -math.pi / 2, 0.0)

    def frames(self, q: Joints) -> Array:
        """Return the (7, 4, 4) transforms of base, joints and flange in the base, for six joint angles, rad."""
        made = np.empty((7, 4, 4))
        made[0] = np.eye(4)
        for i, angle in enumerate(q):
            c, s = math.cos(angle), math.sin(angle)
            ca, sa = math.cos(self.alpha[i]), math.sin(self.alpha[i])
            link = [
                [c, -s * ca, s * sa, self.a[i] * c],
                [s, c * ca, -c * sa, self.a[i] * s],
                [0.0, sa, ca, self.d[i]],
                [0.0, 0.0, 0.0, 1.0],
            ]
            made[i + 1] = made[i] @ np.array(link)
        return made

    def forward(self, q: Joints) -> Array:
        """Return the (4, 4) transform of the flange in the base, for six joint angles, rad."""
        flange: Array = self.frames(q)[6]
        return flange

    def jacobian(self, q: Joints) -> Array:
        """Return the (6, 6) Jacobian of the flange in base axes: m/s and rad/s for each rad/s."""
        frames = self.frames(q)
        axes, places = frames[:6, :3, 2], frames[:6, :3, 3]
        columns = np.hstack([np.cross(axes, frames[6, :3, 3] - places), axes])
        made: Array = columns.T
        return made

    def inverse(self, flange: Array, near: Joints) -> Array:
        """Return the six joint angles, rad, next to `near` that put the flange there, by damped Newton steps to 1e-10.

        Raises
        ------
        IllConditioned
            There are none next to them: the place is out of reach, or the arm is stretched out or folded on the way.
        """
        if not (np.isfinite(flange).all() and np.isfinite(near).all()):
            raise InvalidInput("a flange pose and joint angles must be finite")
        q = np.array(near, dtype=np.float64)
        for _ in range(_STEPS):
            frames = self.frames(q)
            error = _difference(frames[6], flange)
            if float(np.abs(error).max()) < _NEAR:
                return q
            axes, places = frames[:6, :3, 2], frames[:6, :3, 3]
            jacobian = np.hstack([np.cross(axes, frames[6, :3, 3] - places), axes]).T
            damping = min(1e-3 * float(error @ error), 1e-4) + 1e-14
            step = jacobian.T @ np.linalg.solve(jacobian @ jacobian.T + damping * np.eye(6), error)
            most = float(np.abs(step).max())
            q += step if most <= _LONGEST_STEP else step * (_LONGEST_STEP / most)
        raise IllConditioned(
            f"the {self.name} has no joint angles for this pose next to {np.round(np.degrees(near)).astype(int).tolist()} deg; "
            "it is out of reach, or too near to where the arm is stretched out or folded"
        )

    def margin(self, q: Joints) -> float:
        """Return how far six joint angles, rad, are from a singular pose; 0 in one.

        The least of |sin| of elbow and wrist 2, and of the distance, m, of the wrist from the cylinder around the base that it
        cannot enter.
        """
        wrist = math.hypot(*self.frames(q)[5, :2, 3]) - abs(self.d[3])
        return min(abs(math.sin(q[2])), abs(math.sin(q[4])), wrist)


def _difference(here: Array, there: Array) -> Array:
    """Return position, m, and rotation vector, rad, that lead from one transform to another, in base axes."""
    made: Array = np.concatenate(
        [there[:3, 3] - here[:3, 3], rotation_vector(there[:3, :3] @ here[:3, :3].T)],
    )
    return made


MODELS: dict[str, Kinematics] = {
    "ur5": Kinematics("UR5", (0.089159, 0.0, 0.0, 0.10915, 0.09465, 0.0823), (0.0, -0.425, -0.39225, 0.0, 0.0, 0.0)),
    "ur5e": Kinematics("UR5e", (0.1625, 0.0, 0.0, 0.1333, 0.0997, 0.0996), (0.0, -0.425, -0.3922, 0.0, 0.0, 0.0)),
}
