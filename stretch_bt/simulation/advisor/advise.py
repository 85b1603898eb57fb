"""Which effects a scene calls for, and why."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.advisor.choose import Chosen, Judged, choose, judge
from stretch_bt.simulation.effects import Active, Effect, registry
from stretch_bt.simulation.scene import Scene

__all__ = ["Verdict", "advise", "switch_on"]

_NEAR = 3.0  # a verdict within this factor of the threshold comes with a warning
_UNITS = {"height": "m", "size": "m"}


@dataclass(frozen=True, slots=True)
class Verdict:
    """Whether an effect is on; the observable on which it weighs most, the size of that change, None where no estimate holds, and the
    threshold from which it matters, SI; `why` says where the numbers come from, `near` that they are within a factor of 3 of each other,
    and `possible` that the scene can have it at all.
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


def advise(scene: Scene, chosen: Chosen | None = None) -> list[Verdict]:
    """Return a verdict on every effect: as the scene says, and where it says `auto` as the tolerance requires."""
    chosen = choose(scene) if chosen is None else chosen
    judged = judge(scene, Case(scene, scene.object.rough()))
    return [_verdict(effect, judged.get(name), scene, chosen) for name, effect in registry().items()]


def switch_on(scene: Scene, chosen: Chosen | None = None) -> Active:
    """Return the effects that are on, made; the others are never made."""
    on = (choose(scene) if chosen is None else chosen).on
    return Active(effect(scene.parameters(effect)) for name, effect in registry().items() if name in on)


def _verdict(effect: type[Effect], judged: Judged | None, scene: Scene, chosen: Chosen) -> Verdict:
    if judged is None:
        refusal = effect.refusal(scene.object) or effect.not_at(scene) or ""
        return Verdict(effect.name, False, None, None, None, "", effect.cost_ms, refusal, possible=False)
    named, size, limit, why = _weightiest(judged, scene)
    on = effect.name in chosen.on
    if not judged.free:
        why = f"the scene says {'on' if judged.named else 'off'}; {why}"
    elif size is not None and math.isinf(size):
        why = f"{why}; on to be safe"
    elif effect.name in chosen.together:
        results = " and ".join(chosen.together[effect.name])
        why = f"{why}; on because without it the effects that are off would change {results} by too much in sum"
    if effect.needs is not None and effect.needs not in chosen.on and (judged.named or _calls(size, limit)):
        why = f"{why}; without {effect.needs} it changes nothing"
    near = judged.free and bool(size) and limit is not None and limit / _NEAR < (size or 0.0) < limit * _NEAR
    known = None if size is None or math.isinf(size) else size
    return Verdict(effect.name, on, named, known, limit, _UNITS.get(named or "", ""), effect.cost_ms, why, near)


def _calls(size: float | None, limit: float | None) -> bool:
    return size is not None and limit is not None and size > limit


def _weightiest(judged: Judged, scene: Scene) -> tuple[str | None, float | None, float | None, str]:
    """Return the observable with the largest effect over its tolerance, the size there, the threshold that calls for it, and why."""
    tolerance = judged.shares(scene)
    told = [s for s in judged.sizes.values() if s.observable in tolerance]
    if not told:
        what = " and ".join(sorted(judged.sizes)) or "nothing here"
        why = f"changes {what}, for which the scene has no tolerance" if judged.sizes else "changes nothing here"
        return None, None, None, why
    most = max(told, key=lambda s: s.value / tolerance[s.observable])
    return most.observable, most.value, tolerance[most.observable], most.why
