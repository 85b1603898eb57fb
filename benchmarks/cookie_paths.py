"""What a path and a force do to a cube of dough, without hand and camera: how fast it gets round in the reduced body.

    python benchmarks/cookie_paths.py [--seeds 1020-1043] [--paper 0-19]

First table: medians and 90th percentiles of the radius spread of drawn lumps (benchmarks/cookie.py), turned about the vertical by
chance, after travels that take 10 to 40 s at 30 mm/s. `a -> b` is the force over yield stress times the square of the ball's
radius, falling over so many m. `stiff k` is a hand whose force grows by k of that as the lump stands higher by the ball's
diameter, 4 of it at most. The bent eight was searched for on seeds 1000 to 1011. Second table: the paper's circle, rolled on for 120 s
whatever its stop rule says.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt
from cookie import ROUND, all_round, seeds

from stretch_bt.accuracy.cookie.lumps import draw
from stretch_bt.behaviors._rolling import PATHS
from stretch_bt.simulation.dough.lump import Lump, cube
from stretch_bt.simulation.dough.material import Dough

Array = npt.NDArray[np.float64]
Schedule = Callable[[float], float]

#: sines and cosines of one to four laps across and along, over half of the length: an eight that is bent
ACROSS = ((0.067, 0.402, -0.008, 0.018), (0.118, 0.024, 0.084, -0.053))
ALONG = ((0.954, 0.022, -0.037, 0.042), (0.092, 0.254, 0.002, -0.005))
LEG = 0.004  # m
SPEED = 0.030
WEIGHT = 1250 * 9.81
MARKS = (0.30, 0.45, 0.60, 0.90, 1.20)
MOST = 4.0


def laps(shape: str, size: float) -> Callable[[float], Array]:
    """Return the place (2,), m, of the hand after a travel, m, of a path."""
    lap = size * np.array(
        [(bent if shape == "bent" else PATHS[shape])(angle) for angle in np.linspace(0, 2 * math.pi, 361)]
    )
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(lap, axis=0), axis=1))])
    return lambda travel: np.array([np.interp(travel % along[-1], along, lap[:, c]) for c in (0, 1)])


def bent(angle: float) -> tuple[float, float]:
    """Return the place on the best of some 1000 closed paths tried at random around the eight."""
    across, along = (
        sum(a * math.sin(k * angle) + b * math.cos(k * angle) for k, (a, b) in enumerate(zip(*part, strict=True), 1))
        for part in (ACROSS, ALONG)
    )
    return across, along


def falling(hard: float, gentle: float, over: float) -> Schedule:
    """Return a force that falls from one to another over a travel, m."""
    return lambda travel: hard + (gentle - hard) * min(travel / over, 1.0)


def rolled(seed: int, shape: str, reach: float, force: Schedule, stiff: float, marks: Sequence[float]) -> list[Lump]:
    """Return the lump of a seed at travels, m, of a path whose size is `reach` radii of its ball."""
    lump = draw(seed)
    body = cube(lump.edge, heading=float(np.random.default_rng(seed).uniform(0, math.pi / 2)))
    dough, unit = Dough(lump.yield_stress, lump.modulus), lump.yield_stress * body.ball**2
    place, found, done = laps(shape, reach * body.ball), [], 0.0
    for mark in marks:
        while done < mark - 1e-9:
            then = min(done + LEG, mark)
            push = (
                min(max(force(done) + stiff * (body.height / (2 * body.ball) - 1), 0.1), max(MOST, force(done))) * unit
            )
            x, y = place(then) - place(done)
            body, _ = body.rolled((x, y), push, dough, weight=WEIGHT * body.volume, spin=lump.spin, seed=seed)
            done = then
        found.append(body)
    return found


def ways(chosen: Sequence[int]) -> None:
    """Print how paths, forces and stiffnesses of the hand compare."""
    fast = falling(2.0, 1.2, 1.0)
    rows = [
        ("circle of 15 mm", "circle", 1.0, fast, 0.0),
        ("eight, 3.5 radii", "eight", 3.5, fast, 0.0),
        ("bent eight, 3.9 radii", "bent", 3.9, fast, 0.0),
        ("bent eight, 3.5 radii", "bent", 3.5, fast, 0.0),
        *(
            (f"bent eight, {a} -> {b} in {c} m", "bent", 3.9, falling(a, b, c), 0.0)
            for a, b, c in ((2.5, 1.0, 0.5), (2.0, 0.8, 0.6), (1.5, 1.5, 1.0), (3.0, 1.2, 0.5))
        ),
        *(
            (f"bent eight, 1.5 -> 1.0, stiff {k}", "bent", 3.9, falling(1.5, 1.0, 1.0), float(k))
            for k in (0, 10, 20, 40)
        ),
    ]
    print(f"{len(chosen)} lumps; spread after m" + "".join(f"{m:14.2f}" for m in MARKS))
    for name, shape, reach, force, stiff in rows:
        spread = np.array([[b.roundness for b in rolled(s, shape, reach, force, stiff, MARKS)] for s in chosen])
        cells = (f"{np.median(c):.3f} / {np.percentile(c, 90):.3f}" for c in spread.T)
        print(f"{name:34s} " + " ".join(cells), flush=True)


def rolled_on(chosen: Sequence[int]) -> None:
    """Print when the paper's circle and the bent eight make lumps round."""
    marks = tuple(np.arange(0.15, 3.6 + 1e-9, 0.15))
    print(
        f"\n{len(chosen)} lumps, 120 s at {1e3 * SPEED:g} mm/s: reach a circularity of {ROUND} over all axes; quartiles of when, s"
    )
    for name, shape, reach, force in (
        *((f"circle of about 15 mm, {g}", "circle", 1.0, falling(g, g, 1.0)) for g in (0.83, 1.2)),
        ("bent eight, 2 -> 1.2", "bent", 3.9, falling(2.0, 1.2, 1.0)),
    ):
        times = [_first(rolled(s, shape, reach, force, 0.0, marks), marks) for s in chosen]
        quarters = np.percentile(times, (25, 50, 75), method="lower")
        print(
            f"{name:34s} {sum(map(math.isfinite, times))} of {len(times)}; " + ", ".join(f"{t:.1f}" for t in quarters),
            flush=True,
        )


def _first(bodies: Sequence[Lump], marks: Sequence[float]) -> float:
    return next((m / SPEED for b, m in zip(bodies, marks, strict=True) if all_round(b) >= ROUND), math.inf)


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seeds", type=seeds, default=seeds("1020-1043"))
    parser.add_argument("--paper", type=seeds, default=seeds("0-19"))
    given = parser.parse_args()
    ways(given.seeds)
    rolled_on(given.paper)


if __name__ == "__main__":
    main()
