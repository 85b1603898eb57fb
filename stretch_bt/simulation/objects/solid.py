"""The common part of simple solids: either rigid, or a spring of one stiffness that gives way as a whole."""

from __future__ import annotations

import math
from abc import ABC
from typing import Annotated, ClassVar

from pydantic import Field, model_validator

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.objects.base import ObjectSpec
from stretch_bt.simulation.objects.response import LinearResponse, Response
from stretch_bt.units import Stiffness
from stretch_bt.within import Within

__all__ = ["SolidSpec"]


class SolidSpec(ObjectSpec, ABC):
    """Options of a solid that is either rigid or linearly elastic."""

    effects: ClassVar[tuple[str, ...]] = ("compliance",)

    stiffness: Annotated[Stiffness, Within(1.0, 1e7, "Stiffness")] | None = Field(
        default=None, description="force per height lost, of a linearly elastic object"
    )
    rigid: bool = Field(default=False, description="true for an object that does not give way")

    @model_validator(mode="after")
    def _one_law(self) -> SolidSpec:
        if self.rigid == (self.stiffness is not None):
            raise InvalidInput(
                "an object is either elastic or rigid; write one of 'stiffness: 0.9 N/mm' and 'rigid: true'"
            )
        return self

    def compliance(self) -> Response | None:
        """Return its spring, None when it is rigid."""
        return None if self.stiffness is None else LinearResponse(self.stiffness)

    def known(self) -> dict[str, float]:
        """Return its stiffness, N/m, where it has one."""
        return {} if self.stiffness is None else {"stiffness": self.stiffness}

    @property
    def roughly(self) -> float:
        """Its stiffness, N/m, infinite when rigid."""
        return math.inf if self.stiffness is None else self.stiffness
