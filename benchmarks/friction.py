"""Friction of the membrane on its indenters, and indenters given by a height field: effect, errors and cost.

    python -m benchmarks.friction

Times are process CPU time of one thread.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from stretch_bt.simulation.membrane.indenters.height_field import HeightField
from stretch_bt.simulation.membrane.press import PressResult, press
from stretch_bt.simulation.membrane.sheet.effects import Effects
from stretch_bt.simulation.membrane.sheet.result import SheetPress
from stretch_bt.simulation.membrane.sheet.settings import Settings


def rub(mu: float, indenter: str = "sphere:20mm", depth: float = 0.01, **options: Any) -> PressResult:
    """Return a press at 30 mm stretch with friction."""
    return press(indenter, 0.03, depth, effects=Effects(friction=mu), **options)


def forces() -> None:
    print("change of force by friction, %, 10 mm deep; on elements half as long; CPU s, and without friction")
    for indenter in ("sphere:20mm", "cylinder:20mm", "cube:20mm", "cone:45deg"):
        free = press(indenter, 0.03, 0.01)
        for mu in (0.1, 0.3, 0.5, 1.0, 10.0):
            found = rub(mu, indenter)
            line = f"  {indenter}, mu {mu}: {(found.force / free.force - 1) * 100:+.2f}"
            if indenter == "sphere:20mm":
                fine = Settings(coarsen=0.5)
                half = rub(mu, settings=fine).force / press(indenter, 0.03, 0.01, settings=fine).force
                line += f", {(half - 1) * 100:+.2f}"
            print(f"{line}; {found.seconds:.2f} s, {free.seconds:.2f} s; balance {found.balance:.0e}")


def increments() -> None:
    print("change of force at 10 mm from increments of 1 mm to shorter ones, %")
    for mu in (0.3, 1.0):
        usual = rub(mu).force
        for length in (0.5e-3, 0.25e-3):
            state = None
            for depth in np.arange(1, round(0.01 / length) + 1) * length:
                state = rub(mu, depth=float(depth), start=state)
            assert state is not None
            print(f"  mu {mu}, {length * 1e3:g} mm: {(state.force / usual - 1) * 100:+.3f}")


def drag() -> None:
    print("dragged by 12 mm and back, half the difference of both drags in the middle, over force and over mu")
    for indenter, depth in (("sphere:20mm", 0.006), ("cylinder:20mm", 0.004)):
        for mu in (0.1, 0.3):
            middle = []
            state = rub(mu, indenter, depth, at=(-0.006, 0.0))
            for x in (-0.003, 0.0, 0.003, 0.006, 0.003, 0.0):
                state = rub(mu, indenter, depth, at=(x, 0.0), start=state)
                if x == 0.0:
                    assert isinstance(state.detail, SheetPress)
                    middle.append(state.detail.force)
            ratio = (middle[0][0] - middle[1][0]) / (middle[0][2] + middle[1][2])
            even = (middle[0][0] + middle[1][0]) / (middle[0][0] - middle[1][0])
            print(f"  {indenter}, mu {mu}: {ratio / mu:.3f}; what does not reverse: {even * 100:+.1f} %")


def height_fields() -> None:
    print("height field of a sphere of 20 mm over 17 x 17 mm: force over the sphere's, %; CPU ms and the sphere's")
    for pitch in (0.25e-3, 0.5e-3, 1e-3):
        x = np.arange(-0.0085, 0.0085 + pitch / 2, pitch)
        away = np.hypot(*np.meshgrid(x, x))
        cap = np.sqrt(np.maximum(1e-4 - away**2, 0.0))
        field = HeightField(np.where(away < 0.009, cap, 4.36e-3 - 2.06 * (away - 0.009)), pitch)
        cases: tuple[dict[str, Any], ...] = ({}, {"at": (0.012, 0.009)}, {"tilt": (0.2, -0.1)})
        for options in cases:
            found, sphere = (press(i, 0.03, 0.008, **options) for i in (field, "sphere:20mm"))
            off, ms = (found.force / sphere.force - 1) * 100, (found.seconds * 1e3, sphere.seconds * 1e3)
            print(f"  pitch {pitch * 1e3:g} mm, {options or 'centred'}: {off:+.2f}; {ms[0]:.0f}, {ms[1]:.0f}")


if __name__ == "__main__":
    forces()
    increments()
    drag()
    height_fields()
