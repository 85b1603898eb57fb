"""Perception: plain numerics on depth images and points, SI units, each estimate with its standard deviation.

Importing this package costs nothing; a name imports its module when it is first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from stretch_bt.perception.average import average_frames as average_frames
    from stretch_bt.perception.cap import fit_contact_sphere as fit_contact_sphere
    from stretch_bt.perception.cone import fit_cone as fit_cone
    from stretch_bt.perception.contact import find_contact as find_contact
    from stretch_bt.perception.curvature import Curvatures as Curvatures
    from stretch_bt.perception.curvature import brand as brand
    from stretch_bt.perception.curvature import curvatures as curvatures
    from stretch_bt.perception.cylinder import fit_cylinder as fit_cylinder
    from stretch_bt.perception.deprojection import deproject as deproject
    from stretch_bt.perception.deprojection import to_membrane as to_membrane
    from stretch_bt.perception.deprojection import view_rays as view_rays
    from stretch_bt.perception.detect import ContactDetector as ContactDetector
    from stretch_bt.perception.height import top_of_points as top_of_points
    from stretch_bt.perception.height import track_height as track_height
    from stretch_bt.perception.io import load_depth_png as load_depth_png
    from stretch_bt.perception.io import load_depth_stack as load_depth_stack
    from stretch_bt.perception.mask import mask_membrane as mask_membrane
    from stretch_bt.perception.noise_area import SurfaceNoise as SurfaceNoise
    from stretch_bt.perception.noise_area import surface_noise as surface_noise
    from stretch_bt.perception.normals import estimate_normals as estimate_normals
    from stretch_bt.perception.plane import fit_plane as fit_plane
    from stretch_bt.perception.segmentation import Segmentation as Segmentation
    from stretch_bt.perception.segmentation import classify as classify
    from stretch_bt.perception.segmentation import segment as segment
    from stretch_bt.perception.shape import fit_shape as fit_shape
    from stretch_bt.perception.sphere import fit_sphere as fit_sphere
    from stretch_bt.perception.tracker import HeightTracker as HeightTracker
    from stretch_bt.perception.types import Candidate as Candidate
    from stretch_bt.perception.types import Cone as Cone
    from stretch_bt.perception.types import Contact as Contact
    from stretch_bt.perception.types import Cylinder as Cylinder
    from stretch_bt.perception.types import Plane as Plane
    from stretch_bt.perception.types import Shape as Shape
    from stretch_bt.perception.types import Sphere as Sphere

_MODULES = {
    "Candidate": "types",
    "Cone": "types",
    "Contact": "types",
    "ContactDetector": "detect",
    "Curvatures": "curvature",
    "Cylinder": "types",
    "HeightTracker": "tracker",
    "Plane": "types",
    "Segmentation": "segmentation",
    "Shape": "types",
    "Sphere": "types",
    "SurfaceNoise": "noise_area",
    "average_frames": "average",
    "brand": "curvature",
    "classify": "segmentation",
    "curvatures": "curvature",
    "deproject": "deprojection",
    "estimate_normals": "normals",
    "find_contact": "contact",
    "fit_cone": "cone",
    "fit_contact_sphere": "cap",
    "fit_cylinder": "cylinder",
    "fit_plane": "plane",
    "fit_shape": "shape",
    "fit_sphere": "sphere",
    "load_depth_png": "io",
    "load_depth_stack": "io",
    "mask_membrane": "mask",
    "segment": "segmentation",
    "surface_noise": "noise_area",
    "to_membrane": "deprojection",
    "top_of_points": "height",
    "track_height": "height",
    "view_rays": "deprojection",
}
__all__ = [
    "Candidate",
    "Cone",
    "Contact",
    "ContactDetector",
    "Curvatures",
    "Cylinder",
    "HeightTracker",
    "Plane",
    "Segmentation",
    "Shape",
    "Sphere",
    "SurfaceNoise",
    "average_frames",
    "brand",
    "classify",
    "curvatures",
    "deproject",
    "estimate_normals",
    "find_contact",
    "fit_cone",
    "fit_contact_sphere",
    "fit_cylinder",
    "fit_plane",
    "fit_shape",
    "fit_sphere",
    "load_depth_png",
    "load_depth_stack",
    "mask_membrane",
    "segment",
    "surface_noise",
    "to_membrane",
    "top_of_points",
    "track_height",
    "view_rays",
]


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)


def __dir__() -> list[str]:
    return list(__all__)
