"""The cheapest effects, and the cheapest setting of the sheet, with which a scene's results stay within their tolerance."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import compress

import numpy as np
import numpy.typing as npt

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.advisor.predict import Predicted, predicted, predictions
from stretch_bt.simulation.advisor.sheet_table import read_sheet_table
from stretch_bt.simulation.effects import Effect, Size, registry
from stretch_bt.simulation.fidelity.rungs import RUNGS, USUAL_RUNG
from stretch_bt.simulation.scene import Scene

__all__ = ["NOISE", "Chosen", "Judged", "choose", "judge"]

#: groups of effects that a run's tolerance leaves as the scene says
NOISE = ("camera", "robot")
_SAME = 1 + 1e-9  # factor on a tolerance, for rounding
#: joint change by effects over its estimate: the 95th percentile in presses of random bodies (benchmarks/effect_estimates.py)
_SPREAD = 1.25
_SEVERAL = "no estimate holds where several objects hold the membrane, which hangs freely between them"
Sizes = Mapping[str, Size]


@dataclass(frozen=True, slots=True)
class Judged:
    """An effect that a scene can have: its largest change of each result, and the scene's choice for it."""

    effect: type[Effect]
    sizes: Sizes
    choice: object

    @property
    def free(self) -> bool:
        """Whether the scene leaves it to the advisor."""
        return self.choice == "auto"

    @property
    def named(self) -> bool:
        """Whether the scene switches it on."""
        return self.choice not in ("auto", "off")

    def shares(self, scene: Scene) -> dict[str, float]:
        """Return the threshold that calls for it by itself, by result, SI.

        Where a run asks for a tolerance the threshold is all of it; noise goes by the scene's tolerance.
        """
        noise = self.effect.group in NOISE
        own = {
            name: value * self.effect.worth
            for name, value in (scene.tolerance.named() if noise else scene.kept).items()
        }
        return own if noise else {**own, **scene.asked}

    def calls(self, scene: Scene) -> bool:
        """Return whether it alone is larger than its share of a tolerance."""
        shares = self.shares(scene)
        return any(name in shares and size.value > shares[name] for name, size in self.sizes.items())


@dataclass(frozen=True, slots=True)
class Chosen:
    """Which effects are on, the setting that solves the sheet, None without a sheet, and the predicted difference of each result.

    `cost_ms` is about the time of a press, ms of CPU on the machine that the table was made on. `reached` says whether every
    prediction is known and within its tolerance, and `together` names effects that are on though each alone would be small enough.
    """

    on: frozenset[str]
    rung: str | None
    predicted: Mapping[str, Predicted]
    cost_ms: float
    reached: bool
    together: frozenset[str] = frozenset()


def judge(scene: Scene, case: Case) -> dict[str, Judged]:
    """Return the changes by each effect that a scene can have."""
    found = {}
    for name, effect in registry().items():
        if effect.refusal(scene.object) is None and effect.not_at(scene) is None:
            sizes: dict[str, Size] = {}
            for size in effect.sizes(case, scene.parameters(effect)):
                known = sizes.get(size.observable)
                sizes[size.observable] = size if known is None or size.value > known.value else known
            if case.rough.several:
                sizes |= {observable: Size(observable, math.inf, _SEVERAL) for observable in effect.under_one}
            found[name] = Judged(effect, sizes, scene.choice(name))
    return found


def choose(scene: Scene) -> Chosen:
    """Return the cheapest choice whose predictions are within the tolerance, or else the most accurate one.

    Effects that the scene names stay as it says, and so do a fixed `fidelity` and the noise of camera and robot. An effect that alone is
    larger than its share of a tolerance of the scene is on in any case. Where a scene fixes its fidelity and no run asks for a tolerance
    the choice goes by the effects that are off alone, as estimated; the prediction counts the error of the sheet and the spread of
    estimates all the same.
    """
    return _Choice(scene).best()


class _Choice:
    """The choices in a scene."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.case = Case(scene, scene.object.rough())
        self.judged = judge(scene, self.case)
        self.tolerances = {**scene.kept, **scene.asked}
        self.table = read_sheet_table()
        noise = {name: j for name, j in self.judged.items() if j.effect.group in NOISE}
        self.noise = {name for name, j in noise.items() if j.named or (j.free and j.calls(scene))}
        self.bias = {name: j for name, j in self.judged.items() if name not in noise}
        #: whether the whole prediction must stay within the tolerance, or the effects that are off by themselves, as estimated:
        #: what a scene states switches nothing on for an error of a sheet that it fixes
        self.strict = bool(scene.asked) or scene.fidelity == "auto"
        self.rungs = self._rungs()

    def _rungs(self) -> list[str | None]:
        if self.scene.fidelity == "auto":
            return list(RUNGS)
        return [USUAL_RUNG] if self.scene.is_sheet else [None]

    def best(self) -> Chosen:
        """Return the best choice."""
        names = list(self.bias)
        fixed = np.array([not j.free for j in self.bias.values()], dtype=np.bool_)
        told = np.array([j.named for j in self.bias.values()], dtype=np.bool_)
        called = told | (~fixed & np.array([j.calls(self.scene) for j in self.bias.values()], dtype=np.bool_))
        called = self._with_needs(called)
        least = [(rung, called) for rung in self.rungs]
        within = [self._at(*one) for one in least if self._known(one[0]) and self._within(one[1][None], one[0])[0]]
        if len(within) < len(self.rungs):
            within += self._added(names, called, self._helping() & ~fixed & ~called)
        if within:
            return min(within, key=lambda found: (found.cost_ms, self._worst(found)))
        everything = self._with_needs(called | (self._helping() & ~fixed))
        return min((self._at(rung, everything, called) for rung in self.rungs), key=self._worst)

    def _helping(self) -> npt.NDArray[np.bool_]:
        """Return which effects change a result that has a tolerance, or are needed by one that does."""
        changing = [
            any(size.value > 0 for n, size in j.sizes.items() if n in self.tolerances) for j in self.bias.values()
        ]
        helping = np.array(changing, dtype=np.bool_)
        for place, needed in self._needs(list(self.bias)):
            helping[needed] |= helping[place]
        return helping

    def _added(
        self, names: Sequence[str], called: npt.NDArray[np.bool_], free: npt.NDArray[np.bool_]
    ) -> Iterator[Chosen]:
        """Yield, for each setting, the cheapest choice within the tolerance that switches further effects on."""
        places = np.flatnonzero(free)
        bits = (np.arange(2 ** len(places))[:, None] >> np.arange(len(places))) & 1
        choices = np.tile(called, (len(bits), 1))
        choices[:, places] = bits.astype(np.bool_)
        choices = choices[self._possible(names, choices)]
        times = [self.table.times(list(compress(names, choice))) for choice in choices]
        choices = choices[np.lexsort((choices.sum(axis=1), times))]  # the cheapest first, and of those the fewest
        for rung in self.rungs:
            within = self._within(choices, rung)
            if within.any():
                yield self._at(rung, choices[int(np.argmax(within))], called)

    def _within(self, choices: npt.NDArray[np.bool_], rung: str | None) -> npt.NDArray[np.bool_]:
        """Return which choices (n, effects) stay within every tolerance, as far as the choice goes by it."""
        within = np.ones(len(choices), dtype=np.bool_)
        solver, spread = (self._solver(rung), _SPREAD) if self.strict else ({}, 1.0)
        for name, tolerance in self.tolerances.items():
            sizes = [self._weighed(j.sizes.get(name), j) for j in self.bias.values()]
            value = np.hypot(spread * predictions(sizes, ~choices), solver.get(name, 0.0))
            within &= value <= tolerance * _SAME
        return within

    @staticmethod
    def _weighed(size: Size | None, judged: Judged) -> Size | None:
        """Return a change, None for one that nothing is known of and that the scene switches off by name: no choice makes it smaller."""
        return None if size is not None and math.isinf(size.value) and not judged.free else size

    def _possible(self, names: Sequence[str], choices: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
        """Return which choices have no effect on without the one that it needs, except effects that the scene names."""
        fits = np.ones(len(choices), dtype=np.bool_)
        for place, needed in self._needs(names):
            if not self.bias[names[place]].named:
                fits &= ~choices[:, place] | choices[:, needed]
        return fits

    def _with_needs(self, on: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
        """Return a choice without the effects that change nothing since the effect that they need is off, unless the scene names them."""
        kept = on.copy()
        for place, needed in self._needs(list(self.bias)):
            named = list(self.bias.values())[place].named
            kept[place] &= kept[needed] or named
        return kept

    def _needs(self, names: Sequence[str]) -> Iterator[tuple[int, int]]:
        for place, name in enumerate(names):
            needed = registry()[name].needs
            if needed in self.bias:
                yield place, names.index(needed)

    def _solver(self, rung: str | None) -> Mapping[str, float]:
        """Return the error of a setting, or of a fidelity without a sheet, by result."""
        return self.table.error(rung or self.scene.fidelity, self.case)

    def _known(self, rung: str | None) -> bool:
        """Return whether the error of a setting is known for every result that the choice goes by."""
        return not self.strict or self.tolerances.keys() <= self._solver(rung).keys()

    def _at(self, rung: str | None, on: npt.NDArray[np.bool_], called: npt.NDArray[np.bool_] | None = None) -> Chosen:
        off = {name: self.bias[name].sizes for name in compress(self.bias, ~on)}
        found = predicted(self.tolerances, off, self._solver(rung), _SPREAD)
        names = frozenset(compress(self.bias, on))
        more = frozenset(compress(self.bias, on & ~called)) if called is not None else frozenset()
        reached = all(p.solver is not None and p.ratio <= _SAME for p in found.values())
        cost = self.table.cost(rung, names, self.case) if rung else 0.0
        return Chosen(names | self.noise, rung, found, cost, reached, more)

    @staticmethod
    def _worst(found: Chosen) -> float:
        return max((p.ratio for p in found.predicted.values()), default=0.0)
