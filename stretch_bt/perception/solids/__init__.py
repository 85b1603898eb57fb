"""Solids: the shape that felt surfaces are of, and its dimensions."""
