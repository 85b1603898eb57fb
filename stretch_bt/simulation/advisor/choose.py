"""The cheapest effects, and the cheapest setting of the sheet, with which a scene's results stay within their tolerance."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import compress

import numpy as np
import numpy.typing as npt

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.advisor.predict import SAME, Predicted, predicted, predictions
from stretch_bt.simulation.advisor.sheet_table import read_sheet_table
from stretch_bt.simulation.effects import Effect, Size, registry
from stretch_bt.simulation.fidelity.rungs import RUNGS, USUAL_RUNG
from stretch_bt.simulation.scene import Scene

__all__ = ["NOISE", "Chosen", "Judged", "choose", "judge"]

#: groups of effects that a run's tolerance leaves as the scene says
NOISE = ("camera", "robot")
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
    prediction is known and within its tolerance. `together` names effects that are on though each alone would be small enough, with the
    results that would else be past their tolerance, and `beyond` names results whose tolerance no choice reaches.
    """

    on: frozenset[str]
    rung: str | None
    predicted: Mapping[str, Predicted]
    cost_ms: float
    reached: bool
    together: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    beyond: tuple[str, ...] = ()


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
    """Return the cheapest choice whose predictions are within every tolerance that some choice reaches.

    A tolerance that no choice reaches switches no effect on beside those that alone are larger than their share of it, and the sheet is
    then as fine as that tolerance needs, or as it can be. Where a run asks for what no choice reaches the most accurate choice is returned.

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
        fixed = np.array([not j.free for j in self.bias.values()], dtype=np.bool_)
        told = np.array([j.named for j in self.bias.values()], dtype=np.bool_)
        called = told | (~fixed & np.array([j.calls(self.scene) for j in self.bias.values()], dtype=np.bool_))
        called = self._with_needs(called)
        everything = self._with_needs(called | (self._helping(self.tolerances) & ~fixed))
        # more effects on never make a prediction larger: what everything reaches can be reached, each result and all of them together
        goals = {rung: self._goals(everything, rung) for rung in self.rungs}
        if not any(self.scene.asked.keys() <= set(names) for names in goals.values()):
            return min((self._at(rung, everything, called, goals[rung]) for rung in self.rungs), key=self._worst)
        found = [self._cheapest(rung, called, ~fixed & ~called, goals[rung]) for rung in self._best_rungs(goals)]
        return min(found, key=lambda one: (one.cost_ms, self._worst(one)))

    def _goals(self, on: npt.NDArray[np.bool_], rung: str | None) -> tuple[str, ...]:
        """Return the results that one choice (effects,) keeps within their tolerance at a setting."""
        return tuple(name for name in self.tolerances if self._within(on[None], rung, (name,))[0])

    def _best_rungs(self, goals: Mapping[str | None, Collection[str]]) -> list[str | None]:
        """Return the settings that reach most: what a run asks for, other tolerances, and at least the sheet's own part of the rest."""

        def reached(rung: str | None) -> tuple[bool, int, int]:
            return self.scene.asked.keys() <= set(goals[rung]), len(goals[rung]), self._fine_enough(rung)

        most = max(map(reached, self.rungs))
        return [rung for rung in self.rungs if reached(rung) == most]

    def _fine_enough(self, rung: str | None) -> int:
        """Return for how many results the sheet itself stays within the tolerance, or is as accurate as at any setting."""
        own = {other: self._solver(other) for other in self.rungs}
        least = {name: min(error.get(name, math.inf) for error in own.values()) for name in self.tolerances}
        limits = {name: max(tolerance, least[name]) for name, tolerance in self.tolerances.items()}
        return sum(own[rung].get(name, math.inf) <= limit for name, limit in limits.items())

    def _helping(self, results: Collection[str]) -> npt.NDArray[np.bool_]:
        """Return which effects change one of these results, or are needed by one that does."""
        changing = [any(size.value > 0 for n, size in j.sizes.items() if n in results) for j in self.bias.values()]
        helping = np.array(changing, dtype=np.bool_)
        for place, needed in self._needs(list(self.bias)):
            helping[needed] |= helping[place]
        return helping

    def _cheapest(
        self, rung: str | None, called: npt.NDArray[np.bool_], free: npt.NDArray[np.bool_], goals: Sequence[str]
    ) -> Chosen:
        """Return the cheapest choice that keeps what can be reached within its tolerance; it may switch free effects on."""
        if self._within(called[None], rung, goals)[0]:
            return self._at(rung, called, called, goals)
        names = list(self.bias)
        places = np.flatnonzero(free & self._helping(goals))
        bits = (np.arange(2 ** len(places))[:, None] >> np.arange(len(places))) & 1
        choices = np.tile(called, (len(bits), 1))
        choices[:, places] = bits.astype(np.bool_)
        choices = choices[self._possible(names, choices)]
        times = [self.table.times(list(compress(names, choice))) for choice in choices]
        choices = choices[np.lexsort((choices.sum(axis=1), times))]  # the cheapest first, and of those the fewest
        return self._at(rung, choices[int(np.argmax(self._within(choices, rung, goals)))], called, goals)

    def _within(
        self, choices: npt.NDArray[np.bool_], rung: str | None, results: Collection[str]
    ) -> npt.NDArray[np.bool_]:
        """Return which choices (n, effects) keep these results within their tolerance, as far as the choice goes by it."""
        within = np.ones(len(choices), dtype=np.bool_)
        solver, spread = (self._solver(rung), _SPREAD) if self.strict else (dict.fromkeys(results, 0.0), 1.0)
        for name in results:
            sizes = [j.sizes.get(name) for j in self.bias.values()]
            value = np.hypot(spread * predictions(sizes, ~choices), solver.get(name, math.inf))
            within &= value <= self.tolerances[name] * SAME
        return within

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

    def _at(
        self, rung: str | None, on: npt.NDArray[np.bool_], called: npt.NDArray[np.bool_], goals: Sequence[str]
    ) -> Chosen:
        off = {name: self.bias[name].sizes for name in compress(self.bias, ~on)}
        found = predicted(self.tolerances, off, self._solver(rung), _SPREAD)
        names = frozenset(compress(self.bias, on))
        more = {
            name: self._kept_by(place, on, rung, goals) for place, name in enumerate(self.bias) if (on & ~called)[place]
        }
        cost = self.table.cost(rung, names, self.case) if rung else 0.0
        beyond = tuple(name for name in self.tolerances if name not in goals)
        return Chosen(names | self.noise, rung, found, cost, all(p.within for p in found.values()), more, beyond)

    def _kept_by(
        self, place: int, on: npt.NDArray[np.bool_], rung: str | None, goals: Sequence[str]
    ) -> tuple[str, ...]:
        """Return the results that would be past their tolerance without an effect, and without those that need it."""
        without = on.copy()
        without[place] = False
        without = self._with_needs(without)[None]
        return tuple(name for name in goals if not self._within(without, rung, (name,))[0])

    def _worst(self, found: Chosen) -> float:
        """Return the largest prediction over its tolerance, of what a run asks for where it asks."""
        told = found.predicted.values()
        return max((p.ratio for p in told if not self.scene.asked or p.observable in self.scene.asked), default=0.0)
