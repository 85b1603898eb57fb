"""Presses of the finite-strain sheet as a depth camera sees them: what perception is measured against."""
