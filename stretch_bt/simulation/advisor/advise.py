"""Which effects a scene calls for, and why."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects import Active, Effect, registry
from stretch_bt.simulation.scene import Scene

__all__ = ["LeftOff", "Verdict", "advise", "left_off", "switch_on"]

_NEAR = 3.0  # a verdict within this factor of the threshold comes with a warning
_UNITS = {"height": "m", "size": "m"}


@dataclass(frozen=True, slots=True)
class Verdict:
    """Whether an effect is on; the observable on which it weighs most, how much it would change it, and from where on that
    matters, SI; `why` says what the numbers come from, `near` that they are within a factor of 3 of each other, and `possible`
    that the scene can have it at all.
    """

    name: str
    on: bool
    observable: str | None
    estimate: float | None
    threshold: float | None
    unit: str
    cost_ms: float
    why: str
    near: bool = False
    possible: bool = True

    def to_json(self) -> dict[str, Any]:
        """Return the fields that `scene explain --json` prints."""
        return asdict(self)


@dataclass(frozen=True, slots=True)
class LeftOff:
    """What is off changes an observable together by `estimate` at most, SI, and so by more than `threshold`; the largest is named first."""

    observable: str
    estimate: float
    threshold: float
    names: tuple[str, ...]


def left_off(verdicts: Iterable[Verdict]) -> list[LeftOff]:
    """Return the observables in which the effects that are off, each small enough by itself, may add up to more than the tolerance."""
    found: dict[tuple[str, float], list[tuple[float, str]]] = {}
    for v in verdicts:
        if not v.on and v.observable is not None and v.estimate and v.threshold:
            tolerance = v.threshold / registry()[v.name].worth
            found.setdefault((v.observable, tolerance), []).append((v.estimate, v.name))
    told = []
    for (observable, limit), parts in found.items():
        names = tuple(name for _, name in sorted(parts, reverse=True))
        told.append(LeftOff(observable, sum(size for size, _ in parts), limit, names))
    return [together for together in told if together.estimate > together.threshold]


def advise(scene: Scene) -> list[Verdict]:
    """Return a verdict on every effect: what the scene says, and where it says `auto` what the tolerance asks for."""
    case = Case(scene, scene.object.rough())
    found = {name: _verdict(effect, case) for name, effect in registry().items()}
    return [_with_what_it_needs(verdict, found, scene) for verdict in found.values()]


def _with_what_it_needs(verdict: Verdict, others: Mapping[str, Verdict], scene: Scene) -> Verdict:
    """Return a verdict that says so, and by itself is off, where an effect changes nothing as another one is off."""
    needed = registry()[verdict.name].needs
    if needed is None or not verdict.on or others[needed].on:
        return verdict
    told = f"{verdict.why}; without {needed} it changes nothing"
    return replace(verdict, why=told, on=scene.choice(verdict.name) != "auto")


def switch_on(scene: Scene, verdicts: list[Verdict] | None = None) -> Active:
    """Return the effects that are on, made; the others are never made."""
    chosen = advise(scene) if verdicts is None else verdicts
    known = registry()
    return Active(known[v.name](scene.parameters(known[v.name])) for v in chosen if v.on)


def _verdict(effect: type[Effect], case: Case) -> Verdict:
    scene = case.scene
    refusal = effect.refusal(scene.object) or effect.not_at(scene)
    if refusal is not None:
        return Verdict(effect.name, False, None, None, None, "", effect.cost_ms, refusal, possible=False)
    named, size, limit, why = _weightiest(effect, case)
    choice = scene.choice(effect.name)
    if choice == "auto":
        on = size is not None and limit is not None and size > limit
    else:
        on, why = choice != "off", f"the scene says {'off' if choice == 'off' else 'on'}; {why}"
    near = choice == "auto" and bool(size) and limit is not None and limit / _NEAR < (size or 0.0) < limit * _NEAR
    return Verdict(effect.name, on, named, size, limit, _UNITS.get(named or "", ""), effect.cost_ms, why, near)


def _weightiest(effect: type[Effect], case: Case) -> tuple[str | None, float | None, float | None, str]:
    """Return the observable in whose tolerance the effect is largest, its size there, from where on it is called for, and why."""
    tolerance = case.scene.tolerance.named()
    sizes = list(effect.sizes(case, case.scene.parameters(effect)))
    told = [s for s in sizes if s.observable in tolerance]
    if not told:
        what = " and ".join(sorted({s.observable for s in sizes})) or "nothing here"
        return (
            None,
            None,
            None,
            f"changes {what}, for which the scene has no tolerance" if sizes else "changes nothing here",
        )
    most = max(told, key=lambda s: s.value / tolerance[s.observable])
    return most.observable, most.value, tolerance[most.observable] * effect.worth, most.why
