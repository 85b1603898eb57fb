"""The sphere under a contact: cap and skirt together say where the membrane leaves it, the cap alone how round it is."""

from __future__ import annotations

import numpy as np

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.shapes.rim import find_rim
from stretch_bt.perception.shapes.sphere import fit_sphere
from stretch_bt.perception.types import Contact, FloatArray, Sphere, SurfaceNoise

__all__ = ["fit_contact_sphere"]

INSIDE = 0.9  # share of the rim's size within which the membrane touches, whatever its skirt is like
CELLS = 500  # that the cap is averaged in


def fit_contact_sphere(contact: Contact) -> Sphere:
    """Fit a sphere to what of a contact's surface touches it for certain, by the skirt around it.

    The segmentation only says where to look; the sphere is fitted within nine tenths of the rim that `find_rim` finds.

    Raises
    ------
    IllConditioned
        As for `fit_sphere`, or the surface is concave.
    """
    points, rays, noise = _touching(contact)
    sphere = fit_sphere(points, rays=rays, noise=noise)
    if sphere.curvature < 0.0:
        raise IllConditioned("the surface is concave where the contact should be: nothing round is pressed into it")
    return sphere


def _touching(contact: Contact) -> tuple[FloatArray, FloatArray, SurfaceNoise]:
    """Return means (n, 3) of what touches for certain, their rays and noise; points as segmented where no skirt shows."""
    try:
        rim = find_rim(contact)
    except IllConditioned:
        return contact.points, contact.rays, contact.surface_noise
    blocks = rim.blocks(contact.surface, INSIDE, CELLS)
    points = blocks[:, :3].astype(contact.surface.dtype)  # with the resolution of the pixels
    ray = contact.rays.mean(axis=0, keepdims=True)
    return (
        points,
        np.broadcast_to(ray, points.shape),
        contact.surface_noise.of_means(float(blocks[:, 3].sum()) / max(len(blocks), 1)),
    )
