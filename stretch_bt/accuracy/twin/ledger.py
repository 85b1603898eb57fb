"""Outcomes that were worked out before, in a file, so that a long comparison can be taken up again."""

from __future__ import annotations

import hashlib
import json
import statistics
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from stretch_bt.accuracy.twin.outcome import TaskFigures, outcome, with_effects

__all__ = ["Ledger", "Runs"]

Key = tuple[str, str, tuple[str, ...], int]


class Runs:
    """The outcomes of a scene with one set of effects, by seed."""

    def __init__(self, outcomes: Sequence[TaskFigures]) -> None:
        self.outcomes = outcomes

    @property
    def failed(self) -> int:
        """How many of them failed."""
        return sum(not o.values for o in self.outcomes)

    @property
    def cpu_seconds(self) -> float:
        """Median CPU time, s."""
        return statistics.median(o.cpu_seconds for o in self.outcomes)

    def mean(self, observable: str) -> float | None:
        """Return the mean of an observable over the runs that have it, None where none has."""
        found = [o.values[observable] for o in self.outcomes if observable in o.values]
        return statistics.fmean(found) if found else None

    def paired(self, other: Runs, observable: str) -> list[float]:
        """Return the differences of an observable from other runs, seed by seed."""
        pairs = zip(self.outcomes, other.outcomes, strict=False)
        return [
            a.values[observable] - b.values[observable]
            for a, b in pairs
            if observable in a.values and observable in b.values
        ]

    def unpaired(self, other: Runs, observable: str) -> int:
        """Return for how many seeds one of the two has an observable and the other has not."""
        pairs = zip(self.outcomes, other.outcomes, strict=False)
        return sum((observable in a.values) is not (observable in b.values) for a, b in pairs)


class Ledger:
    """Works out outcomes on two processes and keeps them in a file of JSON lines, None for memory only."""

    def __init__(self, path: Path | None, workers: int = 2) -> None:
        self.path, self.workers = path, workers
        self.known: dict[Key, TaskFigures] = {}
        for line in path.read_text("utf-8").splitlines() if path is not None and path.exists() else ():
            found = json.loads(line)
            self.known[found["scene"], found["text"], tuple(found["on"]), found["seed"]] = TaskFigures(
                found["values"], found["cpu_seconds"], found["reason"]
            )

    def runs(self, scene: str, on: Iterable[str], every: Iterable[str], seeds: Iterable[int]) -> Runs:
        """Return the outcomes of a scene with these effects on and all others of `every` off."""
        return self.several(scene, [on], every, seeds)[0]

    def several(
        self, scene: str, sets: Iterable[Iterable[str]], every: Iterable[str], seeds: Iterable[int]
    ) -> list[Runs]:
        """Return the outcomes with each of several sets of effects on."""
        wanted, everything, numbers = [tuple(sorted(on)) for on in sets], sorted(every), list(seeds)
        text = _digest(with_effects(scene, {}))
        keys = [(scene, text, on, seed) for on in dict.fromkeys(wanted) for seed in numbers]
        for key, found in self._work_out([key for key in keys if key not in self.known], everything):
            self.known[key] = found
            self._write(key, found)
        return [Runs([self.known[scene, text, on, seed] for seed in numbers]) for on in wanted]

    def _work_out(self, keys: Sequence[Key], every: Sequence[str]) -> Iterator[tuple[Key, TaskFigures]]:
        texts = [with_effects(key[0], {e: "on" if e in key[2] else "off" for e in every}) for key in keys]
        if len(keys) < 2 or self.workers < 2:
            yield from ((key, outcome(text, key[3])) for key, text in zip(keys, texts, strict=True))
            return
        with ProcessPoolExecutor(self.workers) as pool:
            yield from zip(keys, pool.map(outcome, texts, [key[3] for key in keys]), strict=True)

    def _write(self, key: Key, found: TaskFigures) -> None:
        if self.path is None:
            return
        scene, text, on, seed = key
        row = {
            "scene": scene,
            "text": text,
            "on": on,
            "seed": seed,
            "values": dict(found.values),
            "cpu_seconds": found.cpu_seconds,
        }
        with self.path.open("a", encoding="utf-8") as file:
            file.write(json.dumps({**row, "reason": found.reason}) + "\n")


def _digest(text: str) -> str:
    """Return a few letters that stand for the text of a scene, so that no outcome outlives a change of it."""
    return hashlib.sha256(text.encode()).hexdigest()[:12]
