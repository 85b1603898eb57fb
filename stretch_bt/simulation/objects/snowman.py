"""Round domes in a row, as a snowman that lies on its back."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from stretch_bt.simulation.objects.base import Rough
from stretch_bt.simulation.objects.solid import SolidSpec
from stretch_bt.units import Length
from stretch_bt.within import Within

if TYPE_CHECKING:
    from stretch_bt.simulation.membrane.indenters.several import Several

__all__ = ["SnowmanObject"]

_Diameter = Annotated[Length, Within(0.004, 0.1, "Length")]


class SnowmanObject(SolidSpec):
    """Half-spheres on the table in a row along x, the first one leftmost; each dips into the next by `overlap`."""

    type: Literal["snowman"]
    diameters: Annotated[list[_Diameter], Field(min_length=1, max_length=10)] = Field(
        description="diameters of the domes, in their order"
    )
    overlap: Annotated[Length, Within(0.0, 0.002, "Length")] = Field(default=0.0, description="neighbours' overlap")

    @property
    def _radii(self) -> list[float]:
        return [d / 2 for d in self.diameters]

    @property
    def _length(self) -> float:
        return sum(self.diameters) - self.overlap * (len(self.diameters) - 1)

    @property
    def places(self) -> list[float]:
        """Where the middles of the domes lie on x, m; the middle of the whole is at 0."""
        left, found = -self._length / 2, []
        for diameter in self.diameters:
            found.append(left + diameter / 2)
            left += diameter - self.overlap
        return found

    @property
    def top(self) -> float:
        """World height of the highest dome, m."""
        return self.base + max(self._radii)

    @property
    def reach(self) -> float:
        """Half its length, m."""
        return self._length / 2

    def body(self) -> Several:
        """Return half-spheres on shanks."""
        from stretch_bt.simulation.membrane.indenters.several import Part, Several
        from stretch_bt.simulation.membrane.indenters.sphere import Sphere

        highest = max(self._radii)
        pairs = zip(self._radii, self.places, strict=True)
        return Several(tuple(Part(Sphere(2 * r), (x, 0.0), highest - r) for r, x in pairs))

    def rough(self) -> Rough:
        """Return the radius of the largest dome, and its stiffness."""
        return Rough(max(self._radii), self.roughly, edge=min(self._radii))

    def known(self) -> dict[str, float]:
        """Return its length, width, height, the radius of its largest dome and of each, the largest first, m; its stiffness, N/m."""
        r = max(self._radii)
        each = {f"radius_{k}": radius for k, radius in enumerate(sorted(self._radii, reverse=True), 1)}
        return {"length": self._length, "width": 2 * r, "height": r, "radius": r, **each, **super().known()}
