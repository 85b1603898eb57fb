"""How old a reading may be, s, for those who go by it: one name and one reason for each age.

A reading comes late by a period of its device, by its way to this machine and by the tick that asks for it. Each age allows for several
of these, so that one reading that is missed ends no run, and a device that fell silent does.
"""

from __future__ import annotations

from typing import Final

__all__ = ["EXPRESSION_FORCE", "FORCE", "FRAME", "PLACE", "PRESSING_PLACE", "UNHEARD"]

#: a force that a limit is held by, or that is averaged: it rises quickly, for at 10 mm/s the hand goes on by 2 mm in this time
FORCE: Final = 0.2
#: a force in an expression of a tree, as docs/tree-language.md states it
EXPRESSION_FORCE: Final = 0.25
#: the pose or the opening of a hand that stands, or moves free of the object
PLACE: Final = 0.5
#: the pose of a hand that goes down to the object, presses it or comes off it: depths and forces are measured there
PRESSING_PLACE: Final = 0.2
#: a depth frame: a camera at 5 Hz or more passes
FRAME: Final = 0.5
#: how long an arm that moves may say nothing new of its force or its pose before it is stopped; a force that only shows an obstacle
UNHEARD: Final = 0.5
