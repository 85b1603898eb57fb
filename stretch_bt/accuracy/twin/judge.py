"""Whether the advisor chose well, and the cost of its choice beside everything and beside the least that would do."""

from __future__ import annotations

import math
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from stretch_bt.accuracy.twin.ledger import Ledger, Runs
from stretch_bt.simulation.advisor.advise import Verdict, advise
from stretch_bt.simulation.scene import Scene, load_scene

__all__ = ["RELATIVE", "Judged", "Priced", "change", "judge", "matters", "price"]

RELATIVE = ("force", "stiffness")


@dataclass(frozen=True, slots=True)
class Judged:
    """An effect of a scene, switched over: the change of the mean of the runs, and the rms of the change in each run,
    over the tolerance; 1 and more matters. Infinite where runs fail with it that did not without, or the other way round.
    """

    scene: str
    verdict: Verdict
    mean: float
    rms: float
    seeds: int

    @property
    def right(self) -> bool:
        """Whether the advisor's choice holds by the change of the mean."""
        return (self.mean > 1) is self.verdict.on


@dataclass(frozen=True, slots=True)
class Priced:
    """A scene with the advisor's choice switched on, with everything, with nothing, and with the least that does.

    `apart` is the difference of the mean result from the mean with everything on, over the tolerance, in `pairs` paired runs.
    """

    scene: str
    tolerance: Mapping[str, float]
    sets: Mapping[str, tuple[str, ...]]
    runs: Mapping[str, Runs]
    apart: Mapping[str, float]
    pairs: int


def judge(name: str, ledger: Ledger, seeds: Sequence[int], dear: Mapping[str, int]) -> list[Judged]:
    """Return a judgement on each effect that a scene leaves to the advisor; `dear` names effects that are run on fewer seeds."""
    scene, on, every = _chosen(name)
    found = []
    for verdict in (v for v in advise(scene) if v.possible and scene.choice(v.name) == "auto"):
        few = seeds[: dear.get(verdict.name, len(seeds))]
        other = on ^ {verdict.name}
        base, switched = ledger.several(name, [on, other], every, few)
        found.append(Judged(name, verdict, *change(scene, base, switched), len(few)))
    return found


def price(name: str, ledger: Ledger, seeds: Sequence[int], few: Sequence[int]) -> Priced:
    """Return the cost of a scene; the least is found by taking away one effect after the other, the dearest first.

    It begins with the advisor's choice, if that agrees with everything on, else with as much more as it takes, the largest first.
    `few` are the seeds of the runs with everything on, which are dear.
    """
    scene, on, every = _chosen(name)
    full = ledger.runs(name, every, every, few)
    least, left_out = set(on), sorted((v for v in advise(scene) if v.name in set(every) - on), key=matters)
    while left_out and not _agree(scene, full, ledger.runs(name, least, every, seeds)):
        least.add(left_out.pop().name)
    costs = {v.name: v.cost_ms for v in advise(scene)}
    for effect in sorted(least, key=lambda e: -costs[e]):
        if _agree(scene, full, ledger.runs(name, least - {effect}, every, seeds)):
            least -= {effect}
    sets = {"auto": on, "everything": set(every), "nothing": set(), "least": least}
    runs = {
        label: full if label == "everything" else ledger.runs(name, chosen, every, seeds)
        for label, chosen in sets.items()
    }
    apart = {label: change(scene, full, other)[0] for label, other in runs.items()}
    told = {label: tuple(sorted(s)) for label, s in sets.items()}
    return Priced(name, scene.tolerance.named(), told, runs, apart, len(few))


def change(scene: Scene, base: Runs, other: Runs) -> tuple[float, float]:
    """Return the change of the mean of an observable, and the rms of its change in each run, over the tolerance.

    Of the observables of the tolerance, the one that changes most counts. Runs are compared seed by seed; where more than a
    third of them have an observable with one set of effects and not with the other, the change is infinite, and so it is
    where none can be compared.
    """
    worst = (0.0, 0.0)
    for observable, tolerance in scene.tolerance.named().items():
        each = other.paired(base, observable)
        alone = other.unpaired(base, observable)
        if not each or alone > (len(each) + alone) / 3:
            return math.inf, math.inf
        scale = tolerance * (abs(base.mean(observable) or 0.0) if observable in RELATIVE else 1.0)
        rms = math.sqrt(statistics.fmean(d * d for d in each)) / scale
        worst = max(worst[0], abs(statistics.fmean(each)) / scale), max(worst[1], rms)
    return worst


def _agree(scene: Scene, full: Runs, runs: Runs) -> bool:
    return change(scene, full, runs)[0] <= 1


def matters(verdict: Verdict) -> float:
    """Return the estimate of an effect over its threshold, 0 without one."""
    return verdict.estimate / verdict.threshold if verdict.estimate is not None and verdict.threshold else 0.0


def _chosen(name: str) -> tuple[Scene, set[str], list[str]]:
    """Return a scene, the effects that the advisor switches on, and all that it can have."""
    scene = load_scene(name)
    possible = [v for v in advise(scene) if v.possible]
    return scene, {v.name for v in possible if v.on}, [v.name for v in possible]
