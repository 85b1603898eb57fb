"""A solid whose shape is in a mesh file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from pydantic import Field

from stretch_bt.simulation.objects.base import Holds, Rough
from stretch_bt.simulation.objects.solid import SolidSpec
from stretch_bt.units import Length
from stretch_bt.within import Within

if TYPE_CHECKING:
    from stretch_bt.simulation.membrane.indenters.polyhedron import Polyhedron

__all__ = ["MeshObject"]

FLAT = 1e-3  # share of an extent within which corners are as high, and reach as far


class MeshObject(SolidSpec):
    """A solid whose shape is in a mesh file, z up, as it stands on the table; its axis is the middle of its outline."""

    type: Literal["mesh"]
    file: str = Field(min_length=1, examples=["part.stl"], description="STL, OBJ, PLY ...; relative to the scene file")
    unit: Annotated[Length, Within(1e-6, 1.0, "Length")] = Field(
        default=0.001, description="length of one unit in the file"
    )
    edge: Annotated[Length, Within(0.00005, 0.010, "Length")] = Field(
        default=0.0005, description="radius of its edges; it must be twice as thick everywhere"
    )

    def located(self, folder: Path) -> MeshObject:
        """Return the object with its file found from a folder, and read.

        Raises
        ------
        InvalidInput
            The file cannot be read, holds no closed surface, or is too thin somewhere.
        MissingExtra
            trimesh is not installed.
        """
        found = self.model_copy(update={"file": str(folder / self.file)})
        found.body()
        return found

    @property
    def _size(self) -> tuple[float, float, float]:
        """Extent along x, y and z, m."""
        x, y, z = (self.body().vertices.max(axis=0) - self.body().vertices.min(axis=0)).tolist()
        return x, y, z

    @property
    def top(self) -> float:
        """World height of its highest point, m."""
        body = self.body()
        return self.base + self._size[2] - body.sunk

    @property
    def reach(self) -> float:
        """How far its outline reaches from its middle, m."""
        x, y, _ = self._size
        return float((x * x + y * y) ** 0.5) / 2

    def body(self) -> Polyhedron:
        """Return its surface with rounded edges."""
        from stretch_bt.simulation.membrane.indenters.mesh_file import load_mesh

        return load_mesh(Path(self.file), self.unit, self.edge)

    def rough(self) -> Rough:
        """Return the radius of its top, or of the fillet where that is a point, and its stiffness."""
        body = self.body()
        holds: Holds = "rim" if body.tip_radius > self.edge else "ridge" if body.flat else "point"
        return Rough(body.tip_radius, self.roughly, edge=self.edge, face=body.flat, holds=holds)

    def known(self) -> dict[str, float]:
        """Return its height, m, its extent along x and y, m, where its top spans all of it, and its stiffness, N/m.

        The extent of a foot, or of a bulge, is one that a press from above need not feel: the scene's `dimensions` say what it feels.
        """
        known = {"height": self.top - self.base, **super().known()}
        across = dict(zip(("length", "width"), self._size, strict=False))
        return {**across, **known} if self._is_upright else known

    @property
    def _is_upright(self) -> bool:
        """Whether its highest corners reach as far along x and y as all of them."""
        corners = self.body().vertices
        high = corners[corners[:, 2] > corners[:, 2].max() - FLAT * self._size[2]]
        return bool(np.abs(np.ptp(high, axis=0) - self._size)[:2].max() < FLAT * max(self._size))
