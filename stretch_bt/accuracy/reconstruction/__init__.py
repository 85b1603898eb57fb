"""Reconstructions in the twin against the surface that the scene has."""
