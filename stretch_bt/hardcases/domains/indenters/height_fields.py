"""Bodies given by heights over a grid: that are a sphere, that end in walls, have no top, ring, or are no grid."""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from stretch_bt.errors import InvalidInput, NoEquilibrium
from stretch_bt.hardcases.domains.indenters.shapes import field
from stretch_bt.hardcases.expect import Check, Refusal, Value
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.simulation import press
from stretch_bt.simulation.membrane.indenters.height_field import HeightField
from stretch_bt.simulation.membrane.indenters.parse import parse_indenter


def ball(x: Any, y: Any, radius: float = 0.01, rim: float = 0.9) -> Any:
    """Return the height of a sphere that goes on along its flanks outside `rim` radii, m."""
    away, edge = np.hypot(x, y), rim * radius
    inside = np.sqrt(np.maximum(radius**2 - away**2, 0.0))
    low = radius * math.sqrt(1 - rim**2)
    return np.where(away < edge, inside, low - rim / math.sqrt(1 - rim**2) * (away - edge))


BALL = field(ball, 69, 0.25e-3)
PRESSES: dict[str, dict[str, Any]] = {
    "straight": {},
    "aside": {"at": (0.012, 0.009)},
    "tilted": {"tilt": (0.2, -0.1)},
    "shallow": {"depth": 0.003},
    "aside and tilted": {"at": (0.005, 0.0), "tilt": (0.0, 0.3)},
}


def _as_sphere(options: dict[str, Any]) -> float:
    """Return the force of a field of a sphere over the force of the sphere."""
    arguments: dict[str, Any] = {"stretch": 0.03, "depth": 0.008} | options
    return press(BALL, **arguments).force / press("sphere:20mm", **arguments).force


def _gap_of_ball() -> list[float]:
    """Return the worst distance, m, normal, and relative curvature of a field of a sphere, from 1 mm inside to 20 mm away."""
    normal = np.random.default_rng(7).normal(size=(3000, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    normal, worst = normal[normal[:, 2] > 0.6], [0.0, 0.0, 0.0]
    for off in (-1e-3, -1e-4, 0.0, 1e-4, 2e-3, 0.02):
        gap = BALL.gap(normal * (0.01 + off))
        trace = gap.curvature[:, 0] + gap.curvature[:, 3] + gap.curvature[:, 5]
        bend = np.median(np.abs(trace * (0.01 + off) / 2 - 1))
        here = np.abs(gap.distance - off).max(), np.abs(gap.normal - normal).max(), bend
        worst = [max(a, float(b)) for a, b in zip(worst, here, strict=True)]
    return worst


def _hills(x: Any, y: Any) -> Any:
    return 0.004 * np.cos(x / 0.0025) * np.cos(y / 0.003)


def _away_from_hills() -> float:
    """Return how far off the distance to hills is at places over them, against the nearest of many points, m."""
    from scipy.spatial import cKDTree

    ground, x = field(_hills, 61, 0.25e-3), np.linspace(-0.0075, 0.0075, 601)
    points = np.random.default_rng(8).uniform([-0.009, -0.009, -0.003], [0.009, 0.009, 0.012], (1500, 3))
    surface = np.stack([*np.meshgrid(x, x), _hills(*np.meshgrid(x, x))], axis=-1).reshape(-1, 3)
    distance, away = ground.gap(points).distance, cKDTree(surface).query(points)[0]
    over = (distance > 0) & (np.abs(points[:, :2]).max(axis=1) < 0.0075) & (points[:, 2] > _hills(*points[:, :2].T))
    return float(np.abs(distance - away)[over].max()) if over.sum() > 300 else math.inf


def _steepest_hills() -> float:
    """Return how much faster than the place the distance to hills changes, over and beside them."""
    rng, ground = np.random.default_rng(8), field(_hills, 61, 0.25e-3)
    points = rng.uniform([-0.009, -0.009, -0.003], [0.009, 0.009, 0.012], (1500, 3))
    close = points + rng.normal(0, 2e-4, points.shape)
    change = np.abs(ground.gap(close).distance - ground.gap(points).distance)
    return float(((change - 1e-9) / np.linalg.norm(close - points, axis=1)).max())


def _walls() -> tuple[list[float], list[list[float]]]:
    """Return distances, mm, and normals beside a block, at its corner, above its edge, over it and inside."""
    block = field(lambda x, y: np.full(x.shape, 0.003), 21, 1e-3)
    gap = block.gap(
        np.array([[0.013, 0.0, 0.001], [0.013, 0.014, -1.0], [0.013, 0.0, 0.007], [0.0, 0.0, 0.004], [0.009, 0.0, 0.0]])
    )
    return (gap.distance * 1e3).tolist(), gap.normal.tolist()


def _is_block(found: tuple[list[float], list[list[float]]]) -> bool:
    normals = np.array([[1.0, 0, 0], [0.6, 0.8, 0], [0.6, 0, 0.8], [0, 0, 1.0], [1.0, 0, 0]])
    return np.allclose(found[0], [3, 5, 5, 1, -1], atol=1e-9) and np.allclose(found[1], normals, atol=1e-9)


#: heights, radius of the top, radius of the sharpest part, m, and whether the top is flat
TOPS: dict[str, tuple[Any, float, float, bool]] = {
    "a ball, at most half the grid": (ball, 0.0085, 0.0085, False),
    "a bowl turned over": (lambda x, y: -(x**2 + y**2) / 0.008, 0.004, 0.004, False),
    "a ridge": (lambda x, y: -(x**2) / 0.006 - 0 * y, 0.003, 0.003, False),
    "a face with a round rim": (
        lambda x, y: -(np.maximum(np.hypot(x, y) - 0.005, 0.0) ** 2) / 0.002,
        0.0085,
        0.001,
        True,
    ),
}


def _top_is(tip: float, feature: float, is_flat: bool) -> Check:
    def check(found: HeightField) -> bool:
        x, _ = found.zones(np.eye(3), 0.1)
        sizes = abs(found.tip_radius / tip - 1) < 0.05 and abs(found.feature / feature - 1) < 0.25
        return sizes and (found.flat > 0.004) == is_flat and math.isclose(x[0].low, -x[0].high)

    return Check(f"a top of {tip * 1e3:g} mm, sharp to {feature * 1e3:g} mm, {'flat' if is_flat else 'round'}", check)


def _between_nodes() -> tuple[float, float]:
    found = field(lambda x, y: 0.005 - ((x - 1.1e-4) ** 2 + (y + 0.9e-4) ** 2) / 0.02, 69, 0.25e-3)
    return found.top(np.eye(3)), min(found.crest(np.eye(3))[0], 1e-3)


def _on_the_border(half: float, depth: float, surface: Any) -> Any:
    return press(field(surface, round(2 * half / 0.25e-3) + 1, 0.25e-3), 0.03, depth)


def _steps() -> HeightField:
    heights = np.full((41, 41), -0.02)
    heights[18:23, 18:23] = 0.0
    return HeightField(heights, 0.5e-3)


def _from_file(name: str, content: Any, end: str = "1mm") -> Any:
    """Return the indenter of a text that names a file with this content, None for one that is not there."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / name
        if content is not None:
            np.save(path, content)
        return parse_indenter(f"height:{path}:{end}")


def _bowl(x: Any, y: Any) -> Any:
    return -(x**2 + y**2) / 0.024


BORDER = Refusal(NoEquilibrium, "border of the height field")

CASES: tuple[Hard, ...] = (
    *group(
        "a field that is a sphere presses like it wherever it stands",
        {
            f"a field of a sphere, {name}": (partial(_as_sphere, options), Value(1.0, abs=0.01))
            for name, options in PRESSES.items()
        },
    ),
    *group(
        "the nearest place of a spline is searched, near and far, over hills and walls",
        {
            "distance, normal and curvature of a sphere": (
                _gap_of_ball,
                Check("within 0.2 um, 0.002 and 0.1 %", lambda w: w[0] < 2e-7 and w[1] < 2e-3 and w[2] < 1e-3),
            ),
            "the nearest place of all over hills": (_away_from_hills, Value(0.0, abs=3e-5)),
            "no jump of the distance over hills": (
                _steepest_hills,
                Check("no faster than the place", lambda steepest: steepest <= 1 + 1e-6),
            ),
            "walls and what is beside them": (_walls, Check("distances and normals of a block", _is_block)),
        },
    ),
    *group(
        "elements are as small as the top is sharp, but a border and a face have no curvature, and a ridge has one",
        {
            f"top, {name}": (partial(field, surface, 69, 0.25e-3), _top_is(tip, feature, flat))
            for name, (surface, tip, feature, flat) in TOPS.items()
        },
        {"top between nodes": (_between_nodes, Value((0.005, 1e-3), abs=1e-9))},
    ),
    *group(
        "beside the grid of heights there is nothing that a sheet could rest on",
        {
            "resting on the border, small": (partial(_on_the_border, 0.003, 0.003, _bowl), BORDER),
            "resting on the border, large": (partial(_on_the_border, 0.006, 0.006, _bowl), BORDER),
            "resting on the border, a ridge across": (
                partial(_on_the_border, 0.008, 0.001, lambda x, y: -(x**2) / 0.02 + 0 * y),
                BORDER,
            ),
        },
        costly=("resting on the border, a ridge across",),
    ),
    *group(
        "an input that is no grid of heights, or jumps so that a smooth surface rings",
        {
            "three rows": (partial(HeightField, np.zeros((3, 9)), 1e-3), Refusal(InvalidInput, "at least 4 x 4")),
            "a line": (partial(HeightField, np.zeros(9), 1e-3), Refusal(InvalidInput, "at least 4 x 4")),
            "all NaN": (partial(HeightField, np.full((5, 5), np.nan), 1e-3), Refusal(InvalidInput, "finite heights")),
            "pitch 0": (partial(HeightField, np.zeros((5, 5)), 0.0), Refusal(InvalidInput, "pitch")),
            "steps that ring": (_steps, Refusal(InvalidInput, "rings")),
        },
    ),
    *group(
        "a file of heights may have colons in its name, hold no heights, or not be there",
        {
            "a file": (partial(_from_file, "a:b.npy", BALL.heights, "0.25mm"), Value(BALL)),
            "no file": (partial(_from_file, "none.npy", None), Refusal(InvalidInput, "No such file")),
            "a file of words": (
                partial(_from_file, "words.npy", np.array(["high", "low"])),
                Refusal(InvalidInput, "heights"),
            ),
            "no pitch": (partial(parse_indenter, "height:part.npy"), Refusal(InvalidInput, "pitch")),
            "a pitch without unit": (
                partial(_from_file, "a.npy", BALL.heights, "0.25"),
                Refusal(InvalidInput, "0.25 mm"),
            ),
        },
    ),
)
