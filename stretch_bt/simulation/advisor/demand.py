"""A scene for a run that asks for a tolerance."""

from __future__ import annotations

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.advisor.choose import choose
from stretch_bt.simulation.advisor.told import refusal
from stretch_bt.simulation.scene import Scene
from stretch_bt.simulation.scene.sections import Tolerance

__all__ = ["demand"]


def demand(scene: Scene, asked: Tolerance | None) -> Scene:
    """Return the scene with the tolerance that a run asks for; as it is where none is asked for.

    Raises
    ------
    InvalidInput
        No choice of effects and settings reaches it; the message names the best that can be had. A tolerance that the scene alone
        states refuses nothing.
    """
    if asked is None:
        return scene
    made = scene.tolerating(asked)
    chosen = choose(made)
    if not all(chosen.predicted[name].within for name in made.asked):
        raise InvalidInput(refusal(made, chosen))
    return made
