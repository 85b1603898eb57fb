"""Both trees with stop rules from loose to strict, on the same lumps."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping
from functools import partial
from itertools import product
from pathlib import Path
from typing import NamedTuple

from stretch_bt.accuracy.cookie.lumps import draw, scene
from stretch_bt.accuracy.job import Job
from stretch_bt.accuracy.points import FAILED, Answer, Setting
from stretch_bt.runtime.task import run

__all__ = ["LUMPS", "RULES", "Rule", "jobs"]

LUMPS = 20


class Rule(NamedTuple):
    """A tree with its params, and CPU seconds of a run."""

    tree: str
    words: str
    params: Mapping[str, float]
    seconds: float


SHIPPED = "as shipped"
RULES = (
    Rule("form_cookie", SHIPPED, {}, 12.0),
    Rule("form_cookie", "after ten heights", {"settled_spread": 0.05}, 8.0),
    Rule("form_cookie_fast", SHIPPED, {}, 12.0),
    Rule(
        "form_cookie_fast",
        "first look after 0.4 m, twice the spread",
        {"blind": 0.4, "max_spread": 0.11, "max_residual": 0.04},
        9.0,
    ),
    Rule("form_cookie_fast", "first look after 1.3 m", {"blind": 1.3}, 14.0),
)


def jobs() -> Iterator[Job]:
    """Yield each lump by each tree with each rule."""
    for seed, rule in product(range(LUMPS), RULES):
        setting = Setting(rule.tree, rule.words)
        default = rule.tree == RULES[0].tree and rule.words == SHIPPED
        yield Job("drawn cube", setting, "circularity", rule.seconds, partial(_run, rule, seed), seed, default)


def _run(rule: Rule, seed: int) -> list[Answer]:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scene.yaml"
        path.write_text(scene(draw(seed)), encoding="utf-8")
        found = run(rule.tree, scene=path, seed=seed, params=dict(rule.params), out=Path(folder) / "record")
    if found.status == "INTERRUPTED":  # the runner takes the signal for itself
        raise KeyboardInterrupt
    cpu, robot = found.cpu_seconds, found.task_seconds
    if found.status != "SUCCESS":
        return [Answer("circularity", None, cpu, 0.0, robot, status=FAILED, reason=f"{found.status}: {found.reason}")]
    out = {name: value["value"] for name, value in found.outputs.items()}
    errors = {
        "circularity": 1.0 - out["circularity_true"],
        "sensed": abs(out["circularity_sensed"] - out["circularity_true"]),
    }
    return [Answer(kind, error, cpu, 0.0, robot) for kind, error in errors.items()]
