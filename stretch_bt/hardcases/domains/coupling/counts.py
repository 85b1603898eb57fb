"""How often laws are asked, against laws that count: each answer of a membrane's law may be a press of its own."""

from __future__ import annotations

from functools import partial

from stretch_bt.hardcases.domains.coupling.series import KINDS, TRAVEL, power, thing
from stretch_bt.hardcases.expect import Check
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.simulation.coupling import couple

#: evaluations that a solve reports, how many depths the membrane's law was asked for, and how often
Counts = tuple[int, int, int]


def _counted(kind: str, start: float | None = None) -> list[Counts]:
    """Return counts for objects from 1e-3 to 1e3 times the membrane's stiffness."""
    found = []
    for exponent in range(-3, 4):
        asked = list[float]()

        def membrane(depth: float, asked: list[float] = asked) -> tuple[float, float]:
            asked.append(depth)
            return power(1.0 / TRAVEL**1.5)(depth)

        law, kinks = thing(kind, 10.0**exponent / TRAVEL)
        took = couple(membrane, law, TRAVEL, kinks=kinks, start=start).iterations
        found.append((took, len(set(asked)), len(asked)))
    return found


def _are_counts(found: list[Counts]) -> bool:
    """Whether each count is at least the number of different depths and at most the number of all."""
    return all(different <= took <= asked for took, different, asked in found)


def _known(near: float) -> int:
    """Return how many evaluations a solve takes from a drop that is off by a part."""
    law, membrane = thing("elastic", 1.0 / TRAVEL)[0], power(1.0 / TRAVEL**1.5)
    drop = couple(membrane, law, TRAVEL).drop
    return couple(membrane, law, TRAVEL, near=drop * (1 + near)).iterations


CASES: tuple[Hard, ...] = (
    *group(
        "the next solve is planned by the evaluations that the last one reports",
        {
            f"counted, {kind}{'' if start is None else ', from where it was'}": (
                partial(_counted, kind, start),
                Check("as many evaluations as the membrane's law gave answers", _are_counts),
            )
            for kind in KINDS
            for start in (None, 0.3 * TRAVEL)
        },
        {
            "near the drop": (partial(_known, 1e-3), Check("at most 3 evaluations", lambda n: 1 <= n <= 3)),
            "at the drop": (partial(_known, 0.0), Check("one evaluation", lambda n: n == 1)),
        },
    ),
)
