"""Pressing plastic material down to a given thickness, a step at a time."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["CLOSE", "LEAST_STEP", "MOST_STEPS", "Step", "next_step"]

CLOSE = 0.0004  # m above the wanted thickness that is as good
LEAST_STEP = 0.0003  # m
MOST_STEPS = 24


@dataclass(frozen=True, slots=True)
class Step:
    """Where the hand goes next: a world height, m, or the reason why the press ended: `thickness`, `force` or `depth`."""

    height: float
    ended: str = ""


def next_step(top: float, thickness: float, hand: float, lowest: float, *, limited: bool, steps: int) -> Step:
    """Return the next step of a press that is to leave a top at a thickness over the table, m.

    The hand at the height `hand`, m, goes down by the way that the top still has to fall, so that it comes to the thickness from above whatever
    share of the way the membrane takes; never below `lowest`, m. `limited` says that the force reached its limit in the last of `steps`.
    """
    over = top - thickness
    if over <= CLOSE:
        return Step(hand, "thickness")
    if limited:
        return Step(hand, "force")
    if steps >= MOST_STEPS or hand <= lowest + 1e-5:
        return Step(hand, "depth")
    return Step(max(hand - max(over, LEAST_STEP), lowest))
