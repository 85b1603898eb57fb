"""A motion of the hand that stops at a limit of force."""

from __future__ import annotations

from stretch_bt.behaviors._force_limit import ForceLimit
from stretch_bt.behaviors._motion import MotionBehavior
from stretch_bt.tree.ports import Status

__all__ = ["LimitedMotion"]


class LimitedMotion(MotionBehavior):
    """A node whose `start` makes `limit`; FAILURE, with the reason, when the force exceeds it."""

    limit: ForceLimit

    def arrived(self) -> Status:
        """Look at the force once more."""
        return self.watch() or Status.SUCCESS

    def watch(self) -> Status | None:
        """Stop at the limit of force."""
        passed = self.limit.passed()
        if passed is None:
            return None
        self.reason = passed
        return Status.FAILURE
