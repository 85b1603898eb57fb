"""Cheaper models that stand in for the sheet: their error is the model's."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from stretch_bt.accuracy.membrane.cases import Case
from stretch_bt.accuracy.membrane.errors import Reference
from stretch_bt.simulation.membrane.axisymmetric import AxisymmetricPress
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.press import WIDTH, press
from stretch_bt.simulation.membrane.surface import pressed_surface
from stretch_bt.simulation.objects.base import HertzForm

__all__ = ["STAND_INS", "StandIn"]


class StandIn(NamedTuple):
    """A model: the indenters that it takes, and a press by it, which gives errors and CPU seconds."""

    shapes: tuple[type, ...]
    solve: Callable[[Case, Reference], tuple[dict[str, float], float]]

    def takes(self, case: Case) -> bool:
        """Whether the model has this indenter."""
        return isinstance(case.indenter, self.shapes)


def _hertz(case: Case, right: Reference) -> tuple[dict[str, float], float]:
    solved = press(case.indenter, case.stretch, case.depth, solver="hertz")
    body = case.indenter
    assert isinstance(body, Sphere | Cylinder)
    form = HertzForm("sphere" if isinstance(body, Sphere) else "cylinder", body.diameter / 2)
    surface = pressed_surface(form, case.depth, WIDTH / 2)
    return right.errors(solved, surface.height), solved.seconds


def _axisymmetric(case: Case, right: Reference) -> tuple[dict[str, float], float]:
    solved = press(case.indenter, case.stretch, case.depth, solver="axisymmetric")
    assert isinstance(solved.detail, AxisymmetricPress)
    return right.errors(solved, solved.detail.height), solved.seconds


STAND_INS = {"hertz": StandIn((Sphere, Cylinder), _hertz), "axisymmetric": StandIn((Sphere,), _axisymmetric)}
