"""Rigid bodies that press on the membrane, one file a shape."""
