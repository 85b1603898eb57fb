"""The membrane at `hertz` fidelity: closed forms for force and shape."""

from __future__ import annotations

from collections.abc import Callable

from stretch_bt.errors import InvalidInput, NoEquilibrium
from stretch_bt.model.calibrated import CalibratedHertz
from stretch_bt.model.force_model import ForceModel
from stretch_bt.model.hertz import hertz_force

__all__ = ["HertzMembrane"]


class HertzMembrane:
    """The calibrated Hertz law of a hand, for the shapes that have one.

    The force does not depend on where on the membrane the object is, and the membrane has no memory.
    """

    def __init__(self, model: CalibratedHertz | None = None) -> None:
        chosen = ForceModel.default() if model is None else model
        if not isinstance(chosen, CalibratedHertz):
            raise InvalidInput(f"hertz fidelity needs a calibrated_hertz model, not {chosen.kind}")
        self._model = chosen

    def law(self, shape: str, radius: float, stretch: float) -> Callable[[float], tuple[float, float]]:
        """Return the force, N, and its derivative, N/m, as a function of depth, m."""
        least, most = self._model.range.stretch
        if not least - 1e-9 <= stretch <= most + 1e-9:
            raise NoEquilibrium(f"a stretch of {stretch * 1e3:.4g} mm is outside {least * 1e3:g} to {most * 1e3:g} mm")
        modulus, _ = self._model.modulus(radius, min(max(stretch, least), most))
        factor: float = hertz_force(shape, 1.0, modulus, radius=radius)
        power = 1.5 if shape == "sphere" else 1.0
        return lambda depth: (factor * depth**power, power * factor * depth ** (power - 1))
