"""Newton's method on energies whose minima are known, and first guesses from presses that lie on a line."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np

from stretch_bt.errors import NoEquilibrium
from stretch_bt.hardcases.expect import Refusal, Value
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.simulation.membrane.sheet.newton import Newton
from stretch_bt.simulation.membrane.sheet.predict import predict
from stretch_bt.simulation.membrane.sheet.problem import PROJECTED, Evaluation
from stretch_bt.simulation.membrane.sheet.result import Memory

Energy = Callable[[Any], tuple[Any, Any, Any]]


class _Toy:
    """Three unknowns of the same energy each, given as value, slope and curvature."""

    def __init__(self, energy: Energy, largest_step: float) -> None:
        self.energy, self.largest_step = energy, largest_step

    def bands(self) -> list[Any]:
        return [np.empty((3, 2)) for _ in range(2)]

    def evaluate(self, control: Any, mode: int, band: Any = None) -> Evaluation:
        value, slope, curvature = self.energy(control[1, 0])
        gradient = np.zeros_like(control)
        gradient[1, 0] = slope
        if band is not None:
            band[:, 0] += np.abs(curvature) if mode == PROJECTED else curvature
        return Evaluation(float(np.sum(value)), gradient, np.zeros((1, 8)), np.zeros(3))


def _spring(stiffness: float, middle: float) -> Energy:
    return lambda x: (
        0.5 * stiffness * (x - middle) ** 2,
        stiffness * (x - middle),
        np.full(3, stiffness),
    )


def _hill(x: Any) -> Any:
    """Two valleys at -1 and 1 with a hill between them."""
    return (x * x - 1) ** 2, 4 * x * (x * x - 1), 12 * x * x - 4


def _bowl(x: Any) -> Any:
    """A valley at 0 whose sides become straight: full steps from afar would lead ever farther off."""
    return np.log(np.cosh(x)), np.tanh(x), 1 / np.cosh(x) ** 2


def _slide(x: Any) -> Any:
    """No valley: ever deeper, ever flatter."""
    return np.exp(-x), -np.exp(-x), np.exp(-x)


def _minimum(start: float, *energies: Energy, budget: int = 60, largest_step: float = 10.0) -> list[float]:
    """Return where a minimisation ends that is run again for each energy."""
    control = np.zeros((3, 1, 3))
    control[1] = start
    problem: Any = _Toy(energies[0], largest_step)
    newton = Newton(problem, control)
    for energy in energies:
        problem.energy = energy
        found = newton.run(lambda step: step.size < 1e-9, budget).control[1, 0]
    assert (control[1] == start).all()
    return [float(x) for x in found]


def _guessed(change: float, aside: float = 0.0, before: float = 1.0) -> Any:
    """Return heights and offsets that a press is begun with, which goes by `change` after one that went by `before`."""
    old, previous = np.full((2, 2, 3), 2.0), np.full((2, 2, 3), 1.5)
    memory = Memory((3.0, 0.2), previous, (2.0, 0.5), np.array([0.0, before]))
    start: Any = SimpleNamespace(
        memory=memory,
        shape=SimpleNamespace(control=old, mesh=None),
        load=SimpleNamespace(moves=lambda: np.zeros(2), travel=1.0, hang=0.0, stretch=0.0),
    )
    layout: Any = SimpleNamespace(
        load=SimpleNamespace(moves=lambda: np.array([aside, change]), travel=1.0 + change, hang=0.0),
        fits=lambda start: True,
        drift=lambda start: 0.0,
        span=1.0,
        unit=1.0,
        sheet=SimpleNamespace(span=lambda stretch: 1.0, outline=SimpleNamespace(clamped=lambda mesh, c, span: c)),
    )
    _, control, offsets, kept = predict(layout, start)
    assert kept.previous is old
    assert kept.previous_offsets == memory.offsets
    assert kept.change is not None
    assert np.array_equal(kept.change, [aside, change])
    return [float(control[0, 0, 2]), *offsets]


CASES: tuple[Hard, ...] = (
    *group(
        "a start on a hill, far off, or with the factor of another energy has no step that leads straight down",
        {
            "from beside a hill": (partial(_minimum, 0.2, _hill), Value([1.0] * 3, abs=1e-9)),
            "from far up a side": (partial(_minimum, 6.0, _bowl), Value([0.0] * 3, abs=1e-9)),
            "in a spring": (partial(_minimum, 3.0, _spring(2.0, 1.0)), Value([1.0] * 3, abs=1e-12)),
            "in a spring that became a million times stiffer": (
                partial(_minimum, 0.0, _spring(1.0, 1.0), _spring(1e6, 1.5), largest_step=1e12),
                Value([1.5] * 3, abs=1e-9),
            ),
            "in a spring that became a million times softer": (
                partial(_minimum, 0.0, _spring(1.0, 1.0), _spring(1e-6, 1.5)),
                Value([1.5] * 3, abs=1e-6),
            ),
            "in a hill after a valley": (
                partial(_minimum, 0.3, _spring(1.0, 0.1), _hill),
                Value([1.0] * 3, abs=1e-9),
            ),
            "down a slope without end": (
                partial(_minimum, 0.0, _slide, budget=20),
                Refusal(NoEquilibrium, "within 20 iterations"),
            ),
        },
    ),
    *group(
        "a start is extrapolated only along the line of the last two presses, and no contact may pull",
        {
            "straight on": (partial(_guessed, 1.0), Value([2.5, 4.0, 0.0], abs=1e-12)),
            "half as far on": (partial(_guessed, 0.5), Value([2.25, 3.5, 0.05], abs=1e-12)),
            "back": (partial(_guessed, -1.0), Value([1.5, 2.0, 0.5], abs=1e-12)),
            "too far on": (partial(_guessed, 3.0), Value([8.0, 3.0, 0.2], abs=1e-12)),
            "elsewhere": (partial(_guessed, 1.0, 0.5), Value([4.0, 3.0, 0.2], abs=1e-12)),
            "after one that went nowhere": (partial(_guessed, 1.0, before=0.0), Value([4.0, 3.0, 0.2], abs=1e-12)),
        },
    ),
)
