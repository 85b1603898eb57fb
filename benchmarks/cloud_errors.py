"""Errors of the points of a cloud that were felt, over what is stated, by where they lie about the edges of a top.

    python benchmarks/cloud_errors.py [--bodies 30] [--first 1000] [--presses 3]

Blocks, discs, half-cylinders (about their ends) and polyhedra of random sizes, headings, edges of 0.3 to 2 mm, stretches of 10 to 60 mm and
depths, under a sheet that bends, with the noise of the bench camera; the presses of `flat_tops.py`. An error is the distance to the
undeformed surface, root mean square over points, then over bodies with ten of them. `noise` is this error over noise and floor alone,
`stated` over what the cloud states. A side is towards a clamp or a free side of the first press. Last comes how far inside an
edge the bend over it ends, as `stand_off.py` has it: of points outside of edges, by how much it is bent.
"""

from __future__ import annotations

import argparse
import math
import tempfile
from collections import defaultdict
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from flat_tops import MM, pressed
from reconstruct import _polyhedron

from stretch_bt.errors import NoAnswer, NoEquilibrium
from stretch_bt.perception.clouds.relief import carved
from stretch_bt.perception.clouds.stand_off import ends_of_bends, with_stand_off
from stretch_bt.simulation.above import distances
from stretch_bt.simulation.objects.base import ObjectSpec
from stretch_bt.simulation.scene import Scene, load_scene

KINDS = ("block", "block", "disc", "half_cylinder", "polyhedron")
BENDS = (6, 12, 25, 50, 100, 300)  # 1/m
CORNER = 3e-3  # m to both sides within which a point is at a corner
FEWEST = 10  # points


def drawn(seed: int, folder: Path) -> tuple[str, Scene]:
    """Return the kind of a random body, and its scene."""
    random = np.random.default_rng(seed)
    kind, u = KINDS[seed % len(KINDS)], random.uniform
    if kind == "block":
        sizes = (
            f"type: box, length: {u(18, 50)} mm, width: {u(15, 40)} mm, height: {u(25, 50)} mm, edge: {u(0.3, 2)} mm"
        )
    elif kind == "disc":
        sizes = f"type: cylinder, diameter: {u(16, 42)} mm, height: {u(25, 50)} mm, rim: {u(0.3, 2)} mm"
    elif kind == "half_cylinder":
        sizes = f"type: half_cylinder, diameter: {u(30, 50)} mm, length: {u(25, 50)} mm, edge: {u(0.3, 2)} mm"
    else:
        _polyhedron(random).export(folder / f"{seed}.stl")
        sizes = f"type: mesh, file: {seed}.stl, edge: 0.5 mm"
    path = folder / f"{seed}.yaml"
    path.write_text(
        f"format: stretch-scene/1\nobject: {{{sizes}, heading: {u(-90, 90)} deg, rigid: true, "
        f"position: {{x: {u(-3, 3)} mm, y: {u(-3, 3)} mm}}}}\nhand: {{mount_prestretch: {u(10, 14)} mm}}\n"
        f"tolerance: {{height: 0.3 mm, size: 1 mm}}\nconditions: {{stretch: {u(10, 60)} mm, depth: {u(5, 14)} mm}}\n"
    )
    return kind, load_scene(path)


def inside(kind: str, body: Any, points: Any) -> tuple[Any, Any, Any]:
    """Return how far points (n, 3) lie inside the outline of a top (n,), m, which at a corner, and which by a side towards a clamp."""
    away, c, s = points[:, :2] - [body.position.x, body.position.y], math.cos(body.heading), math.sin(body.heading)
    x, y = away @ [c, s], away @ [-s, c]
    if kind == "disc":
        return body.diameter / 2 - np.hypot(x, y), np.zeros(len(x), bool), np.abs(away[:, 1]) > np.abs(away[:, 0])
    dx = body.length / 2 - np.abs(x)
    dy = body.width / 2 - np.abs(y) if kind == "block" else np.full(len(x), np.inf)
    corner = np.maximum(np.abs(dx), np.abs(dy)) < CORNER
    depth = np.where((dx < 0) & (dy < 0), -np.hypot(dx, np.where(np.isinf(dy), 0.0, dy)), np.minimum(dx, dy))
    return depth, corner, np.where(dx < dy, abs(s) > abs(c), abs(c) > abs(s))


def strata(kind: str, body: ObjectSpec, points: Any) -> Iterator[tuple[str, Any]]:
    """Yield the names of strata and which points (n, 3) lie in them."""
    if kind == "polyhedron":
        yield "all", np.ones(len(points), bool)
        return
    depth, corner, clamp = inside(kind, body, points)
    yield "inside by > 3 mm", (depth > 3e-3) & ~corner
    for name, low, high in (("inside by 1 to 3 mm", 1, 3), ("inside by < 1 mm", 0, 1), ("outside", -99, 0)):
        there = (depth > low / MM) & (depth <= high / MM) & ~corner
        yield f"{name}, clamp", there & clamp
        yield f"{name}, free side", there & ~clamp
    yield "outside by > 1 mm", (depth < -1e-3) & ~corner
    yield "corner, inside", corner & (depth > 0)
    yield "corner, outside", corner & (depth <= 0)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    for name, value in (("bodies", 30), ("first", 1000), ("presses", 3)):
        parser.add_argument(f"--{name}", type=int, default=value)
    given = parser.parse_args()
    rows: dict[tuple[str, str], list[Any]] = defaultdict(list)
    ends: list[Any] = []
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(given.first, given.first + given.bodies):
            kind, scene = drawn(seed, Path(folder))
            try:
                depth = min(scene.conditions.depth, scene.object.top / 2)
                cloud, _, relief = pressed(scene, seed, depth, given.presses)
                cloud = with_stand_off(carved(cloud, relief), relief)
            except (NoAnswer, NoEquilibrium) as error:
                print(f"{seed} {kind}: {error}")
                continue
            off = distances(scene.object, cloud.points)
            for name, there in strata(kind, scene.object, cloud.points):
                if there.sum() >= FEWEST:
                    own = np.stack([off, off / cloud.scatter_sd, off / cloud.sd])[:, there]
                    rows[kind, name].append([there.sum(), *np.mean(own**2, axis=1), np.mean(cloud.sd[there])])
            if kind in ("block", "disc"):
                depth, corner, _ = inside(kind, scene.object, cloud.points)
                way, bend = (each[0] for each in ends_of_bends(cloud.points, relief))
                ends.append(np.stack([way + depth, bend])[:, (way > 0) & (depth < 0.5e-3) & ~corner])
    print("body           where                           bodies  points  error mm  noise  stated  sd mm")
    for (kind, name), found in sorted(rows.items()):
        count, off2, noise2, stated2, sd = np.array(found).T
        rms = (f"{np.sqrt(v.mean()):7.2f}" for v in (off2 * MM**2, noise2, stated2))
        print(f"{kind:13s}  {name:30s}  {len(count):6d} {count.sum():7.0f}  {'  '.join(rms)} {MM * sd.mean():6.2f}")
    way, bend = np.concatenate(ends, axis=1)
    for low, high in pairwise(BENDS):
        there = MM * way[(bend > low) & (bend <= high)]
        if len(there) >= FEWEST:
            print(
                f"bend of {low} to {high} 1/m ends {there.mean():.2f} +- {there.std():.2f} mm inside, {len(there)} points"
            )


if __name__ == "__main__":
    main()
