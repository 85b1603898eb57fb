"""The roundness of rolled lumps over how many directions their radius is known in."""

from __future__ import annotations

import time
from collections.abc import Iterator
from functools import lru_cache, partial
from itertools import product
from statistics import median
from typing import NamedTuple

import numpy as np

from stretch_bt.accuracy.dough.rolling import roll, tumbled
from stretch_bt.accuracy.job import Job
from stretch_bt.accuracy.points import REFERENCE, Answer, Setting
from stretch_bt.simulation.dough.material import Dough
from stretch_bt.simulation.objects.dough import DoughObject

__all__ = ["KNOWN", "jobs", "warm"]

EDGE, YIELD = 0.025, 5e3  # m, Pa
COUNTS, REFERENCES = (100, 200, 500, 1000, 2000), (8000, 4000)
DEFAULT = int(DoughObject.model_fields["directions"].default)
TRAVEL = 2.0  # m
SPIN, GROUP = 0.1, 0.83  # spin noise, and force over the yield stress times the square of the ball's radius
#: of a separate code of the same model: medians of 30 lumps after 2 and 4 m
KNOWN = {
    ("circle", 0.0): (0.098, 0.093),
    ("circle", 0.1): (0.094, 0.088),
    ("circle", 0.5): (0.066, 0.047),
    ("eight", 0.0): (0.043, 0.024),
    ("eight", 0.1): (0.043, 0.025),
    ("eight", 0.5): (0.051, 0.034),
}
_KNOWN_ERROR = 0.004  # scatter of the medians of other 30 lumps
_LUMPS = 15


class Rolling(NamedTuple):
    """A lump that is rolled: modulus over yield stress, and how it lies."""

    path: str
    ratio: float
    seed: int

    def __str__(self) -> str:
        return f"{self.path}, 2 m, E/Y {self.ratio:g}, lump {self.seed}"


ROLLINGS = [Rolling(*of) for of in product(("eight", "circle"), (20.0, 10.0, 30.0), range(4))]


def warm() -> None:
    """Roll a lump a little."""
    roll(tumbled(EDGE, COUNTS[0], 0), "eight", [0.05], Dough(YIELD, 20 * YIELD), 1.0, SPIN, 0)


def jobs() -> Iterator[Job]:
    """Yield each lump with each count of directions, and the medians that another program knows."""
    for rolling in ROLLINGS:
        case = str(rolling)
        own = Setting("reference", "8000 directions")
        yield Job(case, own, "spread", 2.0, partial(_own, rolling), group=case, once=True)
        for count in COUNTS:
            setting = Setting("reduced body", f"{count} directions")
            run = partial(_rolled, rolling, count)
            yield Job(case, setting, "spread", 0.1 + count * 1e-4, run, rolling.seed, count == DEFAULT, case)
    for (kind, spin), known in KNOWN.items():
        for number, figure in enumerate(known):
            case = f"{kind}, {2 * (number + 1)} m, spin {spin:g}, median of {_LUMPS} lumps"
            run = partial(_known, kind, spin, number, figure)
            setting = Setting("against another program", f"{DEFAULT} directions")
            yield Job(case, setting, "known_spread", 3.0, run, once=True)


def _roundness(rolling: Rolling, count: int) -> tuple[float, float]:
    """Return the roundness after the travel, and CPU time, s."""
    lump, dough = tumbled(EDGE, count, rolling.seed), Dough(YIELD, rolling.ratio * YIELD)
    force = GROUP * YIELD * lump.ball**2
    began = time.process_time()
    found, _, _ = roll(lump, rolling.path, [TRAVEL], dough, force, SPIN, rolling.seed)
    return found[0], time.process_time() - began


@lru_cache(maxsize=1)
def _reference(rolling: Rolling) -> tuple[float, float, float]:
    (right, seconds), (other, _) = (_roundness(rolling, count) for count in REFERENCES)
    return right, abs(other - right), seconds


def _own(rolling: Rolling) -> list[Answer]:
    _, own, seconds = _reference(rolling)
    return [Answer("spread", own, seconds, own, status=REFERENCE)]


def _rolled(rolling: Rolling, count: int) -> list[Answer]:
    right, own, _ = _reference(rolling)
    found, seconds = _roundness(rolling, count)
    return [Answer("spread", abs(found - right), seconds, own)]


def _known(kind: str, spin: float, number: int, figure: float) -> list[Answer]:
    found, seconds = _medians(kind, spin)
    return [Answer("known_spread", abs(found[number] - figure), seconds, _KNOWN_ERROR)]


@lru_cache(maxsize=2)
def _medians(kind: str, spin: float) -> tuple[list[float], float]:
    """Return the medians of the roundness after 2 and 4 m, and the median CPU time, s, of a lump."""
    chance = np.random.default_rng(0)
    rows, seconds = [], []
    for seed in range(_LUMPS):
        edge, stress, ratio = chance.choice([0.020, 0.025, 0.030]), chance.uniform(3e3, 10e3), chance.uniform(10, 30)
        lump = tumbled(float(edge), DEFAULT, seed)
        began = time.process_time()
        dough, force = Dough(stress, ratio * stress), GROUP * stress * lump.ball**2
        rows.append(roll(lump, kind, [2.0, 4.0], dough, force, spin, seed)[0])
        seconds.append(time.process_time() - began)
    return [float(value) for value in np.median(rows, axis=0)], median(seconds)
