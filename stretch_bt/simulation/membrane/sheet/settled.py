"""When a press has been solved well enough."""

from __future__ import annotations

import numpy as np

from stretch_bt.simulation.membrane.sheet.newton import NewtonStep

__all__ = ["StepTest"]

_LEFT = 1e-3  # residual of a press that is not exact on the default mesh: of the force, of the offset per depth
_LOOSEST = 2.0
_CORRECTED = 0.5  # a correction is followed by one step more, which wants a good start
_EXACT = 1e-4
_BALANCE = 1e-7
_LIMIT, _LIMIT_EXACT = 5e-2, 1e-3  # change of the limits of friction between passes


class StepTest:
    """Whether a step was the last: by its size, by the energy left, and where exact also by the balance of forces.

    The energy clause matters: slack corners creep for tens of iterations and change no force. `depth` is in sheet units,
    `scale` is the mesh's: the residual shall not spoil a finer mesh, and need not be less than a coarse one's error.
    """

    def __init__(self, depth: float, scale: float, *, exact: bool, corrected: bool) -> None:
        self.depth, self.exact = depth, exact
        self.left = _LEFT * (_CORRECTED if corrected and not exact else min(_LOOSEST, scale**2))
        self.offset = _EXACT if exact else 2 * _CORRECTED * _LEFT if corrected else self.left
        self.small = 2 * self.left * min(1.0, depth)

    def __call__(self, step: NewtonStep) -> bool:
        """Return whether to stop after a step."""
        force, before = step.after.force[2], step.before.force[2]
        calm = abs(force - before) < self.left * abs(force)
        little = -step.promise < 0.03 * self.left * abs(force) * max(self.depth, 1.0)
        settled = step.size < self.small or (calm and (step.size < 10 * self.small or little))
        if not settled or not self.exact:
            return bool(settled)
        left = step.after.gradient[1:-1].sum(axis=(0, 1))
        return bool(np.linalg.norm(left) <= _BALANCE * np.linalg.norm(step.after.force))

    def passes(self, change: float, limit_change: float) -> bool:
        """Whether offsets that changed by as much, and limits of friction by that part, need no other pass."""
        return change < self.offset * self.depth and limit_change < (_LIMIT_EXACT if self.exact else _LIMIT)
