"""Clouds of points from many contacts, and what they say of an object."""
