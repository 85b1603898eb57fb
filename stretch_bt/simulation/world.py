"""The simulated world: what a scene comes to when the hand stands somewhere, worked out when somebody looks."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stretch_bt.errors import NoEquilibrium
from stretch_bt.frames import Pose
from stretch_bt.simulation.coupling import couple
from stretch_bt.simulation.membrane.hertz import HertzMembrane
from stretch_bt.simulation.membrane.surface import Surface
from stretch_bt.simulation.objects import make_object
from stretch_bt.simulation.scene import Scene

__all__ = ["Contact", "Sheet", "World"]


@dataclass(frozen=True, slots=True)
class Sheet:
    """Rest length between the fingers and width of the membrane, m."""

    gauge: float = 0.100
    width: float = 0.090


@dataclass(frozen=True, slots=True)
class Contact:
    """How membrane and object stand: lengths in m, the force in N; all 0 while they do not touch.

    `axis` is where the object's axis pierces the membrane, membrane frame x and y.
    """

    depth: float
    drop: float
    force: float
    axis: tuple[float, float]


class World:
    """A scene and a hand over it; a pure function of the hand's pose and stretch, as nothing in it has memory."""

    def __init__(self, scene: Scene, sheet: Sheet | None = None) -> None:
        self.scene = scene
        self.sheet = sheet or Sheet()
        self.object = make_object(scene)
        self._membrane = HertzMembrane()
        self._asked: tuple[Pose, float] | None = None
        self._contact = Contact(0.0, 0.0, 0.0, (0.0, 0.0))

    def contact(self, pose: Pose, stretch: float) -> Contact:
        """Return how membrane and object stand; solved once for each new pose and stretch.

        Raises
        ------
        NoEquilibrium
            The hand is tilted, the object meets the membrane's border, or it would be pressed flat; what was solved
            before stays.
        """
        if self._asked != (pose, stretch):
            self._contact = self._solve(pose, stretch)
            self._asked = (pose, stretch)
        return self._contact

    def surface(self, contact: Contact) -> Surface | None:
        """Return the shape of the membrane around the object's axis, or None while it is flat."""
        return self.object.surface(contact.depth, self.sheet.width / 2) if contact.depth > 0 else None

    def truth(self, pose: Pose, stretch: float) -> dict[str, float]:
        """Return what a perfect observer would report, SI; a rigid object has no stiffness.

        `height` is that of the object's top and `contact_height` that of the hand at first contact.
        """
        contact = self.contact(pose, stretch)
        known = {
            "force": contact.force,
            "deflection": contact.drop,
            "stretch": stretch,
            "depth": contact.depth,
            "height": self.object.top - contact.drop,
            "contact_height": self.object.top,
        }
        if math.isfinite(self.object.reach):
            known["radius"] = self.object.radius
        if self.object.compliance > 0:
            known["stiffness"] = 1 / self.object.compliance
        return known

    def _solve(self, pose: Pose, stretch: float) -> Contact:
        axis = self._axis(pose)
        travel = self.object.top - pose.height
        if travel <= 0 or not self._covers(axis, stretch):
            return Contact(0.0, 0.0, 0.0, axis)
        law = self._membrane.law(self.object.shape, self.object.radius, stretch)
        found = couple(law, self.object.compliance, travel)
        if found.drop >= self.object.top - self.object.base:
            raise NoEquilibrium(f"{found.force:.3g} N would press the object flat")
        return Contact(found.depth, found.drop, found.force, axis)

    def _axis(self, pose: Pose) -> tuple[float, float]:
        rotation = pose.matrix()
        if rotation[2, 2] < 1 - 1e-9:
            raise NoEquilibrium("hertz fidelity has no answer for a tilted hand")
        place = self.scene.object.position
        offset = np.array([place.x - pose.position[0], place.y - pose.position[1]])
        x, y = rotation[:2, :2].T @ offset
        return float(x), -float(y)  # the membrane frame's y is reversed

    def _covers(self, axis: tuple[float, float], stretch: float) -> bool:
        """Tell whether the object stands under the membrane, or beside it; raises NoEquilibrium in between."""
        if math.isinf(self.object.reach):
            return True
        borders = (self.sheet.width / 2, (self.sheet.gauge + stretch) / 2)
        if all(abs(a) <= border for a, border in zip(axis, borders, strict=True)):
            return True
        if any(abs(a) > border + self.object.reach for a, border in zip(axis, borders, strict=True)):
            return False
        raise NoEquilibrium("the object's axis is past the membrane's border, where hertz fidelity has no answer")
