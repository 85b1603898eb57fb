"""The advisor's choice, in words and as JSON."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import asdict
from typing import Any

from stretch_bt.simulation.advisor.advise import Verdict, advise
from stretch_bt.simulation.advisor.choose import NOISE, Chosen
from stretch_bt.simulation.advisor.predict import Predicted
from stretch_bt.simulation.effects import registry
from stretch_bt.simulation.fidelity.rungs import RUNGS
from stretch_bt.simulation.scene import Scene
from stretch_bt.simulation.scene.asked import LENGTHS

__all__ = ["line", "narrow", "quantity", "refusal", "to_json"]

_LEAST = 1e-3  # mm or per cent; below that a size is as good as none
_FREELY = 1.05  # tolerance that a remedy asks for, over the best that can be had


def quantity(observable: str, value: float) -> str:
    """Return a value of an observable, SI, in the unit that people use: mm, or per cent."""
    number, unit = (value * 1e3, "mm") if observable in LENGTHS else (value * 100, "%")
    return f"< {_LEAST:g} {unit}" if 0 < number < _LEAST else f"{number:.3g} {unit}"


def line(scene: Scene, chosen: Chosen) -> str:
    """Return choice, prediction and cost in one line."""
    told = ", ".join(_of(p, scene, chosen) for p in chosen.predicted.values()) or "no result has a tolerance"
    on = ", ".join(_bias(chosen.on)) or "no effect of membrane and object"
    cost = f", about {_time(chosen.cost_ms)} of CPU a press" if chosen.rung else ""
    return f"predicted {told}{_unreached(scene, chosen)}; on: {on}; {_solved(scene, chosen)}{cost}"


def _time(milliseconds: float) -> str:
    """Return a time in ms, or in s from one second on."""
    if milliseconds < 999.5:
        return f"{milliseconds:.3g} ms"
    return f"{milliseconds / 1e3:.{1 if milliseconds < 9950 else 0}f} s"


def _unreached(scene: Scene, chosen: Chosen) -> str:
    """Return the results whose tolerance no choice reaches, what is in the way, and how effects are chosen for them."""
    beyond = [chosen.predicted[name] for name in chosen.beyond]
    if not beyond:
        return ""
    names = " and ".join(p.observable for p in beyond)
    return (
        f"; no choice reaches the tolerance of {names}{_in_the_way(scene, beyond)}, so effects are on for it only where they "
        "alone are past their threshold"
    )


def _of(predicted: Predicted, scene: Scene, chosen: Chosen) -> str:
    name, solved_by = predicted.observable, "the sheet" if chosen.rung else f"{scene.fidelity} fidelity"
    value, tolerance, effects, total = (
        quantity(name, size) for size in (predicted.value, predicted.tolerance, predicted.effects, predicted.total)
    )
    if math.isinf(predicted.effects):
        return f"{name} unknown of {tolerance} (no estimate holds of an effect that is off)"
    if predicted.solver is None:
        return f"{name} unknown of {tolerance} (nothing known of {solved_by} itself, {effects} by effects that are off)"
    own, past = quantity(name, predicted.solver), "" if predicted.within else ", past the tolerance"
    return (
        f"{name} {value}{past} of {tolerance} ({own} by {solved_by} itself, {effects} by effects that are off; "
        f"{total} as a plain sum)"
    )


def _bias(names: Iterable[str]) -> list[str]:
    return [name for name in registry() if name in set(names) and registry()[name].group not in NOISE]


def _solved(scene: Scene, chosen: Chosen) -> str:
    return f"{scene.fidelity} fidelity" if chosen.rung is None else f"sheet setting {chosen.rung}"


def narrow(scene: Scene, chosen: Chosen) -> str | None:
    """Return the effects that are on or off by less than a factor of 3, and a remedy, in one line; None where there are none.

    Effects that the scene names are left out, and so is noise where a run asks for a tolerance, which then does not choose it.
    """
    counted = [v for v in advise(scene, chosen) if not (scene.asked and registry()[v.name].group in NOISE)]
    near = [v for v in counted if v.near and v.observable and v.estimate is not None]
    if not near:
        return None
    told = ", ".join(
        f"{v.name} {'on' if v.on else 'off'} ({v.observable} {_size(v, v.estimate)} of {_size(v, v.threshold)})"
        for v in near
    )
    name = near[0].name
    return (
        f"narrow: {told}; where you know better, write 'effects: {{{name}: {'off' if near[0].on else 'on'}}}' in the scene, "
        "or ask for a smaller --tolerance"
    )


def _size(verdict: Verdict, value: float | None) -> str:
    return "" if value is None or verdict.observable is None else quantity(verdict.observable, value)


def refusal(scene: Scene, chosen: Chosen) -> str:
    """Return the message that no choice reaches a tolerance: the best that can be had, the obstacles and the remedy."""
    missed = [p for p in chosen.predicted.values() if p.observable in scene.asked and not p.within]
    unknown = [p.observable for p in missed if p.solver is None]
    if unknown:
        names = " and ".join(unknown)
        remedy = "; write 'fidelity: auto' or 'fidelity: sheet' in the scene"
        if scene.object.body() is None:  # no sheet meets it
            remedy = f", and no other fidelity has an answer; leave {names} out of --tolerance"
        return (
            f"--tolerance: nothing is known of the error of {names} at {scene.fidelity} fidelity under "
            f"{scene.object.noun}{remedy}"
        )
    if endless := [p.observable for p in missed if math.isinf(p.effects)]:
        names = " and ".join(endless)
        return (
            f"--tolerance: no estimate of {names} holds{_in_the_way(scene, missed)}; "
            f"leave its effects to the advisor, or {names} out of --tolerance"
        )
    best = ", ".join(
        f"{p.observable} {quantity(p.observable, p.value)} of {quantity(p.observable, p.tolerance)}" for p in missed
    )
    return (
        f"--tolerance: no choice of effects stays within it; the best that can be had is {best}, by {_solved(scene, chosen)}"
        f"{_in_the_way(scene, missed)}; {_remedy(scene, missed)}"
    )


def _in_the_way(scene: Scene, missed: list[Predicted]) -> str:
    """Return which effects the scene keeps off that would matter."""
    kept = dict.fromkeys(name for p in missed for name in p.left_off if scene.choice(name) == "off")
    return f", with {', '.join(kept)} off as the scene says" if kept else ""


def _remedy(scene: Scene, missed: list[Predicted]) -> str:
    asked = " ".join(f"{p.observable}={_rounded(p)}" for p in missed)
    finer = "write 'fidelity: auto' in the scene for finer settings, or " if scene.fidelity == "sheet" else ""
    return f"{finer}ask for --tolerance {asked}"


def _rounded(predicted: Predicted) -> str:
    return quantity(predicted.observable, predicted.value * _FREELY).replace(" ", "")


def _finite(predicted: dict[str, Any]) -> dict[str, Any]:
    """Return a prediction with null for what is not known, as JSON has no number for it."""
    known = {name: None if isinstance(v, float) and math.isinf(v) else v for name, v in predicted.items()}
    return {**known, "left_off": list(predicted["left_off"])}


def to_json(scene: Scene, chosen: Chosen) -> dict[str, Any]:
    """Return a choice as records and `--json` have it, SI."""
    return {
        "asked": scene.asked,
        "on": [name for name in registry() if name in chosen.on],
        "sheet": chosen.rung,
        "settings": asdict(RUNGS[chosen.rung]) if chosen.rung else None,
        "predicted": {name: _finite(asdict(p)) for name, p in chosen.predicted.items()},
        "cost_ms": chosen.cost_ms,
        "reached": chosen.reached,
        "beyond": list(chosen.beyond),
        "line": line(scene, chosen),
        "narrow": narrow(scene, chosen),
    }
