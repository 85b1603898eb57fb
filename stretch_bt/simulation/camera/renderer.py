"""The depth image of the membrane and of the table beside it, without a real camera's errors."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.frames import Intrinsics
from stretch_bt.simulation.camera.skin import Grid, Plane, RoundBump, Skin
from stretch_bt.simulation.camera.view import RIGHT, CameraView, Offset

__all__ = ["DepthRenderer"]

Image = npt.NDArray[np.float32]
_SAMPLES = 2048
_ROWS, _COLUMNS = 2, 3  # rows and columns that continue a surface at each end and side
_BLIND = 0.010  # m; a membrane that comes as near as this covers the lens


class DepthRenderer:
    """Renders depth along the optical axis, (h, w) float32, m; 0 is no value.

    `intrinsics` are the lens's through which the scene is seen, `plane_distance`, m, is the assumed distance of the flat
    membrane, and `offset` says how the camera really stands. The table shows beside the free sides of the sheet; its ends hide
    under the fingers, which give no value. A camera that the membrane comes nearer to than 10 mm sees nothing at all.
    """

    def __init__(self, intrinsics: Intrinsics, plane_distance: float, offset: Offset = RIGHT) -> None:
        self.view = CameraView(intrinsics, plane_distance, offset)
        self._work: npt.NDArray[np.float64] = np.empty((5, 0, 0))
        self._seen: tuple[Skin, Image, bool] | None = None

    def render(self, skin: Skin, table: Plane | None = None) -> Image:
        """Return the depth (h, w) float32, m, of a membrane and of the table, or of nothing, behind it.

        A membrane that was the last one rendered is not rendered again, only the table.

        Raises
        ------
        InvalidInput
            The skin is no surface.
        """
        if self._seen is None or self._seen[0] is not skin:
            self._seen = (skin, *self._membrane(skin))
        _, alone, sees = self._seen
        image = alone.copy()
        if sees and table is not None:
            self._beside(skin, table, image)
        return image

    def _membrane(self, skin: Skin) -> tuple[Image, bool]:
        """Return the depth of the membrane alone, and whether the camera sees anything."""
        image: Image = np.zeros((self.view.intrinsics.height, self.view.intrinsics.width), np.float32)
        if image.size == 0:
            return image, False
        return image, self._grid(skin, image) if isinstance(skin, Grid) else self._profile(skin, image)

    def _grid(self, skin: Grid, image: Image) -> bool:
        from stretch_bt.simulation.camera.fold_kernel import look_through
        from stretch_bt.simulation.camera.view_kernel import look

        maps = self.view.project(_continued(skin.points))
        if maps[2, _ROWS:-_ROWS, _COLUMNS:-_COLUMNS].min() < _BLIND:
            return False
        shape = (5, maps.shape[1], image.shape[1])
        if self._work.shape != shape:
            self._work = np.empty(shape)
        column, row, depth = maps
        if not look(column, row, depth, self._work, image):
            image[:] = 0.0
            look_through(column, row, depth, _ROWS, _COLUMNS, image)
        return True

    def _profile(self, skin: RoundBump, image: Image) -> bool:
        from stretch_bt.simulation.camera.profile_kernel import look_at_profile

        place, surface = self.view.place, skin.surface
        level = surface.depth if surface is not None and math.isinf(surface.span) else 0.0
        heights, scale = np.full(2, level), 1.0
        if surface is not None and math.isfinite(surface.span):
            scale = _SAMPLES / surface.span
            heights = surface.height(np.arange(_SAMPLES + 1) / scale)
        if place[2] - heights[0] < _BLIND:
            return False
        from_axis = np.array([place[0] - skin.axis[0], place[1] - skin.axis[1], place[2], *skin.axis])
        half = skin.width / 2, skin.length / 2
        look_at_profile(*self.view.rays, self.view.turn, from_axis, heights, scale, level, *half, image)
        return True

    def _beside(self, skin: Skin, table: Plane, image: Image) -> None:
        from stretch_bt.simulation.camera.profile_kernel import look_beside

        view = self.view
        look_beside(*view.rays, view.turn, view.place, np.array(table.normal), float(table.offset), *skin.ends, image)


def _continued(points: npt.NDArray[Any]) -> npt.NDArray[np.float64]:
    """Return points (rows + 4, columns + 6, 3) that go on beyond each border as parabolas."""
    rows, columns, _ = points.shape
    out = np.empty((rows + 2 * _ROWS, columns + 2 * _COLUMNS, 3))
    out[_ROWS:-_ROWS, _COLUMNS:-_COLUMNS] = points
    for i in range(_COLUMNS - 1, -1, -1):
        inner = out[_ROWS:-_ROWS]
        inner[:, i] = 3 * (inner[:, i + 1] - inner[:, i + 2]) + inner[:, i + 3]
        inner[:, -1 - i] = 3 * (inner[:, -2 - i] - inner[:, -3 - i]) + inner[:, -4 - i]
    for j in range(_ROWS - 1, -1, -1):
        out[j] = 3 * (out[j + 1] - out[j + 2]) + out[j + 3]
        out[-1 - j] = 3 * (out[-2 - j] - out[-3 - j]) + out[-4 - j]
    return out
