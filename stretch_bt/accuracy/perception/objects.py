"""Contacts with known surfaces from many poses, and clouds of objects whose dimensions are known."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from stretch_bt.frames import Pose
from stretch_bt.perception import Cloud, Contact, cloud_of

__all__ = ["OBJECTS", "PLACE", "any_pose", "block", "contact", "half_cylinder"]

Array = npt.NDArray[np.float64]
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
    return Contact(points, rays, labels, noise, pose.height, 0.0, 0.0, np.zeros((2, 2, 3)), np.ones((2, 2)), pose)


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
