"""The twin's depth camera: how far its images are off the surface that it sees."""
