"""The balloons: the solver of the cap against its mesh and against closed forms, the table it ships, and the four scenes.

    python -m benchmarks.balloons [loads] [mesh] [interpolation] [gas] [shape] [scenes] [ladder] [table]

`table` solves the caps of the shipped table again and writes it; it runs only where it is named. Times are CPU time of one thread.
"""

from __future__ import annotations

import json
import math
import statistics
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import NoEquilibrium
from stretch_bt.simulation.balloons import table
from stretch_bt.simulation.balloons.balance import CapState
from stretch_bt.simulation.balloons.cap import HAND, PLATE, Cap
from stretch_bt.simulation.balloons.filling import Filling, Gas, Liquid
from stretch_bt.simulation.balloons.fills import cap_volume
from stretch_bt.simulation.objects.balloon import BalloonObject
from stretch_bt.simulation.scene import load_scene

Array = npt.NDArray[np.float64]

RADIUS, PRESSURE = 0.030, 3983.0  # mu 0.3 MPa, 0.2 mm thick at rest, stretched by 2.5
SCENES = ("air_balloon", "water_balloon", "pudding_balloon", "seeds_balloon")
KAPPA = 2.0 ** np.arange(-2, 9)
PARTS_OF_LIMIT = np.concatenate([np.geomspace(0.02, 0.72, 22), np.linspace(0.76, 1.0, 9)])
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


def reaching(kappa: float) -> float:
    """Return the drop at which the hand reaches the rim, for a cap of radius and pressure 1."""
    cap = Cap(1.0, 1.0, hand=kappa, elements=COARSE)
    low, high, state = 1e-3, 1.0, cap.press(1e-3)
    while high - low > 1e-5:
        middle = (low + high) / 2 if high < 1.0 else min(1.1 * low, 0.99)
        try:
            found = cap.press(middle, state)
        except NoEquilibrium:
            high = middle
            continue
        if found.contact_radius < 1.0:
            low, state = middle, found
        else:
            high = middle
    return low


def row(kappa: float) -> dict[str, Array | float]:
    """Return one row of the table: the limit, force without mesh error by Richardson, yielding, and flattening."""
    limit = reaching(kappa)
    fine = presses(Cap(1.0, 1.0, hand=kappa, elements=FINE), PARTS_OF_LIMIT * limit)
    gas = presses(Cap(1.0, 1.0, hand=kappa, elements=FINE, filling=gas_of(BETA)), PARTS_OF_LIMIT * limit)
    force = np.array([s.force for s in fine])
    return {
        "limit": limit,
        "force": exact(PARTS_OF_LIMIT * limit, 1.0, 1.0, hand=kappa),
        "yields": (force / np.array([s.force for s in gas]) - 1) / BETA,
        "flattening": np.maximum.accumulate([flat_radius(s) - 1 for s in fine]),
    }


def make_table() -> None:
    began = time.process_time()
    rows = [row(float(kappa)) for kappa in KAPPA]
    made: dict[str, Any] = {
        "made_by": "python -m benchmarks.balloons table",
        "prestretch": table.PRESTRETCH,
        "kappa": KAPPA.tolist(),
        "part": [float(f"{x:.9g}") for x in PARTS_OF_LIMIT],
        "limit": [float(f"{r['limit']:.6g}") for r in rows],
    }
    for name in ("force", "yields", "flattening"):
        made[name] = [[float(f"{x:.6g}") for x in np.asarray(r[name])] for r in rows]
    path = Path(table.__file__).parent / "data" / "cap.json"
    path.parent.mkdir(exist_ok=True)
    text = json.dumps(made).replace("], [", "],\n  [").replace(', "', ',\n "')
    path.write_text(text + "\n", encoding="utf-8")
    print(
        f"{path}: {len(KAPPA)} x {len(PARTS_OF_LIMIT)}, limits {[round(r, 3) for r in made['limit']]}, "
        f"{time.process_time() - began:.1f} s"
    )


def exact(drops: Array, radius: float, pressure: float, filling: Filling | None = None, hand: float = HAND) -> Array:
    """Return forces (n,), N, without the error of the mesh: by Richardson from meshes of 96 and 192."""
    fill = filling or Liquid()
    coarse, fine = (
        np.array([s.force for s in presses(Cap(radius, pressure, filling=fill, hand=hand, elements=n), drops)])
        for n in (COARSE, FINE)
    )
    return np.asarray(fine + (fine - coarse) / 3)


def show_loads() -> None:
    """Print the force under plate and hand beside the force from an independent solver of 24 rings."""
    volume = cap_volume(RADIUS)
    fills: dict[str, Filling] = {
        "constant pressure": Gas(1.0),
        "air, isothermal": Gas(volume),
        "air, adiabatic": Gas(volume, 1.4),
        "water": Liquid(),
    }
    plate = {"constant pressure": (0.03, 0.10, 0.20), "air, isothermal": (0.39, 1.10, 2.22)}
    plate |= {"air, adiabatic": (0.39, 1.12, 2.27), "water": (0.41, 1.17, 2.40)}
    hand = {"air, isothermal": (1.15, 2.78, 4.23), "air, adiabatic": (1.14, 2.74, 4.15), "water": (1.11, 2.65, 3.96)}
    print(f"{'force N':18s} plate at 2, 4, 6 mm (independent)         hand, at its drops for 0.43, 1.6, 3.5 N")
    for name, fill in fills.items():
        found = exact(_mm(2, 4, 6), RADIUS, PRESSURE, fill, PLATE)
        text = "  ".join(f"{f:.3f} ({g:.2f})" for f, g in zip(found, plate[name], strict=True))
        if name in hand:
            pressed = exact(_mm(*hand[name]), RADIUS, PRESSURE, fill)
            text += "      " + "  ".join(f"{f:.3f}" for f in pressed)
        print(f"{name:18s} {text}")


def show_mesh() -> None:
    """Print the error of the force by the number of elements, the CPU time of a press, and energy against force."""
    drops = _mm(0.5, 1.5, 3.0, 4.0)
    for what, hand in (("hand", HAND), ("plate", PLATE)):
        right = exact(drops, RADIUS, PRESSURE, hand=hand)
        print(f"\n{what}: error % at drops of 0.5, 1.5, 3, 4 mm (forces {', '.join(f'{f:.3f}' for f in right)} N)")
        for n in (12, 24, 48, 96, 192):
            cap = Cap(RADIUS, PRESSURE, hand=hand, elements=n)
            cap.press(0.5e-3)
            began = time.process_time()
            found = presses(cap, drops)
            each = (time.process_time() - began) / len(drops)
            errors = "  ".join(f"{100 * (s.force / f - 1):7.3f}" for s, f in zip(found, right, strict=True))
            print(f"  N {n:4d}  {errors}   {each * 1e3:6.1f} ms a press")
    cap, step = Cap(RADIUS, PRESSURE), 1e-5
    middle = cap.press(2e-3)
    low, high = cap.press(2e-3 - step, middle), cap.press(2e-3 + step, middle)
    work = (low.hand - high.hand) * middle.force
    print(f"\nenergy gained over the work of the hand, less 1: {(high.energy - low.energy) / work - 1:.1e}")
    slope = (high.force - low.force) / (2 * step)
    print(f"slope of the force over the difference of two presses, less 1: {middle.stiffness / slope - 1:.1e}")


def show_interpolation() -> None:
    """Print how far the table is from the solver at places between its own, and what a call costs."""
    rng, errors = np.random.default_rng(0), []
    for kappa in np.exp(rng.uniform(math.log(0.7), math.log(64), 24)):
        cap = table.read_table().at(float(kappa))
        drops = np.sort(rng.uniform(0.01, 0.98 * cap.limit, 6))
        right = exact(drops, 1.0, 1.0, hand=float(kappa))
        errors += [abs(cap.force(float(x))[0] / f - 1) for x, f in zip(drops, right, strict=False)]
    law = load_scene("water_balloon").object
    assert isinstance(law, BalloonObject)
    each = _cost(partial(law.law, 1.5e-3))
    print(
        f"{len(errors)} presses between the table's own: median {100 * statistics.median(errors):.3f} %, "
        f"95 % within {100 * float(np.quantile(errors, 0.95)):.2f} %, largest {100 * max(errors):.2f} %; {each * 1e6:.1f} us a force and slope"
    )


def show_gas() -> None:
    """Print what the rule F / (1 + beta s) leaves, by the softness beta of the gas, over kappa and drop."""
    for beta in (0.02, 0.04, 0.08, 0.16, 0.32):
        errors, taken = [], []
        for kappa in (1.0, 2.0, 4.0, 8.0):
            cap = table.read_table().at(kappa)
            drops = np.linspace(0.02, 0.9 * cap.limit, 6)
            liquid = exact(drops, 1.0, 1.0, hand=kappa)
            gas = exact(drops, 1.0, 1.0, gas_of(beta), kappa)
            rule = liquid / (1 + beta * np.array([cap.yields(float(x))[0] for x in drops]))
            errors.append(np.abs(rule / gas - 1).max())
            taken.append((1 - gas / liquid).max())
        print(
            f"beta {beta:.2f}: takes off up to {100 * max(taken):5.1f} %; the rule is off by at most {100 * max(errors):.2f} %"
        )


def show_shape() -> None:
    """Print the flattened top: its radius, how far it is from a sphere where the hand touches, and the contact radius."""
    for name, pressure in (("air, 2 kPa", 2e3), ("water, 4 kPa", 4e3)):
        for state in presses(Cap(RADIUS, pressure, elements=FINE), _mm(0.5, 1.0, 1.5, 2.0, 3.0, 4.0)):
            radius = flat_radius(state)
            r, z = state.nodes[state.nodes[:, 0] <= state.contact_radius].T
            off = z - z[0] + radius - np.sqrt(radius**2 - r**2)
            print(
                f"{name:12s} drop {state.drop * 1e3:.1f} mm: radius {radius * 1e3:5.1f} mm, "
                f"within {np.ptp(off) / 2 * 1e3:.3f} mm of it out to {state.contact_radius * 1e3:.1f} mm"
            )


def show_scenes() -> None:
    """Print the stiffness of the four balloons, settled and on first loading, and the ratios of neighbours."""
    drops = (1.0, 1.5, 2.0, 3.0)
    print("stiffness N/mm at drops of " + ", ".join(f"{d:g}" for d in drops) + " mm, and ratio to the balloon before")
    before: list[float] = []
    for name in SCENES:
        found = [_balloon(name).secant(d * 1e-3) / 1e3 for d in drops]
        ratios = [f"{a / b:.2f}" for a, b in zip(found, before, strict=False)]
        print(f"{name:16s} {'  '.join(f'{k:.3f}' for k in found)}   {'  '.join(ratios)}")
        before = found


def show_ladder() -> None:
    """Print the force of the water balloon by each model, its error, and the CPU time of a force and slope."""
    drops = _mm(0.5, 1.5, 3.0, 4.0)
    spec = _balloon("water_balloon")
    right = exact(drops, spec.radius, spec.pressure)
    rungs: list[tuple[str, dict[str, Any]]] = [("linear", {"model": "linear"}), ("table", {})]
    rungs += [(f"axisymmetric {n}", {"model": "axisymmetric", "elements": n}) for n in (24, 48, 96)]
    print("error % at drops of 0.5, 1.5, 3, 4 mm")
    for name, change in rungs:
        law = spec.model_copy(update=change).law
        began = time.process_time()
        found = [law(float(d))[0] for d in drops]
        cost = (time.process_time() - began) / len(drops)
        if not name.startswith("axi"):
            cost = _cost(partial(law, 1.5e-3))
        print(
            f"{name:16s} {'  '.join(f'{100 * (f / g - 1):7.2f}' for f, g in zip(found, right, strict=True))}   {cost * 1e6:9.1f} us"
        )


def _balloon(name: str) -> BalloonObject:
    spec = load_scene(name).object
    assert isinstance(spec, BalloonObject)
    return spec


def _mm(*values: float) -> Array:
    return np.array(values) * 1e-3


def _cost(work: Callable[[], object], count: int = 2000) -> float:
    """Return the median CPU time, s, of one call."""
    found = []
    for _ in range(7):
        began = time.process_time()
        for _ in range(count):
            work()
        found.append((time.process_time() - began) / count)
    return statistics.median(found)


PARTS = {
    "loads": show_loads,
    "mesh": show_mesh,
    "interpolation": show_interpolation,
    "gas": show_gas,
    "shape": show_shape,
    "scenes": show_scenes,
    "ladder": show_ladder,
}


def main() -> None:
    """Run the parts that are named, all but the making of the table where none is."""
    parts = {**PARTS, "table": make_table}
    for name in sys.argv[1:] or PARTS:
        print(f"== {name}")
        parts[name]()


if __name__ == "__main__":
    main()
