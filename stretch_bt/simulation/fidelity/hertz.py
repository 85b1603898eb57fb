"""The membrane at `hertz` fidelity: closed forms for force and shape."""

from __future__ import annotations

from typing import Any

import numpy as np

from stretch_bt.errors import InvalidInput, NoEquilibrium
from stretch_bt.model.force.calibrated import CalibratedHertz
from stretch_bt.model.force.force_model import ForceModel
from stretch_bt.model.hertz import hertz_force
from stretch_bt.simulation.camera.skin import RoundBump, Skin
from stretch_bt.simulation.fidelity.base import Array, Place, Pressed
from stretch_bt.simulation.membrane.surface import Surface, pressed_surface
from stretch_bt.simulation.objects.base import HertzForm
from stretch_bt.simulation.objects.response import Law

__all__ = ["HertzFidelity"]

_POWERS = {"sphere": 1.5, "cylinder": 1.0, "plane": 1.0}


class HertzFidelity:
    """The calibrated Hertz law of a hand, for the shapes that have one.

    The force does not depend on where on the membrane the object is, and the membrane has no memory, no weight and no other
    effect; whatever the scene says of its material, it is the calibrated one.
    """

    remembers = False
    close = 1e-10

    def __init__(self, width: float, gauge: float, model: CalibratedHertz | None = None) -> None:
        chosen = ForceModel.default() if model is None else model
        if not isinstance(chosen, CalibratedHertz):
            raise InvalidInput(f"hertz fidelity needs a calibrated_hertz model, not {chosen.kind}")
        self._model = chosen
        self.width, self.gauge = width, gauge

    def law(self, place: Place, state: Any) -> Law:
        """Return the formula of Hertz at the calibrated modulus."""
        form = self._form(place)
        least, most = self._model.range.stretch
        stretch = place.stretch
        if not least - 1e-9 <= stretch <= most + 1e-9:
            raise NoEquilibrium(f"a stretch of {stretch * 1e3:.4g} mm is outside {least * 1e3:g} to {most * 1e3:g} mm")
        modulus, _ = self._model.modulus(form.radius, min(max(stretch, least), most))
        shape, power = form.kind if form.kind == "sphere" else "cylinder", _POWERS[form.kind]
        factor: float = hertz_force(shape, 1.0, modulus, radius=form.radius)
        return lambda depth: (factor * depth**power, power * factor * depth ** (power - 1))

    def press(self, place: Place, depth: float, state: Any) -> Pressed:
        """Return the profile."""
        surface = pressed_surface(self._form(place), depth, self.width / 2)
        return Pressed(self._flat(place.stretch, surface, place.at))

    def force(self, place: Place, depth: float, state: Any) -> Array:
        """Return the force, which has no part across."""
        return np.array([0.0, 0.0, self.law(place, state)(depth)[0]])

    def released(self, state: Any) -> None:
        """Return None: it remembers nothing."""

    def lift(self, place: Place) -> float:
        """Return 0: the membrane has no weight."""
        return 0.0

    def free(self, stretch: float) -> Skin:
        """Return a flat membrane."""
        return self._flat(stretch)

    def _flat(
        self, stretch: float, surface: Surface | None = None, axis: tuple[float, float] = (0.0, 0.0)
    ) -> RoundBump:
        return RoundBump(surface, axis, self.width, self.gauge + stretch)

    def _form(self, place: Place) -> HertzForm:
        if place.tilt != (0.0, 0.0):
            raise NoEquilibrium("hertz fidelity has no answer for a tilted hand")
        if place.form is None or place.form.kind not in _POWERS:
            raise NoEquilibrium("hertz fidelity has no form of this object; use the sheet")
        if place.form.kind != "plane":
            borders = (self.width / 2, (self.gauge + place.stretch) / 2)
            if any(abs(a) > border for a, border in zip(place.at, borders, strict=True)):
                raise NoEquilibrium(
                    "the object's axis is past the membrane's border, where hertz fidelity has no answer"
                )
        return place.form
