"""Control of a hand that feels nothing, too much, or that cannot go lower."""

from __future__ import annotations

from functools import partial

from stretch_bt.hardcases.expect import Check, Value
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.model.control.level import LOST, MOST_STEP, PATIENCE, STIFFNESS, ForceKeeper
from stretch_bt.model.control.thickness import CLOSE, LEAST_STEP, MOST_STEPS, Step, next_step

START, LOWEST, WANTED = 0.030, 0.026, 1.0
THICK, HAND, BOTTOM = 0.030, 0.025, 0.010
NOTHING, LITTLE = 0.0, 2 * LOST * WANTED


def _kept(start: float, felt: list[float]) -> ForceKeeper:
    keeper = ForceKeeper(start)
    for force in felt:
        keeper.keep(WANTED, force, LOWEST)
    return keeper


def _lost(start: float, felt: list[float]) -> bool:
    return _kept(start, felt).is_lost


def _height(felt: list[float]) -> float:
    return _kept(START, felt).height


def _crept(stiffness: float) -> float:
    """Return the force on an elastic object after 100 steps over the wanted one."""
    keeper = ForceKeeper(START)
    for _ in range(100):
        keeper.keep(WANTED, stiffness * max(START - keeper.height, 0.0), 0.0)
    return stiffness * (START - keeper.height) / WANTED


def _step(over: float, limited: bool, steps: int, hand: float) -> Step:
    return next_step(THICK + over, THICK, hand, BOTTOM, limited=limited, steps=steps)


def _is(ended: str, height: float) -> Check:
    said = f"it ended by {ended}" if ended else f"on to {height * 1e3:g} mm"
    return Check(said, lambda step: (step.ended or "") == ended and abs(step.height - height) < 1e-12)


def _pressed(share: float, over: float) -> tuple[bool, bool, str]:
    """Return whether a press took few steps and left enough, and how it ended, where the membrane takes a share of the way."""
    hand, top, steps = HAND, THICK + over, 0
    while True:
        step = next_step(top, THICK, hand, 0.0, limited=False, steps=steps)
        if step.ended:
            return steps <= MOST_STEPS, top >= THICK - LEAST_STEP, step.ended
        top -= (1 - share) * (hand - step.height)
        hand, steps = step.height, steps + 1


#: force felt, and the height of the hand after it
LEVELS = {
    "the wanted force": (WANTED, START),
    "too little force": (WANTED - 0.3, START - 0.3 / STIFFNESS),
    "too much force": (WANTED + 0.3, START + 0.3 / STIFFNESS),
    "50 N too much": (WANTED + 50.0, START + MOST_STEP),
}
#: start, forces felt, and whether it is lost
LOSSES = {
    "nothing for a lap": (LOWEST, [NOTHING] * PATIENCE, True),
    "nothing for nearly a lap": (LOWEST, [NOTHING] * (PATIENCE - 1), False),
    "little for three laps": (LOWEST, [LITTLE] * 3 * PATIENCE, False),
    "felt again within each lap": (LOWEST, ([NOTHING] * (PATIENCE - 1) + [LITTLE]) * 3, False),
    "nothing on the way down": (START, [NOTHING] * PATIENCE, False),
    "nothing down there": (START, [NOTHING] * 2 * PATIENCE, True),
}
#: how much thicker, m, whether force was limited, steps so far, the hand's height, m; how it ended, and the next height, m
STEPS: dict[str, tuple[float, bool, int, float, str, float]] = {
    "just thin enough": (CLOSE - 1e-9, False, 1, HAND, "thickness", HAND),
    "too thin": (-0.002, False, 1, HAND, "thickness", HAND),
    "thin enough, however it came there": (0.0, True, MOST_STEPS, BOTTOM, "thickness", BOTTOM),
    "force limited": (0.004, True, 1, HAND, "force", HAND),
    "force limited at the bottom": (0.004, True, MOST_STEPS, BOTTOM, "force", BOTTOM),
    "at the bottom": (0.004, False, 1, BOTTOM, "depth", BOTTOM),
    "after all steps": (0.004, False, MOST_STEPS, HAND, "depth", HAND),
    "before the last step": (0.004, False, MOST_STEPS - 1, HAND, "", HAND - 0.004),
    "far too thick": (0.040, False, 1, HAND, "", BOTTOM),
}

CASES: tuple[Hard, ...] = (
    *group(
        "a hand that keeps its force on a rolling lump may lose it, or be pushed up at once",
        {name: (partial(_height, [felt]), Value(height, rel=1e-9)) for name, (felt, height) in LEVELS.items()},
        {name: (partial(_lost, start, felt), Value(lost)) for name, (start, felt, lost) in LOSSES.items()},
        {f"an object of {k:g} N/m": (partial(_crept, k), Value(1.0, abs=0.01)) for k in (100.0, 300.0, 550.0)},
        {"never below the lowest height": (partial(_height, [NOTHING] * 100), Value(LOWEST, rel=1e-12))},
        prefix="level, ",
    ),
    *group(
        "a press to a thickness ends by thickness, force or depth, whichever comes first",
        {
            name: (partial(_step, over, limited, steps, hand), _is(ended, height))
            for name, (over, limited, steps, hand, ended, height) in STEPS.items()
        },
        {
            f"the membrane takes {share:g} of the way, {1e3 * over:g} mm over": (
                partial(_pressed, share, over),
                Value((True, True, ended)),
            )
            for share, over, ended in ((0.0, 0.01, "thickness"), (0.4, 0.01, "thickness"), (1.0, 0.01, "depth"))
        },
        prefix="thickness, ",
    ),
)
