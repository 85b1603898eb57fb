"""An inflated cap of latex under a hand: a surface of revolution in finite strain, solved by Newton at a given drop of its top.

The skin is a neo-Hookean membrane, free of stress as a smaller hemisphere, clamped where it meets the rim of its cup. The hand
is an elastic foundation above it; a foundation of 1e9 N/m^3 stands for a rigid plate.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput, NoEquilibrium
from stretch_bt.simulation.balloons.elements import foundation, skin, tensions, volume
from stretch_bt.simulation.balloons.filling import Filling, Liquid

__all__ = ["HAND", "PLATE", "Cap", "CapState"]

Array = npt.NDArray[np.float64]

#: N/m^3; of the soft hand, and of what stands for a rigid plate
HAND, PLATE = 2.6e5, 1e9
_ROUNDS, _TOLERANCE = 30, 1e-10
_FIRST, _LEAST_STEP = 0.002, 1e-5  # parts of the radius


class CapState(NamedTuple):
    """One equilibrium, SI: `nodes` (n + 1, 2), m, are (r, z) over the rim; `stiffness` is the slope of the force by the drop.

    `energy` is that of skin and hand together, J; the filling has its own. `hand` is how high the face of the hand stands.
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


@dataclass(frozen=True)
class Cap:
    """A hemisphere of `radius`, m, that stands `pressure`, Pa, over the air around, its skin stretched by `prestretch`.

    The modulus of the skin follows from the pressure: mu h (1 - prestretch^-6) = pressure radius / 2. `hand` is the modulus
    of the foundation, N/m^3, `elements` how many rings there are.
    """

    radius: float
    pressure: float
    prestretch: float = 2.5
    filling: Filling = field(default_factory=Liquid)
    hand: float = HAND
    elements: int = 48

    def __post_init__(self) -> None:
        for name in ("radius", "pressure", "hand"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise InvalidInput(f"the {name} of a cap must be a finite number above 0, not {value!r}")
        if not (math.isfinite(self.prestretch) and self.prestretch > 1):
            raise InvalidInput(f"the prestretch of a cap must be above 1, not {self.prestretch!r}")
        if self.elements < 4:
            raise InvalidInput(f"a cap needs at least 4 elements, not {self.elements}")

    @cached_property
    def modulus(self) -> float:
        """Shear modulus of the skin times its thickness at rest, N/m."""
        return self.pressure * self.radius / 2 / (1 - self.prestretch**-6)

    @cached_property
    def sphere(self) -> Array:
        """(n + 1, 2) nodes on the inflated hemisphere, m."""
        angle = np.linspace(0.0, math.pi / 2, self.elements + 1)
        nodes = self.radius * np.stack([np.sin(angle), np.cos(angle)], axis=1)
        nodes[0, 0] = nodes[-1, 1] = 0.0
        return nodes

    @cached_property
    def rest(self) -> Array:
        """(n + 1, 2) nodes free of stress, m."""
        return self.sphere / self.prestretch

    @cached_property
    def free(self) -> CapState:
        """The cap that nothing touches; its volume is what the filling keeps or starts from."""
        problem = _Problem(self, None)
        unknown = problem.solve(problem.packed(self.sphere, self.pressure, 2 * self.radius))
        return problem.state(unknown, 0.0)

    @cached_property
    def volume(self) -> float:
        """Volume over the rim when nothing touches, m^3."""
        return float(volume(self.free.nodes).value.sum())

    def press(self, drop: float, start: CapState | None = None) -> CapState:
        """Return the equilibrium after a drop of the top, m; `start` is one at another drop to go on from.

        Raises
        ------
        NoEquilibrium
            There is none within the steps that continuation may take.
        InvalidInput
            The drop is not between 0 and the height of the cap.
        """
        if not 0 <= drop < self.radius:
            raise InvalidInput(f"the drop must be from 0 to below {self.radius} m, not {drop!r}")
        if drop == 0:
            return self.free
        state = start if start is not None and start.drop > 0 else self._touch(drop)
        return state if state.drop == drop else self._march(state, drop)

    def _touch(self, drop: float) -> CapState:
        """Return a first state in contact, at most at this drop: the hand is lowered by a given way, which drops less."""
        way = min(drop, _FIRST * self.radius)
        problem = _Problem(self, None)
        top = float(self.free.nodes[0, 1])
        while way >= _LEAST_STEP * self.radius:
            try:
                unknown = problem.solve(problem.packed(self.free.nodes, self.pressure, top - way))
            except NoEquilibrium:
                way /= 4
            else:
                return problem.state(unknown, top - float(unknown[problem.top]))
        raise NoEquilibrium("the hand does not settle on the top of the cap")

    def _march(self, state: CapState, drop: float) -> CapState:
        """Follow the branch from one state to the drop, in steps that are halved where Newton fails."""
        before: CapState | None = None
        step = drop - state.drop
        rounds = 0
        while state.drop != drop:
            aim = drop if abs(drop - state.drop) <= abs(step) * (1 + 1e-9) else state.drop + step
            try:
                following = self._step(state, before, aim)
            except NoEquilibrium:
                step /= 2
                if abs(step) < _LEAST_STEP * self.radius:
                    raise NoEquilibrium(
                        f"a cap has no equilibrium past a drop of {state.drop * 1e3:.3g} mm that Newton finds"
                    ) from None
                continue
            rounds += following.iterations
            before, state = state, following
            step *= 1.5
        return state._replace(iterations=rounds)

    def _step(self, state: CapState, before: CapState | None, aim: float) -> CapState:
        problem = _Problem(self, aim)
        guess = problem.packed(state.nodes, state.pressure, state.hand)
        if before is not None and before.drop != state.drop:
            part = (aim - state.drop) / (state.drop - before.drop)
            guess += part * (guess - problem.packed(before.nodes, before.pressure, before.hand))
        return problem.state(problem.solve(guess), aim)


class _Problem:
    """The equations of a cap in its unknown node positions, pressure, and height of the hand.

    Without a drop the pressure is that of the inflated cap where the hand is above it, and the hand stays where it is.
    """

    def __init__(self, cap: Cap, drop: float | None) -> None:
        self.cap, self.drop = cap, drop
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
        residual = np.bincount(self.places.ravel(), gradient.ravel(), self.size)
        matrix = np.bincount(self._flat, hessian.ravel(), self.size**2).reshape(self.size, self.size)
        inflates = np.bincount(self.places.ravel(), room.gradient.ravel(), self.size)
        matrix[:, self.pressure] -= inflates
        matrix[:, self.hand] -= np.bincount(self.places.ravel(), pushed.force_gradient.ravel(), self.size)
        self._fill(residual, matrix, inflates, pressure, float(room.value.sum()))
        self._place(residual, matrix, unknown)
        for place in self._fixed:
            residual[place] = 0.0
            matrix[place, :] = 0.0
            matrix[place, place] = self._force / self._length
        return residual, matrix, pushed.force, float(latex.value.sum() + pushed.energy.value.sum())

    def _fill(self, residual: Array, matrix: Array, inflates: Array, pressure: float, room: float) -> None:
        """Write the equation of the pressure."""
        row, cap = self.pressure, self.cap
        if "free" not in cap.__dict__:
            residual[row], matrix[row, row] = pressure - cap.pressure, 1.0
            return
        held, slope = cap.filling.room(cap.volume, cap.pressure, pressure)
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
        """Tell whether the residual is below the tolerance: forces, volume or pressure, and height, each in its own unit."""
        scale = np.full(self.size, self._force)
        scale[self.pressure] = self._length**3 if "free" in self.cap.__dict__ else self.cap.pressure
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
                    step = np.linalg.solve(matrix, -residual)
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
        _, matrix, force, energy = self.system(unknown)
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
        problem = self if self.drop is not None else _Problem(self.cap, 0.0)
        _, matrix, _, _ = problem.system(unknown)
        load = np.zeros(self.size)
        load[self.hand] = -1.0
        moved = np.linalg.solve(matrix, load)
        nodes = unknown[: self.pressure].reshape(-1, 2)
        pushed = foundation(nodes, float(unknown[self.hand]), self.cap.hand)
        along = np.bincount(self.places.ravel(), pushed.force_gradient.ravel(), self.size)
        return float(along @ moved - pushed.stiffness * moved[self.hand])
