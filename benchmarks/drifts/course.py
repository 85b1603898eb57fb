"""A run of very many steps: its memory and its CPU time a step as it goes on, and whether they stay what they were."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from statistics import median

import psutil

from stretch_bt.accuracy.yardstick import yardstick

#: a run is a hundred blocks, of which memory is compared from the tenth on; the machine's pace is taken five times in each
HUNDRED, SETTLED, LOOKS = 100, 10, 5
#: what memory may grow by from then on, and times as long that a step may take in the last tenth as in the first
GROWTH, SLOWER = 0.05, 1.1


def resident() -> float:
    """Return the resident memory of this process, MB."""
    return float(psutil.Process().memory_info().rss) / 1e6


@dataclass(frozen=True)
class Finding:
    """A figure of a run and the most that it may be; without a bound it is only reported."""

    name: str
    value: float
    bound: float | None = None

    @property
    def good(self) -> bool:
        """Whether it is within its bound; NaN never is."""
        return self.bound is None or self.value <= self.bound

    def __str__(self) -> str:
        limit = "" if self.bound is None else f"   at most {self.bound:g}"
        return f"{'ok' if self.good else 'DRIFTS':8s}{self.name:58s}{self.value:12.4g}{limit}"


class Course:
    """Looks at a run of `count` steps, each reported by `done`.

    CPU times are divided by the CPU time of a fixed computation beside them, since a machine has other work as well.
    """

    def __init__(
        self,
        count: int,
        clock: Callable[[], float] = time.process_time,
        beside: Callable[[], float] | None = None,
        memory: Callable[[], float] = resident,
    ) -> None:
        if count < HUNDRED:
            raise SystemExit(f"a course has at least {HUNDRED} steps, not {count}")
        self.count, self._clock, self._beside, self._memory = count, clock, beside or yardstick, memory
        looks = HUNDRED * min(LOOKS, count // HUNDRED)
        self._ends = [count * k // looks for k in range(1, looks + 1)]
        self._looks: list[tuple[float, float]] = []  # CPU s a step, and of the computation beside
        self.sizes: list[float] = []
        self.seconds, self._steps = 0.0, 0
        self._beside()
        self._since = clock()

    def done(self, steps: int) -> None:
        """Say that so many steps are done."""
        if len(self._looks) == len(self._ends) or steps < self._ends[len(self._looks)]:
            return
        spent = self._clock() - self._since
        self.seconds += spent
        self._looks.append((spent / (steps - self._steps), self._beside()))
        if len(self._looks) * HUNDRED % len(self._ends) == 0:
            self.sizes.append(self._memory())
            if len(self.sizes) % 10 == 0:
                print(
                    f"{steps} done, {self.seconds:.0f} s of CPU, {self.sizes[-1]:.0f} MB", file=sys.stderr, flush=True
                )
        self._steps, self._since = steps, self._clock()

    @property
    def paces(self) -> list[float]:
        """CPU time a step of each block over the CPU time of the computation beside."""
        each = len(self._ends) // HUNDRED
        blocks = [zip(*self._looks[k : k + each], strict=True) for k in range(0, len(self._looks), each)]
        return [sum(spent) / sum(beside) for spent, beside in blocks]

    def findings(self) -> list[Finding]:
        """Return what became of memory and time in the course of the run."""
        if len(self._looks) < len(self._ends):
            return [Finding(f"steps of {self.count} that were not done", self.count - self._steps, 0)]
        paces, tenth = self.paces, HUNDRED // 10
        slower = median(paces[-tenth:]) / median(paces[:tenth])
        growth = self.sizes[-1] / self.sizes[SETTLED - 1] - 1
        return [
            Finding("CPU a step, ms", 1e3 * self.seconds / self.count),
            Finding("CPU a step in the last tenth over that in the first", slower, SLOWER),
            Finding("resident memory in the end, MB", self.sizes[-1]),
            Finding("growth of it from the 10th hundredth to the 100th", growth, GROWTH),
        ]
