"""Random blocks and discs under a membrane that resists bending: errors of their dimensions beside what is stated, and the coverage.

    python benchmarks/flat_tops.py [--bodies 20] [--first 0] [--keep FILE]

Sizes, heading, place, the radius of the edges (1 +- 0.2 mm, which the fit is given), the stretch of the mounts
and with it the length over which the sheet bends, the depths of the presses and all noise of the bench camera are drawn at random;
every effect that the scene calls for is on. Three presses each, from three poses, each looked at twice as the tree `reconstruct` does.
Errors are in mm, with `error / stated` beside each; `known` is the true share of the top that the map knows, `stated` the share it states.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from kept import kept

from stretch_bt.accuracy.twin.cell import Bench
from stretch_bt.errors import NoAnswer, NoEquilibrium
from stretch_bt.frames import DepthFrame, Pose
from stretch_bt.perception import Cloud, FreeView, fit_object, fuse_contact, without_pattern
from stretch_bt.perception.clouds.cloud import CELL
from stretch_bt.perception.clouds.coverage import coverage, hidden
from stretch_bt.perception.clouds.relief import Relief, add_view
from stretch_bt.perception.clouds.seen import view_of
from stretch_bt.perception.clouds.views import contact_of, surface_of
from stretch_bt.perception.solids.conformity import FILLET
from stretch_bt.perception.types import Contact
from stretch_bt.simulation.above import upper_surface
from stretch_bt.simulation.scene import Scene, parse_scene

MM = 1e3
EDGE_SD = 0.2e-3  # m, standard deviation of the edges about FILLET, which the fit is given
CLEAR, TRAVEL, PRESS, SETTLE = 0.030, 0.1, 0.005, 0.5  # m above the top, m/s, m/s, s
FREE, FRAMES = 24, 16
RISE = (0.12, 1.2e-3)  # share of the depth, and m, that the hand rises by between looks, at least
YAWS = (0.0, math.pi / 2, math.pi / 4)


@dataclass
class Found:
    """What came of a body: its kind, errors with their standard deviations, m, and coverage; or why nothing did."""

    text: str
    kind: str = ""
    errors: dict[str, tuple[float, float]] = field(default_factory=dict)
    told: float = 0.0
    stated: float = 0.0
    seconds: float = 0.0
    why: str = ""

    def __str__(self) -> str:
        if self.why:
            return self.why
        told = ", ".join(f"{name} {MM * off:+.2f} ({off / sd:+.1f})" for name, (off, sd) in self.errors.items())
        return f"{self.kind:12s} {100 * self.told:5.0f} {100 * self.stated:6.0f} {self.seconds:6.1f}  {told}"


def drawn(random: np.random.Generator) -> tuple[str, str]:
    """Return the kind of a random flat top, and its scene."""
    u, edge = random.uniform, MM * max(random.normal(FILLET, EDGE_SD), 0.3e-3)
    kind = "block" if random.random() < 0.75 else "disc"
    if kind == "block":
        sizes = f"type: box, length: {u(20, 55):.2f} mm, width: {u(18, 45):.2f} mm, edge: {edge:.2f} mm"
    else:
        sizes = f"type: cylinder, diameter: {u(18, 45):.2f} mm, rim: {edge:.2f} mm"
    return kind, (
        "format: stretch-scene/1\n"
        f"object: {{{sizes}, height: {u(25, 50):.2f} mm, heading: {u(-90, 90):.0f} deg, rigid: true, "
        f"position: {{x: {u(-3, 3):.2f} mm, y: {u(-3, 3):.2f} mm}}}}\n"
        f"hand: {{mount_prestretch: {u(10, 14):.2f} mm}}\n"
        "tolerance: {height: 0.3 mm, size: 1 mm}\n"
        f"conditions: {{depth: {u(6, 16):.2f} mm}}\n"
    )


def reconstructed(kind: str, text: str, seed: int) -> Found:
    """Return what three presses find of a body."""
    began, scene = time.process_time(), parse_scene(text)
    try:
        cloud, contacts, relief = pressed(scene, seed, scene.conditions.depth)
        solid = fit_object(cloud, contacts, fillet_sd=EDGE_SD, relief=relief)
    except (NoAnswer, NoEquilibrium) as error:
        return Found(text, why=str(error), seconds=time.process_time() - began)
    known = scene.object.known()
    known["height"] = scene.object.top
    if kind == "block":
        known["width"], known["length"] = sorted((known["length"], known["width"]))
    errors = {name: (d.value - known[name], d.sd) for name, d in solid.dimensions.items() if name in known}
    unseen = hidden(relief)
    top = upper_surface(scene.object)
    x, y = top.places.T
    told = relief.at(unseen.told, x, y, False)
    share = float(top.areas[told].sum() / top.areas.sum())
    return Found(text, solid.kind, errors, share, coverage(relief, unseen), time.process_time() - began)


def pressed(scene: Scene, seed: int, depth: float, presses: int = len(YAWS)) -> tuple[Cloud, list[Contact], Relief]:
    """Return what presses to a depth, m, over a body show of it: the cloud, its contacts and the map."""
    bench, cloud, contacts, relief = Bench(scene, seed), None, [], None
    bench.stretch(scene.conditions.stretch)
    x, y = scene.object.position.x, scene.object.position.y
    half = 0.5 * (bench.cell.hand.geometry.gauge + scene.conditions.stretch)
    for k, yaw in enumerate(YAWS[:presses]):
        at = Pose((x + (-3e-3, 0.0, 3e-3)[k], y + (2e-3, -3e-3, 0.0)[k], scene.object.top + CLEAR), (0.0, 0.0, yaw))
        deep, shallow = _looks(bench, at, depth)
        surface = surface_of(deep)
        assert deep.pose is not None
        assert shallow.pose is not None
        seen = view_of(surface, surface_of(shallow), deep_pose=deep.pose, shallow_pose=shallow.pose, half_length=half)
        relief = add_view(seen, relief)
        contact = contact_of(deep, surface, seen, relief)
        if contact is not None:
            contacts.append(contact)
            cloud = fuse_contact(contact, cloud, cell=CELL)
    if cloud is None or relief is None:
        raise NoAnswer("nothing was felt")
    return cloud, contacts, relief


def _looks(bench: Bench, above: Pose, depth: float) -> tuple[DepthFrame, DepthFrame]:
    """Return the membrane pressed to a depth, m, and a little higher, without the camera's static error."""
    bench.go(above, TRAVEL)
    geometry, free = bench.cell.hand.geometry, FreeView()
    for shot in bench.shots(FREE):
        free.add(shot)
    free.settle()
    pattern = free.pattern(geometry.gauge, width=geometry.width)
    seen = []
    for level in (depth, depth - max(RISE[0] * depth, RISE[1])):
        bench.go(above.at_height(bench.scene.object.top - level), PRESS)
        bench.time += SETTLE
        frame = bench.frame(FRAMES)
        seen.append(frame if pattern is None else without_pattern(frame, pattern))
    bench.go(above, TRAVEL)
    return seen[0], seen[1]


def rows(first: int, count: int, keep: Path | None) -> Iterator[tuple[str, Found]]:
    """Yield the results of bodies from a seed on; bodies that a file holds are not pressed again."""
    for _, (kind, found) in kept(_found, [(first + k,) for k in range(count)], keep):
        yield kind, Found(**found)


def _found(seed: int) -> tuple[str, dict[str, Any]]:
    """Return the kind of a body, and what came of it."""
    kind, text = drawn(np.random.default_rng(seed))
    return kind, asdict(reconstructed(kind, text, seed))


def main() -> None:
    """Print a line for each body, and the errors of all."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bodies", type=int, default=20)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--keep", type=Path, help="file of rows, to begin or to go on with")
    given = parser.parse_args()
    print("body   found        known stated  CPU s  errors, mm (over stated)")
    found = []
    for kind, one in rows(given.first, given.bodies, given.keep):
        print(f"{kind:6s} {one}", flush=True)
        found.append(one)
    good = [one for one in found if one.errors and not one.why]
    for name in dict.fromkeys(name for one in good for name in one.errors):
        offs, sds = np.array([one.errors[name] for one in good if name in one.errors]).T
        print(
            f"{name}: {len(offs)}, mean {MM * offs.mean():+.2f}, mean size {MM * np.abs(offs).mean():.2f}, largest "
            f"{MM * np.abs(offs).max():.2f} mm; rms over stated {np.sqrt(np.mean((offs / sds) ** 2)):.2f}, most {np.abs(offs / sds).max():.1f}"
        )
    told, stated = np.array([(one.told, one.stated) for one in good]).T
    print(
        f"coverage: known {100 * told.mean():.1f} %, stated {100 * stated.mean():.1f} %, {len(good)} of {len(found)} answered"
    )


if __name__ == "__main__":
    main()
