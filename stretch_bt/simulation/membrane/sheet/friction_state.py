"""The friction of bodies in a solve: taken over from before, renewed between passes, and accounted for."""

from __future__ import annotations

from dataclasses import replace

from stretch_bt.simulation.membrane.sheet.friction import FrictionMemory, LaggedFriction, remember
from stretch_bt.simulation.membrane.sheet.problem import Problem
from stretch_bt.simulation.membrane.sheet.result import SheetPress
from stretch_bt.simulation.membrane.sheet.spline import Array

__all__ = ["frictions", "resume", "settle", "without_friction"]


def resume(problem: Problem, past: SheetPress, coefficient: float) -> None:
    """Let the friction of each body go on from its memory."""
    x, y = problem.mesh.touch
    places = past.shape.mesh.evaluate(past.shape.control, x.place.ravel(), y.place.ravel())
    for contact, old, held in zip(problem.contacts, past.contacts, past.memory.frictions, strict=True):
        contact.friction = LaggedFriction.after(
            held.on(past.shape.mesh, problem.mesh), places, old.body, contact, coefficient, problem.unit
        )


def without_friction(result: SheetPress, problem: Problem) -> SheetPress:
    """Take the energy that friction has used up out of the energy."""
    used = sum(
        c.friction.energy(result.shape.control, problem.mesh) for c in problem.contacts if c.friction is not None
    )
    energy = result.energy - used * result.sheet.force_unit * result.sheet.unit
    return replace(result, energy=energy)


def settle(problem: Problem, control: Array) -> tuple[list[LaggedFriction | None], float]:
    """Return friction under the pressures of a solved shape, and the largest change of its limits."""
    renewed, changes = [], [0.0]
    for contact in problem.contacts:
        friction = contact.friction
        if friction is not None:
            friction, change = friction.renewed(control, problem.mesh, contact, problem.unit)
            changes.append(change)
        renewed.append(friction)
    return renewed, max(changes)


def frictions(problem: Problem, control: Array) -> tuple[FrictionMemory, ...]:
    """Return the memory of a solved shape for the next press."""
    return tuple(remember(control, problem.mesh, contact, problem.unit) for contact in problem.contacts)
