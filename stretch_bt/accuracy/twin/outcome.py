"""The outcome of a scene's task with given effects: its results and their cost."""

from __future__ import annotations

import math
import tempfile
import time
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

from stretch_bt.accuracy.twin.press import press_once
from stretch_bt.accuracy.twin.rolling import roll_once
from stretch_bt.errors import DeviceFault, NoAnswer
from stretch_bt.runtime.task import run
from stretch_bt.simulation.scene import Scene, parse_scene

__all__ = ["TaskFigures", "outcome", "with_effects"]


@dataclass(frozen=True, slots=True)
class TaskFigures:
    """Results of the observables in the scene's tolerance, SI; empty and with a reason where the task failed. CPU time, s."""

    values: Mapping[str, float]
    cpu_seconds: float
    reason: str = ""


def with_effects(name: str, choices: Mapping[str, str]) -> str:
    """Return the text of a shipped scene with these effects, `on` or `off`, by name, in the place of its own."""
    path = files("stretch_bt") / "trees" / "scenes" / f"{name}.yaml"
    told, _, _ = path.read_text("utf-8").partition("\neffects:")  # its last section
    listed = ", ".join(f"{effect}: {word}" for effect, word in choices.items())
    return f"{told}\neffects: {{{listed}}}\n"


def outcome(text: str, seed: int) -> TaskFigures:
    """Return the outcome of the task of a scene, given as text: palpation of a balloon, rolling of dough, else one press."""
    scene = parse_scene(text)
    task = {"balloon": _palpate, "dough": _roll}.get(scene.object.type, _press)
    began = time.process_time()
    try:
        values = task(scene, text, seed)
    except NoAnswer as failure:
        return TaskFigures({}, time.process_time() - began, failure.reason)
    except DeviceFault as fault:  # without an effect the hand may go past what its cell allows
        return TaskFigures({}, time.process_time() - began, str(fault))
    wanted = {name: values[name] for name in scene.tolerance.named() if math.isfinite(values.get(name, math.nan))}
    return TaskFigures(wanted, time.process_time() - began)


def _palpate(scene: Scene, text: str, seed: int) -> dict[str, float]:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scene.yaml"
        path.write_text(text, encoding="utf-8")
        found = run("palpate_stiffness", scene=path, seed=seed, out=Path(folder) / "record")
    if found.status == "INTERRUPTED":  # the runner took the signal; it is for the whole measurement
        raise KeyboardInterrupt
    if found.status != "SUCCESS":
        raise NoAnswer(found.reason)
    drop = found.outputs["deflection"]["value"]
    # the height of the pressed top under the force of the standard drop follows from the stiffness
    return {"stiffness": found.outputs["stiffness"]["value"] * 1e3, "height": scene.object.top - drop * 1e-3}


def _press(scene: Scene, text: str, seed: int) -> dict[str, float]:
    return press_once(scene, seed)


def _roll(scene: Scene, text: str, seed: int) -> dict[str, float]:
    return roll_once(scene, seed)
