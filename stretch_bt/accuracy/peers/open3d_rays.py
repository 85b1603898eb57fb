"""Open3D's ray casting: the surface as triangles between points of a grid."""

from __future__ import annotations

from typing import Any

import numpy as np

__all__ = ["NAME", "PACKAGES", "depth"]

NAME, PACKAGES = "Open3D", ("open3d",)


def depth(points: Any, lens: Any, distance: float) -> Any:
    """Return the depth (h, w), m, of points (rows, columns, 3), m, membrane frame, seen from `distance`, m; 0 where there is nothing."""
    import open3d

    rows, columns = points.shape[:2]
    first = np.arange(rows * columns).reshape(rows, columns)[:-1, :-1].ravel()
    corners = np.concatenate(
        [
            np.stack([first, first + 1, first + columns], 1),
            np.stack([first + 1, first + columns + 1, first + columns], 1),
        ]
    )
    vertices = points.reshape(-1, 3) * [1.0, 1.0, -1.0] + [0.0, 0.0, distance]
    scene = open3d.t.geometry.RaycastingScene(nthreads=1)
    scene.add_triangles(vertices.astype(np.float32), corners.astype(np.uint32))
    x = (np.arange(lens.width) - lens.cx) / lens.fx
    y = (np.arange(lens.height) - lens.cy) / lens.fy
    u, v = np.meshgrid(x, y)
    rays = np.stack([np.zeros_like(u)] * 3 + [u, v, np.ones_like(u)], axis=-1).astype(np.float32)
    hit = scene.cast_rays(rays, nthreads=1)["t_hit"].numpy()
    return np.where(np.isfinite(hit), hit, 0.0)
