"""The sphere under a contact: cap and skirt together say where the membrane leaves it, the cap alone how round it is."""

from __future__ import annotations

import math

import numpy as np

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.deprojection import view_rays
from stretch_bt.perception.shapes.rim import Rim, find_rim
from stretch_bt.perception.shapes.sight import camera_of
from stretch_bt.perception.shapes.sphere import fit_sphere
from stretch_bt.perception.types import Contact, FloatArray, Sphere, SurfaceNoise

__all__ = ["fit_contact_sphere"]

INSIDE = 0.9  # share of the rim's size within which the membrane touches, whatever its skirt is like
MOST = 15000  # points as segmented, whose errors a fit cannot tell from those of more
CELLS = 800  # that the cap is averaged in
LOST = 0.75  # of the radius of a disc that spreads as the contact does: a rim within, on whose cap no radius shows, is noise


def fit_contact_sphere(contact: Contact) -> Sphere:
    """Fit a sphere to what of a contact's surface touches it for certain, by the skirt around it.

    The segmentation only says where to look; the sphere is fitted within nine tenths of the rim that `find_rim` finds.

    Raises
    ------
    IllConditioned
        As for `fit_sphere`, or the surface is concave.
    """
    sphere = _fitted(contact)
    if sphere.curvature < 0.0:
        raise IllConditioned(
            "the surface is concave where the contact should be: nothing round is pressed into it; look whether the hand stands over"
            " the object, and press deeper"
        )
    return sphere


def _fitted(contact: Contact) -> Sphere:
    """Return the sphere of what touches for certain; of the points as segmented where no skirt shows, or noise was taken for the rim."""
    try:
        rim = find_rim(contact)
    except IllConditioned:
        return _as_segmented(contact)
    points, rays, noise = _touching(contact, rim)
    try:
        return fit_sphere(points, rays=rays, noise=noise)
    except IllConditioned:
        if max(rim.a, rim.b) > LOST * float(np.linalg.norm(contact.points[:, :2].std(axis=0))) * math.sqrt(2):
            raise
        return _as_segmented(contact)


def _as_segmented(contact: Contact) -> Sphere:
    every = -(-len(contact.points) // MOST)
    noise = SurfaceNoise(contact.noise, max(contact.noise_area / every, 1.0))
    return fit_sphere(contact.points[::every], rays=contact.rays[::every], noise=noise)


def _touching(contact: Contact, rim: Rim) -> tuple[FloatArray, FloatArray, SurfaceNoise]:
    """Return means (n, 3) of what touches for certain, their rays and noise."""
    blocks = rim.blocks(contact.surface, INSIDE, CELLS)
    points = blocks[:, :3].astype(contact.surface.dtype)  # with the resolution of the pixels
    eye = camera_of(contact.points, contact.rays)
    parallel = np.broadcast_to(contact.rays.mean(axis=0, keepdims=True), points.shape)
    rays = parallel if eye is None else view_rays(points, tuple(eye))
    return points, rays, contact.surface_noise.of_means(float(blocks[:, 3].sum()) / max(len(blocks), 1))
