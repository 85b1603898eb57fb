"""Recorded frames and readings, played against the clock."""
