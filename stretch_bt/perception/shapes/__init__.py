"""Shapes fitted to points whose noise lies along the camera rays."""
