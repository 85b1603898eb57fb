"""How finely and how exactly the sheet is solved."""

from __future__ import annotations

from dataclasses import dataclass

from stretch_bt.errors import InvalidInput
from stretch_bt.plain_numbers import is_number

__all__ = ["Settings"]

# coarsen, growth, corrected, by error of the force
_WITHIN = {0.03: (2.2, 2.0, False), 0.01: (1.0, 1.8, False), 0.003: (0.8, 1.4, True)}


@dataclass(frozen=True, slots=True)
class Settings:
    """How finely and how exactly to solve.

    `mesh` is the length of the smallest elements, m; None chooses it by indenter and depth. Elements grow by `growth`
    away from the contact; 1 makes all alike. `coarsen` scales the length. `exact` iterates until the forces balance to
    1e-7; without it a press stops when the force has settled to about 0.1 %, as a control loop wants. `corrected`
    adds to the force, to first order, the part that the soft contact leaves out, at the price of one more factor. `budget` bounds
    the Newton iterations of a press, all its attempts together; with friction, the iterations of each increment.
    """

    mesh: float | None = None
    growth: float = 1.6
    coarsen: float = 1.0
    exact: bool = True
    corrected: bool = True
    budget: int = 1000

    def __post_init__(self) -> None:
        if self.mesh is not None and not (is_number(self.mesh) and self.mesh > 0):
            raise InvalidInput(f"the mesh must be a length above 0 m, not {self.mesh!r}")
        if not (is_number(self.growth) and 1 <= self.growth <= 3):
            raise InvalidInput(f"the growth of elements must lie from 1 to 3, not {self.growth!r}")
        if not (is_number(self.coarsen) and 0.05 <= self.coarsen <= 20):
            raise InvalidInput(f"coarsen must lie from 0.05 to 20, not {self.coarsen!r}")
        if not (is_number(self.budget) and self.budget >= 1 and self.budget == int(self.budget)):
            raise InvalidInput(f"the budget must be a whole number of at least 1 iteration, not {self.budget!r}")

    @property
    def elements(self) -> tuple[float | None, float, float]:
        """The settings that decide the elements."""
        return self.mesh, self.growth, self.coarsen

    @classmethod
    def within(cls, error: float) -> Settings:
        """Return settings for a control loop: steps of about 1 mm, each started from the last, as quick as `error` allows.

        `error` bounds the relative error of the force under spheres, at depths of 3 mm and more and stretches of 10 mm
        and more; the measure is a mesh of 0.5 mm. It does not bound how two presses differ: in steps of 0.01 mm the force of
        the coarsest settings may fall by 0.6 % as the depth grows.
        """
        for reached, (coarsen, growth, corrected) in _WITHIN.items():
            if error >= reached:
                return cls(growth=growth, coarsen=coarsen, exact=False, corrected=corrected)
        raise InvalidInput(f"no settings are known to stay within {error:g} of the force; at least {min(_WITHIN):g}")
