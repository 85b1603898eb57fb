"""The numbers of a scene that the closed-form estimates of effects use."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from stretch_bt.simulation.effects.base import Size
from stretch_bt.simulation.objects.base import Rough

if TYPE_CHECKING:
    from stretch_bt.simulation.scene.file import Scene

__all__ = ["DENSITY", "DROP", "GAUGE", "Case"]

_FOCAL, _DISTANCE = 476.0, 0.200  # of the SR305, pixels, and of the shipped cell, m
GAUGE, _WIDTH, _THICKNESS = 0.100, 0.090, 0.002
DENSITY = 1070.0
_LEAST = 1e-3  # strain of a sheet that nothing stretches
_BEGIN, _ROUNDS = 10e-3, 20  # m, and rounds, in which a contact under a taut sheet is found
DROP = 1.5e-3  # m, drop over which a stiffness is taken


@dataclass(frozen=True)
class Case:
    """A scene, SI; the membrane is a plane under tension, its contact a cap."""

    scene: Scene
    rough: Rough

    @property
    def frames(self) -> int:
        """Frames averaged at each press."""
        return self.scene.conditions.frames

    @property
    def depth(self) -> float:
        """The deepest press, m."""
        return self.scene.conditions.depth

    @property
    def stretch(self) -> float:
        """The lowest stretch in use, m."""
        return self.scene.conditions.stretch

    @property
    def radius(self) -> float:
        """Radius of the object's top, m, at most the radius of a flat face that fills the membrane."""
        return min(self.rough.radius, _WIDTH / 2)

    @property
    def strain(self) -> float:
        """Strain along the stretch at the lowest stretch, mounts included."""
        return (self.stretch + self.scene.hand.mount_prestretch) / GAUGE

    @property
    def taut(self) -> float:
        """Strain of the sheet in the deepest press: what it has before, or what its own weight and the press give one that is slacker.

        Both bend the sheet to a chain of two straight halves, or to a parabola, which is longer than the gauge.
        """
        pressed = math.hypot(1.0, 2 * self.depth / GAUGE) - 1
        return max(self.strain, pressed + 8 / 3 * (self.sag / GAUGE) ** 2)

    @property
    def tension(self) -> float:
        """Mean of the two principal tensions in the deepest press, N/m."""
        return self._tension(self.taut)

    def _tension(self, strain: float) -> float:
        """Return the mean of the two principal tensions, N/m, of the neo-Hookean sheet with its width held: mu H (l - 1/l^3)."""
        stretched = 1 + max(strain, _LEAST)
        along, across = stretched - stretched**-3, 1 - stretched**-2
        return self.scene.hand.shear_modulus * _THICKNESS * (along + across) / 2

    @property
    def force(self) -> float:
        """Force of the deepest press on a rigid object, N, by a membrane under tension T that is held at half its length.

        A disc of radius a that lifts it by d needs 2 pi T d / ln(L / 2 a) where all of its edge is held; half of that fits the
        sheet solver, whose sides are free, within a factor of 1.4 for points, spheres, ridges, faces and rings.
        """
        return math.pi * self.tension * self.depth / math.log(GAUGE / 2 / min(self.contact_radius, GAUGE / 4))

    @property
    def membrane_stiffness(self) -> float:
        """Slope of that force, N/m."""
        return 1.5 * self.force / self.depth

    @property
    def contact_radius(self) -> float:
        """Radius of the contact, m: a cap's radius at half the depth, at most the object's own, or the radius of its flat face."""
        return max(min(math.sqrt(self.radius * self.depth / 2), self.radius), min(self.rough.face, _WIDTH / 2))

    @property
    def held_radius(self) -> float:
        """Radius of the contact, m; over a dome or a point the radius up to which a taut sheet lies on its tip, or on its flanks."""
        rough = self.rough
        if rough.holds not in ("dome", "point"):
            return self.contact_radius
        tip, radius = self.radius if rough.holds == "dome" else rough.edge, _BEGIN
        for _ in range(_ROUNDS):
            fall = self.depth / 2 / math.log(GAUGE / 2 / min(radius, GAUGE / 4))
            radius = max(math.sqrt(tip * fall), fall / rough.steep)
        return radius

    @property
    def pixel(self) -> float:
        """Width of a pixel on the membrane, m."""
        return _DISTANCE / _FOCAL

    def from_height(self, error: float, why: str) -> Iterator[Size]:
        """Yield the change of each observable by an error of a measured height, m.

        A stiffness is a force over a drop, and both depend on the height: (1 / drop + 1.5 / depth) for a drop of 1.5 mm.
        """
        yield Size("height", error, why)
        if math.isfinite(self.rough.stiffness):
            yield Size("stiffness", error * (1 / DROP + 1.5 / self.depth), f"{why}; over a drop of 1.5 mm")

    def from_force(
        self, part: float, why: str, way: int = 0, stiffness: float | None = None, gives: float = 1.0
    ) -> Iterator[Size]:
        """Yield the change of each observable by a relative change of the membrane's force; a stiffness may change by another part.

        A soft object gives way to a stronger membrane: the force in series changes by less, by the power `gives` of one plus the ratio of
        their stiffnesses. `gives` is 1 where nothing else changes, less where a shallower press shows more of the effect, and 0
        for a way that both share.
        """
        yield Size("force", part / (1 + self.membrane_stiffness / self.rough.stiffness) ** gives, why, way)
        if math.isfinite(self.rough.stiffness):
            yield Size("stiffness", part if stiffness is None else stiffness, why)
            yield Size("height", part * self.force / (self.rough.stiffness + self.membrane_stiffness), why)

    @property
    def thickness(self) -> float:
        """Thickness of the membrane, m."""
        return _THICKNESS

    @property
    def hung(self) -> float:
        """Tension of the sheet before a press, N/m."""
        return self._tension(self.strain)

    @property
    def sag(self) -> float:
        """Sag of the membrane's middle at the lowest stretch, m: the sag of a string over the gauge, at most 6.8 mm."""
        return min(DENSITY * 9.81 * _THICKNESS * GAUGE**2 / (8 * self.hung), 0.0068)

    @property
    def weight(self) -> float:
        """Weight of the membrane, N."""
        return DENSITY * 9.81 * _THICKNESS * GAUGE * _WIDTH
