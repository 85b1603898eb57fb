"""Estimates of the object from force and height, and where to press next."""
