"""The equations of a cap of latex under a hand, and Newton's method for them."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import NoEquilibrium
from stretch_bt.simulation.balloons.elements import foundation, skin, tensions, volume

if TYPE_CHECKING:
    from stretch_bt.simulation.balloons.cap import Cap

__all__ = ["CapBalance", "CapState"]

Array = npt.NDArray[np.float64]

_ROUNDS, _TOLERANCE = 30, 1e-10


class CapState(NamedTuple):
    """One equilibrium, SI: `nodes` (n + 1, 2), m, are (r, z) over the rim; `stiffness` is the slope of the force by the drop.

    `energy` is the energy of skin and hand together, J, without the filling's. `hand` is the height of the hand's face.
    """

    drop: float
    force: float
    stiffness: float
    pressure: float
    hand: float
    energy: float
    nodes: Array
    iterations: int

    @property
    def contact_radius(self) -> float:
        """Radius up to which the hand touches, m."""
        r, z = self.nodes.T
        return float(np.interp(-self.hand, -z, r)) if z[0] > self.hand else 0.0


class CapBalance:
    """The equations of a cap in its unknown node positions, pressure, and height of the hand.

    Without a drop the hand stays where it is. Before the cap is `inflated` its volume is the
    hemisphere's; given the pressure instead, a skin near the limit point of inflation would magnify the error of the mesh.
    """

    def __init__(self, cap: Cap, drop: float | None, *, inflated: bool = True) -> None:
        self.cap, self.drop, self.inflated = cap, drop, inflated
        count = 2 * (cap.elements + 1)
        self.pressure, self.hand, self.size = count, count + 1, count + 2
        self.top = 1
        first = 2 * np.arange(cap.elements)[:, None]
        self.places = first + np.arange(4)
        self._flat = (self.places[:, :, None] * self.size + self.places[:, None, :]).ravel()
        self._fixed = [0, count - 2, count - 1]
        self._goal = 0.0 if drop is None else float(cap.free.nodes[0, 1]) - drop
        self._force, self._length = cap.pressure * cap.radius**2, cap.radius

    def packed(self, nodes: Array, pressure: float, hand: float) -> Array:
        """Return the unknowns."""
        return np.concatenate([nodes.ravel(), [pressure, hand]])

    def system(self, unknown: Array) -> tuple[Array, Array, float, float]:
        """Return residual, matrix, force of the hand and energy."""
        cap, nodes = self.cap, unknown[: self.pressure].reshape(-1, 2)
        pressure, hand = float(unknown[self.pressure]), float(unknown[self.hand])
        latex, room = skin(nodes, cap.rest, cap.modulus), volume(nodes)
        pushed = foundation(nodes, hand, cap.hand)
        gradient = latex.gradient - pressure * room.gradient + pushed.energy.gradient
        hessian = latex.hessian - pressure * room.hessian + pushed.energy.hessian
        residual = self._gathered(gradient)
        matrix = np.asarray(np.bincount(self._flat, hessian.ravel(), self.size**2), float).reshape(self.size, self.size)
        inflates = self._gathered(room.gradient)
        matrix[:, self.pressure] -= inflates
        matrix[:, self.hand] -= self._gathered(pushed.force_gradient)
        self._fill(residual, matrix, inflates, pressure, float(room.value.sum()))
        self._place(residual, matrix, unknown)
        for place in self._fixed:
            residual[place] = 0.0
            matrix[place, :] = 0.0
            matrix[place, place] = self._force / self._length
        return (
            np.asarray(residual),
            np.asarray(matrix),
            pushed.force,
            float(latex.value.sum() + pushed.energy.value.sum()),
        )

    def _gathered(self, parts: Array) -> Array:
        """Return the sum of the elements' parts (n, 4) at each unknown."""
        return np.asarray(np.bincount(self.places.ravel(), parts.ravel(), self.size), float)

    def _fill(self, residual: Array, matrix: Array, inflates: Array, pressure: float, room: float) -> None:
        """Write the equation of the pressure."""
        row, cap = self.pressure, self.cap
        if not self.inflated:
            held, slope = cap.volume, 0.0
        else:
            held, slope = cap.filling.room(cap.volume, cap.free.pressure, pressure)
        residual[row] = held - room
        matrix[row] -= inflates
        matrix[row, row] = slope

    def _place(self, residual: Array, matrix: Array, unknown: Array) -> None:
        """Write the equation of the hand's height: the top is where it shall be, or the hand stays."""
        row = self.hand
        if self.drop is None:
            matrix[row, row] = 1.0
        else:
            residual[row], matrix[row, self.top] = unknown[self.top] - self._goal, 1.0

    def _small(self, residual: Array) -> bool:
        """Return whether the residual is below the tolerance: forces, volume or pressure, and height, each in its own unit."""
        scale = np.full(self.size, self._force)
        scale[self.pressure] = self._length**3
        scale[self.hand] = self._length
        return bool(np.abs(residual / scale).max() <= _TOLERANCE)

    def solve(self, unknown: Array) -> Array:
        """Return the root that Newton finds from here.

        Raises
        ------
        NoEquilibrium
            It does not converge, or the surface is torn or turned over on the way.
        """
        self.iterations = 0
        with np.errstate(all="ignore"):
            for _ in range(_ROUNDS):
                residual, matrix, _, _ = self.system(unknown)
                if not np.isfinite(matrix).all():
                    break
                if self._small(residual):
                    self._check(unknown)
                    return unknown
                self.iterations += 1
                try:
                    step = np.asarray(np.linalg.solve(matrix, -residual), float)
                except np.linalg.LinAlgError:
                    break
                unknown = unknown + self._shortened(step) * step
        raise NoEquilibrium("Newton does not converge on the shape of the cap")

    def _check(self, unknown: Array) -> None:
        """Raise NoEquilibrium where the surface crosses its axis, is folded, or is pressed together."""
        nodes = unknown[: self.pressure].reshape(-1, 2)
        span = np.diff(nodes, axis=0)
        if (nodes[1:, 0] <= 0).any() or ((span[1:] * span[:-1]).sum(axis=1) <= 0).any():
            raise NoEquilibrium("the skin is folded")
        if min(tension.min() for tension in tensions(nodes, self.cap.rest)) < 0:
            raise NoEquilibrium("the skin has lost its tension")

    def _shortened(self, step: Array) -> float:
        """Return the part of a step that moves no node by more than a tenth of the radius."""
        largest = float(np.abs(step[: self.pressure]).max())
        return min(1.0, 0.1 * self._length / largest) if largest > 0 else 1.0

    def state(self, unknown: Array, drop: float) -> CapState:
        """Return the solution with its force and stiffness."""
        _, _, force, energy = self.system(unknown)
        nodes = unknown[: self.pressure].reshape(-1, 2)
        stiffness = 0.0 if force == 0 else self._stiffness(unknown)
        return CapState(
            drop,
            force,
            stiffness,
            float(unknown[self.pressure]),
            float(unknown[self.hand]),
            energy,
            nodes.copy(),
            self.iterations,
        )

    def _stiffness(self, unknown: Array) -> float:
        """Return the slope of the force by the drop, from the equations' own derivatives."""
        problem = self if self.drop is not None else CapBalance(self.cap, 0.0)
        _, matrix, _, _ = problem.system(unknown)
        load = np.zeros(self.size)
        load[self.hand] = -1.0
        moved = np.linalg.solve(matrix, load)
        nodes = unknown[: self.pressure].reshape(-1, 2)
        pushed = foundation(nodes, float(unknown[self.hand]), self.cap.hand)
        along = self._gathered(pushed.force_gradient)
        return float(along @ moved - pushed.stiffness * moved[self.hand])
