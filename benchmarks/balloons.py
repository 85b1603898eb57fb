"""The balloons: the solver of the cap against its mesh and against closed forms, the table it ships, and the four scenes.

    python -m benchmarks.balloons [facts] [mesh] [interpolation] [gas] [shape] [scenes] [ladder] [table]

`table` solves the caps of the shipped table again and writes it; it runs only where it is named. Times are CPU time of one thread.
"""

from __future__ import annotations

import json
import math
import statistics
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import NoEquilibrium
from stretch_bt.simulation.balloons import table
from stretch_bt.simulation.balloons.cap import HAND, PLATE, Cap, CapState
from stretch_bt.simulation.balloons.fills import cap_volume
from stretch_bt.simulation.balloons.filling import Filling, Gas, Liquid
from stretch_bt.simulation.effects.active import Active
from stretch_bt.simulation.objects.balloon import BalloonObject

Array = npt.NDArray[np.float64]

RADIUS, PRESSURE = 0.030, 3983.0  # mu 0.3 MPa, 0.2 mm thick at rest, stretched by 2.5
SCENES = ("air_balloon", "water_balloon", "pudding_balloon", "seeds_balloon")
KAPPA = 2.0 ** np.arange(-2, 9)
DROPS = np.geomspace(0.005, 0.5, 24)
COARSE, FINE = 96, 192
BETA = 0.05  # at which the yielding of a gas is tabulated


def presses(cap: Cap, drops: Array) -> list[CapState]:
    """Return the states at rising drops, m, until there is none."""
    found: list[CapState] = []
    for drop in drops:
        try:
            found.append(cap.press(float(drop), found[-1] if found else None))
        except NoEquilibrium:
            break
    return found


def gas_of(beta: float) -> Gas:
    """Return a gas of this softness in a cap of radius and pressure 1, as much below the rim as above."""
    return Gas(cap_volume(1.0), 1.0, 2 / beta - 1)


def flat_radius(state: CapState) -> float:
    """Return the radius, m, of the circle through the profile where the hand touches it, each ring with its area."""
    place = np.linspace(0.0, state.contact_radius, 201)
    r, z = place, np.interp(place, *state.nodes[: 1 + int(np.argmax(state.nodes[:, 0]))].T)
    weight = np.sqrt(r + 1e-9)[:, None]
    found = np.linalg.lstsq(np.stack([2 * z, np.ones_like(z)], 1) * weight, (r**2 + z**2) * weight[:, 0], rcond=None)[0]
    return float(math.sqrt(found[1] + found[0] ** 2))


def row(kappa: float) -> dict[str, Array | float]:
    """Return one row of the table: force without mesh error by Richardson, yielding, flattening, and the limit."""
    coarse = presses(Cap(1.0, 1.0, hand=kappa, elements=COARSE), DROPS)
    fine = presses(Cap(1.0, 1.0, hand=kappa, elements=FINE), DROPS)
    gas = presses(Cap(1.0, 1.0, hand=kappa, elements=FINE, filling=gas_of(BETA)), DROPS)
    reached = [s for s in fine if s.contact_radius < 1.0]
    count = min(len(coarse), len(reached), len(gas))
    rough = np.array([s.force for s in coarse[:count]])
    force = np.array([s.force for s in fine[:count]])
    return {
        "limit": float(DROPS[count - 1]),
        "force": force + (force - rough) / 3,
        "yields": (force / np.array([s.force for s in gas[:count]]) - 1) / BETA,
        "flattening": np.maximum.accumulate([flat_radius(s) - 1 for s in fine[:count]]),
    }


def continued(values: Array, *, grows: bool) -> Array:
    """Return a row for all drops: past its end as the power law of its last two points, or as its last value."""
    power = math.log(values[-1] / values[-2]) / math.log(DROPS[1] / DROPS[0]) if grows else 0.0
    beyond = DROPS[len(values) :] / DROPS[len(values) - 1]
    return np.concatenate([values, values[-1] * beyond**power])


def make_table() -> None:
    began = time.process_time()
    rows = [row(float(kappa)) for kappa in KAPPA]
    made: dict[str, Any] = {
        "made_by": "python -m benchmarks.balloons table",
        "prestretch": table.PRESTRETCH,
        "kappa": KAPPA.tolist(),
        "drop": [float(f"{x:.9g}") for x in DROPS],
        "limit": [r["limit"] for r in rows],
    }
    for name in ("force", "yields", "flattening"):
        made[name] = [[float(f"{x:.6g}") for x in continued(np.asarray(r[name]), grows=name == "force")] for r in rows]
    path = Path(table.__file__).parent / "data" / "cap.json"
    path.parent.mkdir(exist_ok=True)
    text = json.dumps(made).replace("], [", "],\n  [").replace(', "', ',\n "')
    path.write_text(text + "\n", encoding="utf-8")
    print(f"{path}: {len(KAPPA)} x {len(DROPS)}, limits {[round(r, 3) for r in made['limit']]}, "
          f"{time.process_time() - began:.1f} s")


if __name__ == "__main__":
    make_table()
