"""How fast the sheet solver converges, on a round membrane, to the shooting solution of the same membrane.

    python -m benchmarks.membrane_order [flat] [weight] [contact [SMALLEST]]

Each line halves every element of the one before. `contact` goes down to SMALLEST times the default element, 0.25 unless
given; 0.125 takes 1 GB and some minutes. Theory: an energy converges with twice the order of its elements' slopes, 4 for
quadratic splines, while the solution is smooth. Under an indenter the curvature jumps at the edge of the contact, which
crosses the elements: the solution is in H^2.5 only, and its energy converges with order 3.
"""

from __future__ import annotations

import math
import sys
import time
from typing import Any

import numpy as np

from stretch_bt.simulation.membrane.axisymmetric import CircularMembrane
from stretch_bt.simulation.membrane.indenters.base import Zone
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.materials import NeoHookean
from stretch_bt.simulation.membrane.materials.base import energy, tensions
from stretch_bt.simulation.membrane.round_sheet import RoundSheet
from stretch_bt.simulation.membrane.sheet.effects import Effects
from stretch_bt.simulation.membrane.sheet.newton import Newton
from stretch_bt.simulation.membrane.sheet.problem import Problem
from stretch_bt.simulation.membrane.sheet.settings import Settings

RUBBER = NeoHookean(1.0)
SPHERE = 0.2  # radius of the sphere over the clamp's radius
DENSITY = 0.05  # hangs by 0.11 of the radius


def order(errors: list[float]) -> str:
    """Return the order of the last halving, or of none."""
    return f"{math.log2(abs(errors[-2] / errors[-1])):5.2f}" if len(errors) > 1 else "    -"


def hanging(membrane: RoundSheet, elements: int) -> tuple[float, float]:
    """Return energy and sag of a membrane under its own weight, or flat if it has none, on even elements."""
    sheet = membrane.sheet
    zone = [Zone(-50.0, 50.0, 100 / elements)]
    mesh = sheet.outline.mesh(100.0, zone, zone, 1.0)
    problem = Problem(mesh, sheet.law(), [], sheet.unit)
    problem.weight = sheet.weight
    start = sheet.outline.flat(mesh, sheet.span(0.0))
    start[1:-1, 1:-1, 2] = -3.0 if sheet.weight else 0.0
    found = Newton(problem, start).run(lambda step: step.size < 1e-9, 100)
    sag = -mesh.evaluate(found.control, np.zeros(1), np.zeros(1))[0, 0, 2]
    return found.evaluation.energy * sheet.force_unit * sheet.unit, float(sag) * sheet.unit


def flat() -> None:
    """Print how exactly an even stretch is met."""
    print("evenly stretched, relative error of the energy")
    for prestretch in (1.05, 1.2, 1.5):
        exact = math.pi / prestretch**2 * energy(RUBBER, prestretch, prestretch)
        errors = [hanging(RoundSheet(1.0, 1.0, RUBBER, prestretch), n)[0] / exact - 1 for n in (6, 12, 24)]
        print(f"  l0 {prestretch}: " + ", ".join(f"{e:+.0e}" for e in errors) + " on 6, 12 and 24 elements")


def hung(prestretch: float, load: float) -> tuple[float, float]:
    """Return energy and sag of the same membrane by shooting from the pole; lengths over the clamp's radius."""
    from scipy.integrate import solve_ivp
    from scipy.optimize import brentq

    def rates(s: float, state: Any) -> list[float]:
        l1, l2, z = state[:3]
        n1, n2, a11, a12 = tensions(RUBBER, l1, l2)
        sine = load * s / (2 * n1)  # what hangs inside of s
        cosine = math.sqrt(1 - sine * sine)
        hoop = (l1 * cosine - l2) / s
        along = ((n2 * cosine - n1) / s + load * sine - a12 * hoop) / a11
        return [along, hoop, l1 * sine, 2 * math.pi * s * (energy(RUBBER, l1, l2) + load * z)]

    def shoot(pole: float) -> Any:
        first, end = 1e-6, 1 / prestretch
        return solve_ivp(rates, (first, end), [pole, pole, 0.0, 0.0], method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]

    pole = brentq(lambda v: shoot(v)[1] - prestretch, prestretch, 1.3 * prestretch, xtol=1e-14)
    end = shoot(pole)
    return float(end[3] - math.pi / prestretch**2 * load * end[2]), float(end[2])


def weight() -> None:
    """Print the order where nothing touches and all is smooth."""
    print("hanging under its weight: elements, relative error and order of energy and of sag")
    for prestretch in (1.05, 1.2, 1.5):
        membrane = RoundSheet(1.0, 1.0, RUBBER, prestretch, Effects(sag=DENSITY))
        exact = hung(prestretch, DENSITY * 9.81)
        errors: tuple[list[float], list[float]] = ([], [])
        for n in (4, 8, 16, 32, 64):
            for kept, found, true in zip(errors, hanging(membrane, n), exact, strict=True):
                kept.append(found / true - 1)
            cells = "   ".join(f"{kept[-1]:+.2e} {order(kept)}" for kept in errors)
            print(f"  l0 {prestretch} n {n:3d}: {cells}")


def contact(smallest: float) -> None:
    """Print the order under a sphere."""
    print(f"sphere of {SPHERE} of the clamp's radius: energy of the press (less the flat sheet's energy) and force")
    for prestretch in (1.05, 1.2, 1.5):
        still = math.pi / prestretch**2 * energy(RUBBER, prestretch, prestretch)
        for depth in (0.1, 0.3):
            true = CircularMembrane(1.0, 1.0, RUBBER, prestretch).press(SPHERE, depth)
            errors: tuple[list[float], list[float]] = ([], [])
            scale = 2.0
            while scale >= smallest:
                began = time.process_time()
                # growth to the power of the scale makes every element follow, not only the smallest
                settings = Settings(coarsen=scale, growth=1.6**scale)
                found = RoundSheet(1.0, 1.0, RUBBER, prestretch).press(Sphere(2 * SPHERE), depth, settings=settings)
                errors[0].append((found.energy - true.energy) / (true.energy - still))
                errors[1].append(float(found.force[2]) / true.force - 1)
                cells = "   ".join(f"{kept[-1]:+.2e} {order(kept)}" for kept in errors)
                size = found.shape.mesh.finest * found.sheet.unit
                print(
                    f"  l0 {prestretch} depth {depth} smallest element {size:.4f}: {cells}"
                    f"   stated {found.force_error / found.force[2]:.1e}, {time.process_time() - began:.1f} s",
                    flush=True,
                )
                scale /= 2


def main() -> None:
    """Run the parts that are named, or all."""
    names = sys.argv[1:] or ["flat", "weight", "contact"]
    smallest = next((float(n) for n in names if n[0].isdigit()), 0.25)
    if "flat" in names:
        flat()
    if "weight" in names:
        weight()
    if "contact" in names:
        contact(smallest)


if __name__ == "__main__":
    main()
