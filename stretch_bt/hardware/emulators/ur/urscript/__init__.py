"""A part of URScript: what clients send to a controller's ports, read and run in steps of one cycle."""
