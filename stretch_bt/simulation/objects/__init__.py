"""The objects of the twin: where their top stands, how they give way, and what the membrane meets of them."""

from __future__ import annotations

from typing import Protocol

from stretch_bt.simulation.membrane.surface import Surface
from stretch_bt.simulation.objects.cylinder import Cylinder
from stretch_bt.simulation.objects.plane import Plane
from stretch_bt.simulation.objects.sphere import Sphere
from stretch_bt.simulation.scene import CylinderObject, PlaneObject, Scene, SphereObject

__all__ = ["Solid", "make_object"]


class Solid(Protocol):
    """An object that the membrane is pressed on from above; lengths in m."""

    @property
    def shape(self) -> str:
        """The Hertz form that it has."""
        ...

    @property
    def radius(self) -> float:
        """The radius that goes into the Hertz form."""
        ...

    @property
    def top(self) -> float:
        """World height of the undeformed top."""
        ...

    @property
    def base(self) -> float:
        """World height of the lowest point."""
        ...

    @property
    def compliance(self) -> float:
        """Height lost per force, m/N; 0 when rigid."""
        ...

    @property
    def reach(self) -> float:
        """How far from its axis it reaches."""
        ...

    def surface(self, depth: float, span: float) -> Surface:
        """Return the membrane, held flat at radius `span`, sunk in by `depth`; raises NoEquilibrium."""
        ...


def make_object(scene: Scene) -> Solid:
    """Return the object of a scene."""
    given = scene.object
    compliance = 0.0 if given.stiffness is None else 1 / given.stiffness
    match given:
        case SphereObject():
            return Sphere(given.diameter / 2, given.base, compliance)
        case CylinderObject():
            return Cylinder(given.diameter / 2, given.base + given.height, given.base, compliance)
        case PlaneObject():
            return Plane(given.base + given.height, given.base, compliance)
