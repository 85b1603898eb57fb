"""Presses of the finite-strain sheet as a depth camera sees them: the reference for perception."""
