"""Both cookies' paths in a material-point model: does the reduced body of the twin rank them alike?

    python benchmarks/dough_mpm.py [--seeds 1-3] [--cells 6] [--hand membrane plate] [--on] [--nominal] [--convergence 4 6 8] [--check]

For each drawn lump (benchmarks/cookie.py) both trees run in the twin, with its spin noise. Their path and the force on the arm,
averaged over 1.5 s, then roll a cube of material points of the same edge, yield stress and modulus, at a speed at which inertia is a
fiftieth of the yield stress, between a table and a hand that both grip it: a soft foundation as in the reduced body, without the
membrane's tension, or a flat plate. Nothing is fitted. The end is pressed between plates to half of its height, with a friction
of 0.3. With `--nominal` both bodies roll without a run in the twin: under 1 Y R^2 for 0.57 m on the circle, and 2 falling to
1.2 Y R^2 in 1 m for 1.2 m on the eight; `gentler` is 1.2 falling to 0.7.

Both bodies are read alike: the radius from fourth moments up to the 8th harmonic (a cube has a spread of 0.104, and 0.945 as the
mean circularity over 12 axes), beside the circularity of the outline after the press: for the twin the sector model's outline, for the
points the pressed one. `--on` rolls the circle on over the travel of the fast tree, at its last force. `volume` is the volume of
the convex hull: the points' own volumes do not show how they drift apart.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from cookie import FAST, PAPER, Watch, all_round, low_pass, seeds
from mpm.body import Body, Hand, Stuff
from mpm.shape import hull_volume, lump_of, pressed_circularity, smoothed

from stretch_bt import run
from stretch_bt.accuracy.cookie.lumps import Draw, draw, scene
from stretch_bt.behaviors._rolling import PATHS
from stretch_bt.runtime.record import RecordReader
from stretch_bt.simulation.dough.lump import Lump, cube
from stretch_bt.simulation.dough.material import Dough

Array = npt.NDArray[np.float64]

GENTLE = "gentler"
HANDS = {"membrane": Hand(), "plate": Hand(float("inf"))}
LEG = 0.003  # m
MEAN = 1.5  # s over which the force is averaged: about a turn of the lump
FLAT, FRICTION = 0.5, 0.3
SPEED = 0.030  # m/s of both trees
CIRCLE, REACH = 0.015, 3.5  # of the paper's path, m, and the fast tree's over the radius of the ball


#: force over yield stress times the square of the ball's radius, at first and in the end, the travel, m, over which it falls, and the travel
NOMINAL = {PAPER: (1.0, 1.0, 1.0, 0.57), FAST: (2.0, 1.2, 1.0, 1.2), GENTLE: (1.2, 0.7, 1.0, 1.2)}


@dataclass(frozen=True)
class Rolled:
    """What a tree did and got in the twin: way (m, 2), m, and force (m,), N, of each leg; the lump at the stop."""

    ways: Array
    forces: Array
    lump: Lump
    low_pass: float

    @property
    def travel(self) -> float:
        """Of the hand, m."""
        return len(self.ways) * LEG


class Stop(Watch):
    """Keeps the lump as it rolled last."""

    lump: Lump

    def write(self, key: str, value: Any, sd: float | None, path: str) -> None:
        """Take it whenever the time of rolling is written."""
        super().write(key, value, sd, path)
        if key.endswith("rolling_time") and self.at_stop:
            self.lump = self.twin.world._past[-1].thing.rolled


def in_twin(tree: str, seed: int) -> Rolled:
    """Run a tree on the lump of a seed."""
    lump, watch = draw(seed), Stop()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scene.yaml"
        path.write_text(scene(lump), encoding="utf-8")
        run(tree, scene=path, seed=seed, out=Path(folder) / "record", watch=watch.follow)
        times, felt, begin = forces_of(RecordReader(Path(folder) / "record"))
    legs = int(SPEED * watch.rolled / LEG)
    middle = begin + (np.arange(legs) + 0.5) * LEG / SPEED
    forces = np.array([felt[np.abs(times - t) <= MEAN / 2].mean() for t in middle])
    ways = legs_of(tree, Body(lump.edge, stuff(lump), 1).ball, legs)
    return Rolled(ways, np.maximum(forces, 0.0), watch.lump, watch.at_stop["low_pass"])


def nominal(tree: str, seed: int) -> Rolled:
    """Roll the reduced body alone over a tree's median travel, without spin noise, under a force that is given by its group."""
    lump, (hard, gentle, over, travel) = draw(seed), NOMINAL[tree]
    body = cube(lump.edge)
    legs = int(travel / LEG)
    ways = legs_of(tree, body.ball, legs)
    part = np.minimum((np.arange(legs) + 0.5) * LEG / over, 1.0)
    forces = (hard + (gentle - hard) * part) * lump.yield_stress * body.ball**2
    dough, weight = Dough(lump.yield_stress, lump.modulus), 1250 * 9.81 * body.volume
    for way, force in zip(ways, forces, strict=True):
        body, _ = body.rolled((float(way[0]), float(way[1])), float(force), dough, weight=weight)
    return Rolled(ways, forces, body, low_pass(body))


def forces_of(record: RecordReader) -> tuple[Array, Array, float]:
    """Return times, s, and forces along the hand's axis, N, that were read, and when rolling began."""
    begin = next(float(e["time"]) for e in record.events if e["type"] == "write" and str(e["key"]).endswith("begin"))
    found = [
        (time, reading.value.force[2])
        for tick, time in record.ticks
        for _, name, reading in record.readings(tick, frames=False)
        if name == "wrench" and time >= begin
    ]
    times, felt = np.array(found).T
    return times, felt, begin


def legs_of(tree: str, ball: float, count: int) -> Array:
    """Return legs (count, 2), m, of a tree's path."""
    shape, size = ("circle", CIRCLE) if tree == PAPER else ("eight", min(REACH * ball, 0.060))
    angles = np.linspace(0, 2 * np.pi, 721)
    lap = size * np.array([PATHS[shape](angle) for angle in angles])
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(lap, axis=0), axis=1))])
    marks = LEG * np.arange(count + 1)
    places = np.column_stack([np.interp(marks % along[-1], along, lap[:, c]) for c in (0, 1)])
    return np.asarray(np.diff(places, axis=0))


def stuff(lump: Draw) -> Stuff:
    """Return the material of a drawn lump."""
    return Stuff(lump.yield_stress, lump.modulus)


@dataclass(frozen=True)
class Read:
    """Radius spread, mean circularity of outlines over all axes, circularity after the press, volume over the cube's, CPU time, s."""

    spread: float
    all_round: float
    pressed: float
    volume: float
    seconds: float

    def __str__(self) -> str:
        return f"{self.spread:.3f} {self.all_round:.3f} {self.pressed:.3f}  volume {self.volume:.3f}, {self.seconds:5.1f} CPU s"


def in_points(lump: Draw, ways: Array, forces: Array, hand: Hand, cells: int) -> Read:
    """Roll and press a cube of material points in the same way."""
    start = time.process_time()
    body = Body(lump.edge, stuff(lump), cells)
    body.settle(float(forces[0]), hand)
    body.roll(ways, forces, hand)
    star, volume = lump_of(body), hull_volume(body)
    body.press(FLAT * body.height, FRICTION)
    return Read(star.roundness, all_round(star), pressed_circularity(body), volume, time.process_time() - start)


def on(rolled: Rolled, travel: float, ball: float) -> tuple[Array, Array]:
    """Return the circle rolled on to a travel, m, with the force that it had last."""
    count = max(int(travel / LEG), len(rolled.ways))
    more = np.full(count - len(rolled.ways), rolled.forces[-50:].mean())
    return legs_of(PAPER, ball, count), np.concatenate([rolled.forces, more])


def compare(
    seed: int, cells: int, hands: Sequence[str], further: bool, of: Callable[[str, int], Rolled]
) -> dict[str, bool]:
    """Print what a lump becomes in both models; return for each hand whether the ranking holds."""
    lump = draw(seed)
    twin = {tree: of(tree, seed) for tree in (NOMINAL if of is nominal else (PAPER, FAST))}
    ratio = lump.modulus / lump.yield_stress
    print(f"\nseed {seed}: edge {1e3 * lump.edge:.1f} mm, Y {lump.yield_stress / 1e3:.1f} kPa, E/Y {ratio:.0f}")
    print("                                travel, m  force, N   spread all-round pressed")
    for tree, rolled in twin.items():
        star = smoothed(rolled.lump)
        read = f"{star.roundness:.3f} {all_round(star):.3f} {rolled.low_pass:.3f}"
        print(f"  {tree:17s} reduced body  {rolled.travel:8.2f}  {rolled.forces.mean():8.2f}   {read}", flush=True)
    held = {}
    for name in hands:
        rows = {tree: in_points(lump, r.ways, r.forces, HANDS[name], cells) for tree, r in twin.items()}
        if further:
            ways, forces = on(twin[PAPER], twin[FAST].travel, twin[PAPER].lump.ball)
            rows["paper's on"] = in_points(lump, ways, forces, HANDS[name], cells)
        for tree, row in rows.items():
            print(f"  {tree:17s} points, {name:8s}                      {row}", flush=True)
        held[name] = rows[FAST].spread < rows[PAPER].spread and rows[FAST].all_round > rows[PAPER].all_round
    return held


def convergence(seed: int, hand: str, sizes: Sequence[int], of: Callable[[str, int], Rolled]) -> None:
    """Print what finer clouds make of one lump."""
    lump = draw(seed)
    twin = {tree: of(tree, seed) for tree in (NOMINAL if of is nominal else (PAPER, FAST))}
    print(f"\nresolution, seed {seed}, {hand}: cells an edge, points; spread, all-round, pressed")
    for cells in sizes:
        for tree, rolled in twin.items():
            read = in_points(lump, rolled.ways, rolled.forces, HANDS[hand], cells)
            print(f"  {cells:3d} {(2 * cells) ** 3:6d}  {tree:17s} {read}", flush=True)


def check(cells: int) -> None:
    """Print the pressure on a cube between smooth plates over its yield stress, which is 1 however far it is pressed."""
    print("a cube pressed between plates without friction, part of its height: pressure over yield stress")
    for part in (0.9, 0.7, 0.5):
        body = Body(0.025, Stuff(5e3, 1e5), cells)
        force = body.press(part * body.edge, 0.0)
        area = body.edge**3 / body.height
        print(
            f"  {body.height / body.edge:.3f}  {force / area / 5e3:.3f}  volume of the points {body.contents.mean():.4f}"
        )


def main() -> None:
    """Print the comparison, and whether the ranking of the trees holds."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seeds", type=seeds, default=seeds("1-3"))
    parser.add_argument("--cells", type=int, default=6)
    parser.add_argument("--hand", nargs="*", choices=list(HANDS), default=list(HANDS))
    parser.add_argument(
        "--convergence", nargs="*", type=int, metavar="CELLS", help="these resolutions of the first seed alone"
    )
    parser.add_argument("--on", action="store_true", help="roll the paper's circle on over the travel of the fast tree")
    parser.add_argument("--nominal", action="store_true", help="forces by their group in place of a run in the twin")
    parser.add_argument("--check", action="store_true", help="press a cube between smooth plates alone")
    given = parser.parse_args()
    if given.check:
        check(given.cells)
        return
    of = nominal if given.nominal else in_twin
    if given.convergence:
        convergence(given.seeds[0], given.hand[0], given.convergence, of)
        return
    held = [compare(seed, given.cells, given.hand, given.on, of) for seed in given.seeds]
    for name in given.hand:
        print(
            f"\n{name}: rounder by spread and all round after the fast tree's path: {sum(h[name] for h in held)} of {len(held)}"
        )


if __name__ == "__main__":
    main()
