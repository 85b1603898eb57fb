"""Fits of shapes to points, and of spheres to contacts."""

from stretch_bt.hardcases.domains.fits import contacts, shapes, spheres, surfaces

__all__ = ["CASES"]

CASES = (*shapes.CASES, *spheres.CASES, *contacts.CASES, *surfaces.CASES)
