"""A light object slides over the table, dragged by the membrane."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Annotated, Any, ClassVar

from pydantic import Field

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects import base
from stretch_bt.simulation.effects.base import ObjectEffect, Size
from stretch_bt.simulation.objects.base import Moved, ObjectSpec
from stretch_bt.simulation.objects.response import Response
from stretch_bt.within import Within

__all__ = ["RigidShift"]

_Friction = Annotated[float, Within(0.0, 10.0)]
Across = tuple[float, float]


class Parameters(base.Parameters):
    """Coefficients of Coulomb friction, assumed: silicone holds on to things better than a smooth table does."""

    membrane: _Friction = Field(default=0.5, description="friction of the membrane on the object")
    table: _Friction = Field(default=0.3, description="friction of the object on the table")


class RigidShift(ObjectEffect):
    """A light object slides over the table, dragged by the membrane.

    A hand that moves across strains the membrane sideways over the object, about as stiffly as it resists being pressed: a
    force F at a depth d makes F / d. The object slides where this pull exceeds the friction on the table, mu_t (F + weight),
    unless the membrane slips over it first, at mu_m F. Both are Coulomb's law, taken over a step at once.
    """

    name = "rigid_shift"
    order = 50
    cost_ms = 0.02
    cost_per = "step"
    Parameters: ClassVar[type[base.Parameters]] = Parameters

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield how far the travel across exceeds the strain at which the object begins to slide."""
        force = max(case.force, 1e-9)
        hold = parameters.table * (1 + case.rough.weight / force)
        if not case.rough.loose or hold >= parameters.membrane:
            return
        slid = max(case.scene.conditions.travel - hold * case.depth, 0.0)
        yield Size(
            "size",
            slid,
            f"dragged {case.scene.conditions.travel * 1e3:.3g} mm, slides from a pull of {hold:.2g} of the force",
        )

    def respond(self, response: Response | None, spec: ObjectSpec) -> Response | None:
        """Return the answer as it is: where an object stands does not change how it gives way."""
        return response

    def slide(self, strain: Across, moved: Moved, weight: float) -> tuple[Across, Across]:
        """Return how far the object slides in a step, (x, y), m, and the strain of the membrane over it after it, (x, y), m.

        Parameters
        ----------
        strain
            How far the membrane is strained sideways over the object before the step, (x, y), m.
        moved
            The step; the sideways part of its force, which the shape of the membrane makes, pulls as well.
        weight
            Weight of the object, N.
        """
        down = -moved.force[2]
        if down <= 0 or moved.depth <= 0:
            return (0.0, 0.0), (0.0, 0.0)
        stiffness = down / moved.depth
        trial = strain[0] + moved.across[0], strain[1] + moved.across[1]
        pull = stiffness * trial[0] + moved.force[0], stiffness * trial[1] + moved.force[1]
        table, grip = self.parameters.table * (down + weight), self.parameters.membrane * down
        size = math.hypot(*pull)
        excess = size - min(table, grip)
        if excess <= 0:
            return (0.0, 0.0), trial
        gives = excess / stiffness * pull[0] / size, excess / stiffness * pull[1] / size
        left = trial[0] - gives[0], trial[1] - gives[1]
        return (gives if table <= grip else (0.0, 0.0)), left
