"""Errors of fused clouds and of the dimensions measured in them; run as `python benchmarks/perception_objects.py [draws]`."""

from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.frames import Pose
from stretch_bt.perception import Cloud, Contact, cloud_of, fuse_contact, measure_object

Array = npt.NDArray[np.float64]
MM = 1e3
PITCH = 0.5e-3  # m
X, Y, Z = np.eye(3)
PLACE = (0.1, -0.2, 0.0)


def contact(
    pose: Pose, surface: Callable[[Array, Array], Array], noise: float, rng: np.random.Generator, flying: float = 0.0
) -> Contact:
    """Return a contact of 40 mm across with a world surface z(x, y), seen by a camera 200 mm above the hand."""
    side = np.arange(-0.02, 0.02, 0.42e-3)
    x, y = (v.ravel() for v in np.meshgrid(side, side))
    z = np.zeros_like(x)
    for _ in range(30):
        world = np.column_stack([x, -y, z]) @ pose.matrix().T + pose.position
        z += surface(world[:, 0], world[:, 1]) - world[:, 2]
    points = np.column_stack([x, y, z])
    rays = points - [0.0, 0.0, 0.2]
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    error = rng.normal(0.0, noise, len(x))
    wild = rng.random(len(x)) < flying
    error[wild] -= rng.uniform(5e-3, 15e-3, int(wild.sum()))
    points += rays * (error / np.abs(rays[:, 2]))[:, None]
    labels = np.full((2, 2), 2, np.uint8)
    return Contact(points, rays, labels, noise, pose.height, 0.0, 0.0, np.zeros((2, 2, 3)), pose)


def any_pose(rng: np.random.Generator, tilt: float = 0.2) -> Pose:
    """Return a pose near the place of the objects, tilted by about `tilt` and turned at will."""
    x, y = rng.uniform(-8e-3, 8e-3, 2)
    return Pose((PLACE[0] + x, PLACE[1] + y, 0.04), (*rng.normal(0.0, tilt, 2), rng.uniform(-1.0, 1.0)))


def _grid(width: float, height: float) -> tuple[Array, Array]:
    u, v = (np.arange(-s / 2 + PITCH / 2, s / 2, PITCH) for s in (width, height))
    mesh = np.meshgrid(u, v)
    return mesh[0].ravel(), mesh[1].ravel()


def _seen(points: Array, normals: Array, noise: float, yaw: float, rng: np.random.Generator) -> Cloud:
    """Return points with noise along rays between straight down and straight at the surface, turned by `yaw`."""
    rays = -0.6 * normals - 0.8 * Z
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    turn = np.array([[np.cos(yaw), -np.sin(yaw), 0.0], [np.sin(yaw), np.cos(yaw), 0.0], Z])
    return cloud_of(
        (points + rays * rng.normal(0.0, noise, (len(points), 1))) @ turn.T + PLACE, noise, rays=rays @ turn.T
    )


def block(
    size: tuple[float, float, float],
    noise: float,
    rng: np.random.Generator,
    *,
    flanks: tuple[int, ...] = (0, 1, 2, 3),
    down: float = 15e-3,
    edge: float = 2e-3,
    yaw: float = 0.3,
) -> Cloud:
    """Return the top of a block on the table and the upper part of its flanks, edges rounded as a membrane leaves them."""
    a, b, h = size
    u, v = _grid(a, b)
    parts = [np.outer(u, X) + np.outer(v, Y) + h * Z]
    for k in flanks:
        out = (X, -X, Y, -Y)[k]
        u, v = _grid(b if k < 2 else a, down)
        parts.append(
            np.outer(u, np.cross(Z, out)) + np.outer(v, Z) + (a if k < 2 else b) / 2 * out + (h - down / 2) * Z
        )
    points = np.vstack(parts)
    low, high = [-a / 2 + edge, -b / 2 + edge, 0.0], [a / 2 - edge, b / 2 - edge, h - edge]
    core = np.clip(points, low, high)
    normals = (points - core) / np.linalg.norm(points - core, axis=1, keepdims=True)
    return _seen(core + edge * normals, normals, noise, yaw, rng)


def half_cylinder(radius: float, length: float, noise: float, rng: np.random.Generator, *, yaw: float = 0.3) -> Cloud:
    """Return the round side of a half cylinder that lies on the table, but for its lowest part, and its two ends."""
    turn, along = (
        v.ravel() for v in np.meshgrid(np.arange(0.15, np.pi - 0.15, PITCH / radius), _grid(length, PITCH)[0])
    )
    normals = np.column_stack([np.cos(turn), 0 * turn, np.sin(turn)])
    parts, directions = [radius * normals + np.outer(along, Y)], [normals]
    u, v = _grid(2 * radius, 2 * radius)
    inside = (np.hypot(u, v) < radius - 1e-3) & (v > 0.3 * radius)
    for sign in (-1, 1):
        parts.append(np.outer(u[inside], X) + np.outer(v[inside], Z) + sign * length / 2 * Y)
        directions.append(np.tile(sign * Y, (int(inside.sum()), 1)))
    return _seen(np.vstack(parts), np.vstack(directions), noise, yaw, rng)


OBJECTS: dict[str, tuple[tuple[float, float, float], Callable[..., Cloud]]] = {
    "cube, 4 flanks": ((0.04, 0.04, 0.04), lambda n, r, y: block((0.04, 0.04, 0.04), n, r, yaw=y)),
    "cube, 8 mm down": ((0.04, 0.04, 0.04), lambda n, r, y: block((0.04, 0.04, 0.04), n, r, yaw=y, down=8e-3)),
    "cube, 3 flanks": ((0.04, 0.04, 0.04), lambda n, r, y: block((0.04, 0.04, 0.04), n, r, yaw=y, flanks=(0, 1, 2))),
    "cube, top alone": ((0.04, 0.04, 0.04), lambda n, r, y: block((0.04, 0.04, 0.04), n, r, yaw=y, flanks=())),
    "block 60 20 30": ((0.06, 0.02, 0.03), lambda n, r, y: block((0.06, 0.02, 0.03), n, r, yaw=y)),
    "half cylinder": ((0.06, 0.04, 0.02), lambda n, r, y: half_cylinder(0.02, 0.06, n, r, yaw=y)),
}


def dimension_rows(draws: int) -> Iterator[str]:
    yield "dimensions, edges rounded by 2 mm: error and its spread, stated deviation, shortness stated, mm"
    yield "noise mm  object            axis     how                      error  spread  stated   short     ms"
    for noise in (0.05e-3, 0.3e-3, 1e-3):
        for name, (truth, make) in OBJECTS.items():
            found, times = [], []
            for seed in range(draws):
                rng = np.random.default_rng(seed)
                cloud = make(noise, rng, rng.uniform(-1.5, 1.5))
                start = time.process_time()
                found.append(measure_object(cloud))
                times.append(1e3 * (time.process_time() - start))
            for k, axis in enumerate(("length", "width", "height")):
                yield f"{noise * MM:8.2f}  {name:16s}  {axis:7s}  {_axis_row(found, k, truth[k])}  {np.median(times):5.0f}"


def _axis_row(found: list[Any], k: int, truth: float) -> str:
    how = " ".join(f"{name} {count}" for name, count in sorted(Counter(d.how[k] for d in found).items()))
    error = np.array([d.lengths[k] - truth for d in found]) * MM
    stated, short = (np.mean([getattr(d, what)[k] for d in found]) * MM for what in ("sd", "short"))
    return f"{how:22s}  {error.mean():+6.3f}  {error.std():6.3f}  {stated:6.3f}  {short:6.3f}"


def fusion_rows(draws: int) -> Iterator[str]:
    yield "fusion of a tilted plane seen from many poses, 0.3 % flying pixels: rms and stated noise along z, mm"
    yield "noise mm  contacts  seen    points  rms     stated  largest  disagreement  ms a contact"
    for noise in (0.05e-3, 0.3e-3, 1e-3):
        rng = np.random.default_rng(0)
        cloud, times = None, []
        for _ in range(draws):
            seen = contact(any_pose(rng), _plane, noise, rng, flying=3e-3)
            start = time.process_time()
            cloud = fuse_contact(seen, cloud)
            times.append(1e3 * (time.process_time() - start))
        assert cloud is not None
        error = cloud.points[:, 2] - _plane(cloud.points[:, 0], cloud.points[:, 1])
        for count in np.unique(np.linspace(1, draws, 4).astype(int)):
            these = cloud.seen == count
            if these.any():
                rms, stated = np.sqrt(np.mean(error[these] ** 2)), np.sqrt(np.mean(cloud.noise[these] ** 2))
                yield (
                    f"{noise * MM:8.2f}  {draws:8d}  {count:4d}  {these.sum():8d}  {rms * MM:.4f}  {stated * MM:.4f}"
                    f"  {np.abs(error[these]).max() * MM:7.3f}  {cloud.disagreement:12.2f}  {np.median(times):6.0f}"
                )


def _plane(x: Array, y: Array) -> Array:
    return np.asarray(0.03 + 0.3 * (x - PLACE[0]) + 0.0 * y)


def main() -> None:
    draws = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    for rows in (fusion_rows, dimension_rows):
        for line in rows(max(draws, 2)):
            print(line, flush=True)
        print()


if __name__ == "__main__":
    main()
