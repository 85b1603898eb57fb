"""Outlines of flat objects: area, perimeter and circularity."""
