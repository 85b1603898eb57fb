"""Reconstructions by planned presses and by square grids of them, over how many presses they take."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import product
from typing import Any

from stretch_bt.accuracy.job import Job
from stretch_bt.accuracy.points import FAILED, Answer, Cost, Setting
from stretch_bt.accuracy.reconstruction.run import Unfinished, grid, reconstructed

__all__ = ["SCENES", "WAYS", "jobs"]

SCENES = (
    "wooden_cube",
    "wooden_half_cylinder",
    "wooden_bridge",
    "wooden_prism",
    "glass_snowman",
    "paper_pyramid",
)
PLANNED, GRID = "planned", "square grid"
#: most presses of each way; None as shipped
WAYS: tuple[tuple[str, int | None], ...] = (
    (PLANNED, 1),
    (PLANNED, None),
    (PLANNED, 2),
    (PLANNED, 4),
    (GRID, 4),
    (GRID, 9),
)
_PRESSES = 5  # that a planned reconstruction takes, about
_FIRST, _PRESS = 2.0, 2.0  # CPU s


def jobs() -> Iterator[Job]:
    """Yield each scene by each way."""
    for scene, (series, most) in product(SCENES, WAYS):
        words = "as shipped, at most 12" if most is None else f"{'at most ' if series == PLANNED else ''}{most}"
        seconds = _FIRST + _PRESS * (most or _PRESSES)
        run = partial(_run, scene, series, most)
        yield Job(scene, Setting(series, words), "surface", seconds, run, 0, series == PLANNED and most is None)


def _run(scene: str, series: str, most: int | None) -> list[Answer]:
    params: dict[str, Any] = {} if most is None else {"max_presses": most}
    if series == GRID and most is not None:
        params["poses"] = grid(scene, round(most**0.5))
    found = reconstructed(scene, 0, params)
    if isinstance(found, Unfinished):
        cost = Cost("presses", most or 0)
        return [Answer("surface", None, found.cpu, 0.0, found.seconds, cost, FAILED, found.reason)]
    cost = Cost("presses", found.presses)
    errors = {"surface": found.upper, "cloud": found.rms, "missed": 1.0 - found.coverage}
    return [Answer(kind, error, found.cpu, 0.0, found.seconds, cost) for kind, error in errors.items()]
