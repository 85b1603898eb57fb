"""The limit of wall time of an item, looked at as each tick begins."""

from __future__ import annotations

import math
import time
from typing import Any

from stretch_bt.runtime.onlooker import Onlooker
from stretch_bt.runtime.runner import Runner

__all__ = ["WallLimit"]


class WallLimit(Onlooker):
    """Stops a run safely once its time, s, is over; None is no limit. The time begins when this is made."""

    def __init__(self, limit: float | None) -> None:
        self._until = time.perf_counter() + (math.inf if limit is None else limit)
        self._runner: Runner | None = None
        #: whether it stopped the run
        self.passed = False

    def watch(self, runner: Runner) -> None:
        """Look at this run; to be called before its first tick."""
        self._runner = runner
        runner.watchers.append(self)

    @property
    def signalled(self) -> bool:
        """Whether something else than this limit interrupted the run."""
        return self._runner is None or self._runner.interrupted_by not in ((), (_WHY,))

    def begin_tick(self, tick: int, time_: float) -> None:
        """Stop the run where its time is over, unless something else did; a second stop would cut its `finally` short."""
        if self._runner is not None and not self._runner.interrupted_by and time.perf_counter() >= self._until:
            self.passed = True
            self._runner.interrupt(_WHY)

    def note(self, kind: str, **fields: Any) -> None:
        """Let the end of the task have its time."""
        if kind == "stop":
            self._until = math.inf


_WHY = "the limit of wall time"
