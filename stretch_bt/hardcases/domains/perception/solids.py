"""Shapes at any heading against their own outlines, and membranes of which it is known where they lie on something."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np
from scipy.ndimage import binary_erosion

from stretch_bt.hardcases.expect import Range, Value
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.perception.clouds.expected import TENSIONS, drape
from stretch_bt.perception.clouds.support import supported
from stretch_bt.perception.solids.agree import outside
from stretch_bt.perception.solids.result import Dimension, Solid

MM = 1e-3
MIDDLE = np.array([0.312, -0.147, 0.02])
HEADINGS = (0.0, 0.4, -1.1, -math.pi / 2)
#: mm
X, Y = np.meshgrid(np.arange(-30.0, 30.0) + 0.5, np.arange(-40.0, 40.0) + 0.5, indexing="ij")


def _solid(kind: Any, heading: float, **sizes: float) -> Solid:
    x, y, z = MIDDLE.tolist()
    return Solid(kind, {name: Dimension(size, 1e-4, {}) for name, size in sizes.items()}, x, y, z, heading, ())


def _past_block(heading: float) -> list[float]:
    """Return how far places 3 mm beyond the sides of a block, on its corners, and 2 mm within are outside it, m."""
    block = _solid("block", heading, length=0.04, width=0.01, height=0.02)
    along = np.array([math.cos(heading), math.sin(heading)])
    across = np.array([-along[1], along[0]])
    places = [s * 0.023 * along + t * 0.002 * across for s in (1, -1) for t in (1, -1)]
    places += [s * 0.008 * across + t * 0.015 * along for s in (1, -1) for t in (1, -1)]
    places += [s * 0.02 * along + t * 0.005 * across for s in (1, -1) for t in (1, -1)]
    places += [s * 0.003 * across + t * 0.015 * along for s in (1, -1) for t in (1, -1)]
    found: list[float] = outside(block, np.array(places) + MIDDLE[:2]).tolist()
    return found


def _past_disc(kind: Any, heading: float) -> list[float]:
    """Return how far places all around, 12 mm off the middle, are outside a disc of 10 mm or another solid of its sizes, m."""
    turns = np.linspace(0, 2 * np.pi, 7)
    disc = _solid(kind, heading, radius=0.01, side=0.01, length=0.01, height=0.02)
    found: list[float] = outside(disc, 0.012 * np.column_stack([np.cos(turns), np.sin(turns)]) + MIDDLE[:2]).tolist()
    return found


def _told(heights: Any, stays: Any, turn: float = 0.0, noise: float = 0.0) -> Any:
    rough = np.random.default_rng(0).normal(0.0, 1.0, heights.shape) * noise
    return supported((heights + rough) * MM, stays, turn=turn, cell=MM)


def _hung(ground: Any, level: float) -> tuple[Any, Any]:
    """Return a sheet, mm, whose clamps are at a level over a ground, and where it touches."""
    sheet = drape(ground[None] * MM, np.array([level * MM]))[0] / MM
    return sheet, sheet - ground < 0.01


def _felt(ground: Any, noise: float) -> float:
    """Return the part of the touching cells that counts as lying, their rim aside."""
    sheet, touches = _hung(ground, 3.0)
    return float(_told(sheet, touches, noise=noise)[0][binary_erosion(touches, iterations=2)].mean())


def _falling_curvature(along_hand: bool) -> float:
    """Return the part that counts as lying of a surface whose curvature falls evenly from 120 1/m to 0."""
    place = (X if not along_hand else Y) * MM
    low, high = place.min(), place.max()
    # the second integral of a curvature 120 (high - p) / (high - low)
    heights = -120.0 / (high - low) * (high * place**2 / 2 - place**3 / 6) / MM
    lies, _ = _told(heights, np.full(X.shape, True))
    return float(lies[3:-3, 3:-3].mean())


def _saddle(turn: float) -> list[float]:
    """Return the parts of a free membrane that count as lying, and as hanging."""
    across, along = X * np.cos(turn) + Y * np.sin(turn), Y * np.cos(turn) - X * np.sin(turn)
    within = np.hypot(X, Y) < 18.0
    lies, hangs = _told(5.0 * (across**2 - along**2 / TENSIONS) / 18.0**2, within, turn)
    return [float(lies[within].mean()), float(hangs[within].mean())]


DOME, RIDGE = 12.0 - (X**2 + Y**2) / 40.0, np.where(np.abs(Y) < 15.0, 10.0 - X**2 / 40.0, 0.0)
CASES: tuple[Hard, ...] = (
    *group(
        "an object stands at any heading, and places are given in the world",
        {
            f"past a block at {heading:.2g} rad": (
                partial(_past_block, heading),
                Value([0.003] * 8 + [0.0] * 4 + [-0.002] * 4, abs=1e-12),
            )
            for heading in HEADINGS
        },
        {
            f"past a {kind} at {heading:.2g} rad": (
                partial(_past_disc, kind, heading),
                Value([0.002 if kind == "disc" else 0.0] * 7, abs=1e-12),
            )
            for kind in ("disc", "wire_circle", "wire_triangle", "ridge")
            for heading in HEADINGS[1:3]
        },
        prefix="solids, ",
    ),
    *group(
        "a membrane that stays as the hand rises may lie on something or hang, and only its bend distinguishes the two",
        {
            f"over a {name}, noise {noise:g} mm": (partial(_felt, ground, noise), Range(0.95))
            for name, ground in {"dome": DOME, "cylinder": RIDGE}.items()
            for noise in (0.0, 0.01)
        },
        {
            f"a curvature that falls {'along' if along else 'across'} the hand": (
                partial(_falling_curvature, along),
                Value(1.0, abs=1e-12),
            )
            for along in (False, True)
        },
        {
            f"a free saddle, turned by {turn:g} rad": (partial(_saddle, turn), Value([0.0, 1.0], abs=1e-12))
            for turn in (0.0, 0.7)
        },
        prefix="support, ",
    ),
)
