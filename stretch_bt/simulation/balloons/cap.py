"""An inflated cap of latex under a hand: a surface of revolution in finite strain, solved at a given drop of its top.

The skin is a neo-Hookean membrane, free of stress as a smaller hemisphere, clamped where it meets the rim of its cup. The hand
is an elastic foundation above it; a foundation of 1e9 N/m^3 stands for a rigid plate.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput, NoEquilibrium
from stretch_bt.simulation.balloons.balance import CapBalance, CapState
from stretch_bt.simulation.balloons.filling import Filling, Liquid

__all__ = ["HAND", "PLATE", "Cap"]

Array = npt.NDArray[np.float64]

#: modulus of the soft hand, and of the foundation that stands for a rigid plate, N/m^3
HAND, PLATE = 2.6e5, 1e9
_FIRST, _LEAST_STEP = 0.002, 1e-5  # parts of the radius


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
        """The cap that nothing touches, inflated to the volume of the hemisphere; its pressure is the given one but for the mesh."""
        problem = CapBalance(self, None, inflated=False)
        unknown = problem.solve(problem.packed(self.sphere, self.pressure, 2 * self.radius))
        return problem.state(unknown, 0.0)

    @property
    def volume(self) -> float:
        """Volume over the rim when nothing touches, m^3."""
        return 2 / 3 * math.pi * self.radius**3

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
        problem = CapBalance(self, None)
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
        problem = CapBalance(self, aim)
        guess = problem.packed(state.nodes, state.pressure, state.hand)
        if before is not None and before.drop != state.drop:
            part = (aim - state.drop) / (state.drop - before.drop)
            guess += part * (guess - problem.packed(before.nodes, before.pressure, before.hand))
        return problem.state(problem.solve(guess), aim)
