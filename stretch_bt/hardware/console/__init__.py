"""Devices that are people, asked on the terminal."""
