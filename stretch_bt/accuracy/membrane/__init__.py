"""The points of the domain `membrane`."""
