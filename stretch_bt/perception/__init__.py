"""Perception: plain numerics on depth images and points, SI units, each estimate with its standard deviation.

Importing this package costs nothing; a name imports its module when it is first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from stretch_bt.frames import DepthFrame as DepthFrame
    from stretch_bt.frames import Intrinsics as Intrinsics
    from stretch_bt.frames import Pose as Pose
    from stretch_bt.perception.average import average_frames as average_frames
    from stretch_bt.perception.cap import Cap as Cap
    from stretch_bt.perception.cap import cap_of as cap_of
    from stretch_bt.perception.cap import cap_residual as cap_residual
    from stretch_bt.perception.clouds.cloud import Cloud as Cloud
    from stretch_bt.perception.clouds.cloud import cloud_of as cloud_of
    from stretch_bt.perception.clouds.dimensions import Dimensions as Dimensions
    from stretch_bt.perception.clouds.dimensions import measure_object as measure_object
    from stretch_bt.perception.clouds.fuse import fuse_contact as fuse_contact
    from stretch_bt.perception.clouds.picture import draw_cloud as draw_cloud
    from stretch_bt.perception.contact import find_contact as find_contact
    from stretch_bt.perception.curvature import Curvatures as Curvatures
    from stretch_bt.perception.curvature import brand as brand
    from stretch_bt.perception.curvature import curvatures as curvatures
    from stretch_bt.perception.deprojection import deproject as deproject
    from stretch_bt.perception.deprojection import to_membrane as to_membrane
    from stretch_bt.perception.deprojection import view_rays as view_rays
    from stretch_bt.perception.detect import ContactDetector as ContactDetector
    from stretch_bt.perception.drum import lift_off as lift_off
    from stretch_bt.perception.hanging import pulled_down as pulled_down
    from stretch_bt.perception.height import top_of_points as top_of_points
    from stretch_bt.perception.height import track_height as track_height
    from stretch_bt.perception.io import load_depth_png as load_depth_png
    from stretch_bt.perception.io import load_depth_stack as load_depth_stack
    from stretch_bt.perception.mask import mask_membrane as mask_membrane
    from stretch_bt.perception.noise import FrameNoise as FrameNoise
    from stretch_bt.perception.noise import PixelNoise as PixelNoise
    from stretch_bt.perception.noise import frame_noise as frame_noise
    from stretch_bt.perception.noise import pixel_noise as pixel_noise
    from stretch_bt.perception.normals import estimate_normals as estimate_normals
    from stretch_bt.perception.outlines.contact_outline import contact_outline as contact_outline
    from stretch_bt.perception.outlines.level import highest_of as highest_of
    from stretch_bt.perception.outlines.level import outline_at as outline_at
    from stretch_bt.perception.outlines.outline import Outline as Outline
    from stretch_bt.perception.outlines.outline import outline_of as outline_of
    from stretch_bt.perception.outlines.roundness import Roundness as Roundness
    from stretch_bt.perception.outlines.roundness import circularity as circularity
    from stretch_bt.perception.pattern import FreeView as FreeView
    from stretch_bt.perception.pattern import Pattern as Pattern
    from stretch_bt.perception.pattern import with_left_over as with_left_over
    from stretch_bt.perception.pattern import without_pattern as without_pattern
    from stretch_bt.perception.pressed.height import MountedMembrane as MountedMembrane
    from stretch_bt.perception.pressed.height import membrane_height as membrane_height
    from stretch_bt.perception.pressed.height import mounted_membrane as mounted_membrane
    from stretch_bt.perception.segmentation import Segmentation as Segmentation
    from stretch_bt.perception.segmentation import classify as classify
    from stretch_bt.perception.segmentation import segment as segment
    from stretch_bt.perception.shapes.cap import fit_contact_sphere as fit_contact_sphere
    from stretch_bt.perception.shapes.cone import fit_cone as fit_cone
    from stretch_bt.perception.shapes.cylinder import fit_cylinder as fit_cylinder
    from stretch_bt.perception.shapes.noise_area import surface_noise as surface_noise
    from stretch_bt.perception.shapes.plane import fit_plane as fit_plane
    from stretch_bt.perception.shapes.pooled import pooled_sphere as pooled_sphere
    from stretch_bt.perception.shapes.shape import fit_shape as fit_shape
    from stretch_bt.perception.shapes.sphere import fit_sphere as fit_sphere
    from stretch_bt.perception.size.measure import diameters as diameters
    from stretch_bt.perception.size.measure import measure_contact as measure_contact
    from stretch_bt.perception.size.result import ContactSize as ContactSize
    from stretch_bt.perception.size.result import Diameters as Diameters
    from stretch_bt.perception.size.width import contact_width as contact_width
    from stretch_bt.perception.solids.fit import fit_object as fit_object
    from stretch_bt.perception.solids.result import Dimension as Dimension
    from stretch_bt.perception.solids.result import Solid as Solid
    from stretch_bt.perception.tension import expected_ratio as expected_ratio
    from stretch_bt.perception.tension import tension_ratio as tension_ratio
    from stretch_bt.perception.tracker import HeightTracker as HeightTracker
    from stretch_bt.perception.types import Candidate as Candidate
    from stretch_bt.perception.types import Cone as Cone
    from stretch_bt.perception.types import Contact as Contact
    from stretch_bt.perception.types import Cylinder as Cylinder
    from stretch_bt.perception.types import Plane as Plane
    from stretch_bt.perception.types import Shape as Shape
    from stretch_bt.perception.types import Sphere as Sphere
    from stretch_bt.perception.types import SurfaceNoise as SurfaceNoise

_MODULES = {
    "Candidate": "types",
    "Cloud": "clouds.cloud",
    "Cone": "types",
    "Contact": "types",
    "ContactDetector": "detect",
    "ContactSize": "size.result",
    "Curvatures": "curvature",
    "Cylinder": "types",
    "DepthFrame": ".frames",  # one up, as the next two
    "Diameters": "size.result",
    "Dimension": "solids.result",
    "Dimensions": "clouds.dimensions",
    "FrameNoise": "noise",
    "FreeView": "pattern",
    "HeightTracker": "tracker",
    "Intrinsics": ".frames",
    "MountedMembrane": "pressed.height",
    "Outline": "outlines.outline",
    "Pattern": "pattern",
    "PixelNoise": "noise",
    "Plane": "types",
    "Pose": ".frames",
    "Roundness": "outlines.roundness",
    "Segmentation": "segmentation",
    "Shape": "types",
    "Solid": "solids.result",
    "Sphere": "types",
    "SurfaceNoise": "types",
    "average_frames": "average",
    "brand": "curvature",
    "Cap": "cap",
    "cap_of": "cap",
    "cap_residual": "cap",
    "circularity": "outlines.roundness",
    "classify": "segmentation",
    "cloud_of": "clouds.cloud",
    "contact_outline": "outlines.contact_outline",
    "contact_width": "size.width",
    "curvatures": "curvature",
    "deproject": "deprojection",
    "diameters": "size.measure",
    "draw_cloud": "clouds.picture",
    "estimate_normals": "normals",
    "expected_ratio": "tension",
    "find_contact": "contact",
    "fit_cone": "shapes.cone",
    "fit_contact_sphere": "shapes.cap",
    "pooled_sphere": "shapes.pooled",
    "pulled_down": "hanging",
    "fit_cylinder": "shapes.cylinder",
    "fit_object": "solids.fit",
    "fit_plane": "shapes.plane",
    "fit_shape": "shapes.shape",
    "fit_sphere": "shapes.sphere",
    "frame_noise": "noise",
    "fuse_contact": "clouds.fuse",
    "highest_of": "outlines.level",
    "lift_off": "drum",
    "load_depth_png": "io",
    "load_depth_stack": "io",
    "mask_membrane": "mask",
    "measure_contact": "size.measure",
    "measure_object": "clouds.dimensions",
    "membrane_height": "pressed.height",
    "mounted_membrane": "pressed.height",
    "outline_at": "outlines.level",
    "outline_of": "outlines.outline",
    "pixel_noise": "noise",
    "segment": "segmentation",
    "surface_noise": "shapes.noise_area",
    "tension_ratio": "tension",
    "to_membrane": "deprojection",
    "top_of_points": "height",
    "track_height": "height",
    "view_rays": "deprojection",
    "with_left_over": "pattern",
    "without_pattern": "pattern",
}
__all__ = [
    "Candidate",
    "Cap",
    "Cloud",
    "Cone",
    "Contact",
    "ContactDetector",
    "ContactSize",
    "Curvatures",
    "Cylinder",
    "DepthFrame",
    "Diameters",
    "Dimension",
    "Dimensions",
    "FrameNoise",
    "FreeView",
    "HeightTracker",
    "Intrinsics",
    "MountedMembrane",
    "Outline",
    "Pattern",
    "PixelNoise",
    "Plane",
    "Pose",
    "Roundness",
    "Segmentation",
    "Shape",
    "Solid",
    "Sphere",
    "SurfaceNoise",
    "average_frames",
    "brand",
    "cap_of",
    "cap_residual",
    "circularity",
    "classify",
    "cloud_of",
    "contact_outline",
    "contact_width",
    "curvatures",
    "deproject",
    "diameters",
    "draw_cloud",
    "estimate_normals",
    "expected_ratio",
    "find_contact",
    "fit_cone",
    "fit_contact_sphere",
    "fit_cylinder",
    "fit_object",
    "fit_plane",
    "fit_shape",
    "fit_sphere",
    "frame_noise",
    "fuse_contact",
    "highest_of",
    "lift_off",
    "load_depth_png",
    "load_depth_stack",
    "mask_membrane",
    "measure_contact",
    "measure_object",
    "membrane_height",
    "mounted_membrane",
    "outline_at",
    "outline_of",
    "pixel_noise",
    "pooled_sphere",
    "pulled_down",
    "segment",
    "surface_noise",
    "tension_ratio",
    "to_membrane",
    "top_of_points",
    "track_height",
    "view_rays",
    "with_left_over",
    "without_pattern",
]


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_MODULES[name]}", __name__), name)


def __dir__() -> list[str]:
    return list(__all__)
