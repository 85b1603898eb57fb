"""The surfaces that are fitted: derivatives at any place and slope, rims of any form, long steps, and equations that leave one free."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from stretch_bt.errors import IllConditioned
from stretch_bt.hardcases.expect import Check, Range, Refusal, Value
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.perception.shapes.cone import ConeSurface
from stretch_bt.perception.shapes.contact_cells import window_of
from stretch_bt.perception.shapes.cylinder import CylinderSurface
from stretch_bt.perception.shapes.pressed_surface import CONE, FACE, SPHERE, PressedSurface
from stretch_bt.perception.shapes.robust_fit import robust_linear
from stretch_bt.perception.shapes.sphere import SphereSurface, center_of
from stretch_bt.perception.shapes.turn import standing

PLACES = np.random.default_rng(21).uniform(-1.2, 1.2, (2, 400))
KINDS = {"sphere": SPHERE, "face": FACE, "cone": CONE}
Made = Callable[[np.random.Generator], Any]


def _axes(rng: np.random.Generator) -> Any:
    """Return axes whose last leans by up to a third of a radian."""
    return standing(np.array([*rng.uniform(-0.3, 0.3, 2), 1.0]), rng.normal(size=3) * [1.0, 1.0, 0.1])


MADE: dict[str, Made] = {
    "sphere": lambda rng: SphereSurface(
        np.array([*rng.uniform(-0.5, 0.5, 3), rng.uniform(0.3, 1.2) * rng.choice([-1, 1])])
    ),
    "cylinder": lambda rng: CylinderSurface(
        rng.uniform(-0.5, 0.5), _axes(rng), rng.uniform(0.2, 0.6) * rng.choice([-1, 1])
    ),
    "cone": lambda rng: ConeSurface(rng.uniform(-0.5, 0.5, 3), _axes(rng), rng.uniform(0.2, 0.6) * rng.choice([-1, 1])),
}


def _clear(surface: Any) -> Any:
    """Return which places have a slope: not those close to a sphere's silhouette, and of a cylinder none beyond it."""
    if isinstance(surface, SphereSurface):
        _, p1, p2, k = surface.q
        d0 = 1 / math.sqrt(1 + p1 * p1 + p2 * p2)
        return np.abs(1 - (k * PLACES[0] - p1 * d0) ** 2 - (k * PLACES[1] - p2 * d0) ** 2) > 3e-3
    if isinstance(surface, CylinderSurface):
        along, _, up = surface.axes
        across = np.array([along[1], -along[0]]) / np.hypot(along[0], along[1])  # to the axis and to the view
        return np.abs(across @ PLACES + across @ up[:2] / surface.k) < 0.998 / abs(surface.k)
    return np.full(PLACES.shape[1], True)


def _derived(made: Made) -> float:
    """Return the largest error of derivatives, over the larger of them and 1, against differences of the heights of moved surfaces."""
    rng, worst, step = np.random.default_rng(22), 0.0, 1e-6
    for _ in range(20):
        surface = made(rng)
        found = surface.heights(*PLACES)[1]
        for p, along in enumerate(step * np.eye(surface.parameters)):
            ahead, behind = (surface.moved(s * along)[0].heights(*PLACES)[0] for s in (1, -1))
            off = np.abs(found[p] - (ahead - behind) / (2 * step)) / np.maximum(np.abs(found[p]), 1.0)
            worst = max(worst, float(off[_clear(surface)].max()))
    return worst


def _on_it() -> list[float]:
    """Return how far heights of spheres, cylinders and cones lie off them: by a part of the radius, and of the sine."""
    rng, worst = np.random.default_rng(23), [0.0, 0.0, 0.0]
    for _ in range(20):
        ball, tube, tip = (made(rng) for made in MADE.values())
        k = ball.q[3]
        points = np.stack([*PLACES, ball.heights(*PLACES)[0]])
        seen = (k * k * ((points[:2] - center_of(ball.q)[0][:2, None]) ** 2).sum(axis=0)) < 0.99
        away = np.linalg.norm(points - center_of(ball.q)[0][:, None], axis=0)
        worst[0] = max(worst[0], float(np.abs(away * abs(k) - 1)[seen].max()))
        points = np.stack([*PLACES, tube.heights(*PLACES)[0] - tube.c])
        _, across, up = tube.axes @ points
        worst[1] = max(worst[1], float(np.abs(np.hypot(across, up + 1 / tube.k) * abs(tube.k) - 1)[_clear(tube)].max()))
        points = np.stack([*PLACES, tip.heights(*PLACES)[0]]) - tip.apex[:, None]
        worst[2] = max(worst[2], float(np.abs(tip.axes[2] @ points / np.linalg.norm(points, axis=0) + tip.s).max()))
    return worst


def _centre_moves() -> float:
    """Return the largest error of how a sphere's centre moves with its parameters, against differences."""
    rng, worst, step = np.random.default_rng(24), 0.0, 1e-6
    for _ in range(20):
        q = MADE["sphere"](rng).q
        moves = np.stack([(center_of(q + e)[0] - center_of(q - e)[0]) / (2 * step) for e in step * np.eye(4)], axis=1)
        worst = max(worst, float(np.abs(moves - center_of(q)[1]).max() / max(np.abs(moves).max(), 1.0)))
    return worst


def _long_steps(made: Made) -> float:
    """Return by how much a step that is too long is not a shorter one the same way, or a short one is not taken as it is."""
    rng, worst = np.random.default_rng(25), 0.0
    for _ in range(20):
        surface, step = made(rng), rng.normal(size=surface_size(made))
        taken, short = surface.moved(1e3 * step)[1], surface.moved(1e-3 * step)[1]
        share = float(taken @ step / (step @ step))
        worst = max(worst, float(np.abs(taken - share * step).max()), float(np.abs(short - 1e-3 * step).max()))
        assert 0 < share < 100
        assert np.abs(taken[-1]) <= 1.0
    return worst


def surface_size(made: Made) -> int:
    """Return how many parameters a surface has."""
    return int(made(np.random.default_rng(0)).parameters)


def _pressed(kind: int, rng: np.random.Generator, ellipse: float = 0.0, pull: float = 0.0) -> PressedSurface:
    """Return a body whose rim is longer along x by a share, in a sheet pulled more along y, and its skirt as that goes by itself."""
    size = math.log(rng.uniform(0.4, 0.6))
    middle = rng.normal(0, 0.1, 2)
    q = [*rng.normal(0, 0.05, 3), 0.05 if kind == FACE else 0.6, size + ellipse, size - ellipse, *middle, pull]
    edge = {FACE: [0.3, 0.0, 0.0], SPHERE: [0.0, 0.05]}.get(kind, [])
    return PressedSurface(kind, np.array([*q, *(0.0,) * 6, *edge]))


def _steps_at_rim(kind: int, ellipse: float, pull: float) -> list[float]:
    """Return the largest step of the height at the rim, and of the slope across it, over that slope."""
    rng, worst, turns = np.random.default_rng(26), [0.0, 0.0], np.linspace(0, 2 * np.pi, 50)
    for _ in range(5):
        body = _pressed(kind, rng, ellipse, pull)
        a, b, (x, y) = math.exp(body.q[4]), math.exp(body.q[5]), body.q[6:8]
        if kind == CONE:  # its tip is where the rim's middle is
            body.q[1:3] = 0.0
        rim = np.stack([a * np.cos(turns), b * np.sin(turns)])
        heights = [body.heights(*(np.array([[x], [y]]) + s * rim)) for s in (1 - 2e-4, 1 - 1e-7, 1 + 1e-7, 1 + 2e-4)]
        worst[0] = max(worst[0], float(np.abs(heights[2] - heights[1]).max()))
        inside, outside = heights[1] - heights[0], heights[3] - heights[2]
        worst[1] = max(worst[1], float(np.abs(outside - inside).max() / np.abs(inside).max()))
    return worst


def _joined(kind: int, is_long: bool) -> Check:
    """Expect that body and membrane meet; a few harmonics say how a long rim goes, and a face has an edge."""
    step = 3e-4 if is_long else 1e-6
    if kind == FACE:
        return Check(f"no step above {step:g}", lambda found: found[0] < step)
    return Check(f"no step above {step:g}, and no kink above 2 %", lambda found: found[0] < step and found[1] < 0.02)


def _pressed_derived(kind: int) -> float:
    """Return the largest error of derivatives of a pressed surface, over the largest, off its rim."""
    rng, worst, step = np.random.default_rng(27), 0.0, 2e-5
    for _ in range(3):
        body = _pressed(kind, rng, 0.1, 0.4)
        body.q[9:15] = rng.normal(0, 0.1, 6)
        body.q[15:] = {FACE: [0.3, 0.1, 0.03], SPHERE: [0.7, 0.06]}.get(kind, [])
        x, y = PLACES[:, :60]
        share = np.hypot((x - body.q[6]) / math.exp(body.q[4]), (y - body.q[7]) / math.exp(body.q[5]))
        found = body.derivatives(x, y)[1]
        for p, along in enumerate(step * np.eye(body.q.size)):
            ahead, behind = (PressedSurface(kind, body.q + s * along).heights(x, y) for s in (1, -1))
            off = np.abs(found[p] - (ahead - behind) / (2 * step))[np.abs(share - 1) > 0.05]
            worst = max(worst, float(off.max() / max(np.abs(found[p]).max(), 1.0)))
    return worst


def _line(apart: float) -> Any:
    """Return the solution for noise by columns of which two differ by a part."""
    rng = np.random.default_rng(28)
    x = rng.uniform(-1, 1, 300)
    design = np.stack([np.ones(300), x, x + apart * rng.uniform(-1, 1, 300)])
    return robust_linear(design, rng.normal(0, 1.0, 300), 1e-6, "case")[0]


def _window(squares: int) -> Any:
    """Return the window of a bump that is seen through a hole of so many squares of 7 pixels a side."""
    v, u = np.mgrid[0:140, 0:140]
    surface = np.stack([u * 4e-4, v * 4e-4, 5e-3 - ((u - 70) ** 2 + (v - 70) ** 2) * 1e-6], axis=-1)
    first, last = 49, 49 + 7 * squares
    surface[(u < first) | (u >= last) | (v < first) | (v >= last)] = np.nan
    return window_of(surface.astype(np.float32))


def _by_kind() -> Iterator[Hard]:
    for name, made in MADE.items():
        yield from group(
            "a step follows derivatives, which are steep beside a silhouette and different beyond it",
            {f"{name}, derivatives": (partial(_derived, made), Range(0.0, 1e-5))},
            {f"{name}, a long step": (partial(_long_steps, made), Range(0.0, 1e-12))},
        )
    for name, kind in KINDS.items():
        yield from group(
            "body and membrane have to meet all around a rim of any form",
            {f"a pressed {name}, derivatives": (partial(_pressed_derived, kind), Range(0.0, 1e-3))},
            {
                f"a pressed {name}, its rim {form}": (
                    partial(_steps_at_rim, kind, ellipse, pull),
                    _joined(kind, ellipse > 0),
                )
                for form, ellipse, pull in (("round", 0.0, 0.0), ("long", 0.15, 0.0), ("of a pulled sheet", 0.15, 0.3))
            },
        )


CASES: tuple[Hard, ...] = (
    *_by_kind(),
    *group(
        "a height off the shape, or a wrong derivative of its centre, biases the radius",
        {
            "heights lie on spheres, cylinders and cones": (_on_it, Value([0.0] * 3, abs=1e-6)),
            "a sphere's centre, derivatives": (_centre_moves, Range(0.0, 1e-6)),
        },
    ),
    *group(
        "columns that are nearly alike leave their difference free",
        {
            "two columns the same": (partial(_line, 0.0), Refusal(IllConditioned)),
            "two columns alike to a millionth": (partial(_line, 1e-6), Refusal(IllConditioned)),
            "two columns alike to three millionths": (partial(_line, 3e-6), Refusal(IllConditioned)),
            "two columns alike to a hundredth": (
                partial(_line, 1e-2),
                Check("below 100", lambda solution: np.abs(solution).max() < 100),
            ),
        },
    ),
    *group(
        "few squares of pixels show no rim",
        {
            "25 squares": (partial(_window, 5), Refusal(IllConditioned, "hardly any pixel")),
            "49 squares": (partial(_window, 7), Check("a window within them", lambda w: 0 < w.a < 49 * 4e-4)),
        },
    ),
)
