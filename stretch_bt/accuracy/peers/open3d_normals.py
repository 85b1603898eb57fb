"""Open3D's normals: a plane through the neighbours of each point."""

from __future__ import annotations

from typing import Any

import numpy as np

__all__ = ["NAME", "PACKAGES", "RADII", "normals"]

NAME, PACKAGES = "Open3D", ("open3d",)
RADII = (2e-3, 4e-3)  # m
_MOST = 200  # neighbours


def normals(points: Any, valid: Any, radius: float) -> Any:
    """Return normals (h, w, 3) of points (h, w, 3), m, membrane frame, from neighbours within a radius, m; NaN where not valid."""
    import open3d

    cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points[valid].astype(float)))
    cloud.estimate_normals(open3d.geometry.KDTreeSearchParamHybrid(radius=radius, max_nn=_MOST))
    cloud.orient_normals_to_align_with_direction(np.array([0.0, 0.0, 1.0]))
    found = np.full(points.shape, np.nan)
    found[valid] = np.asarray(cloud.normals)
    return found
