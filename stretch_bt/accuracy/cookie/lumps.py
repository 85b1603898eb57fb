"""Cubes of dough that seeds draw, each with a scene of its own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

__all__ = ["Draw", "draw", "scene"]

#: effects that the advisor would leave off with the tolerance of the scene, and the stop rules read
NOISE = ("sag", "correlated_noise", "white_noise", "fixed_pattern", "repeatability", "latency", "arm_force_noise")


@dataclass(frozen=True)
class Draw:
    """A lump: edge, m, yield stress and modulus, Pa, spin noise, roughness of its edge."""

    edge: float
    yield_stress: float
    modulus: float
    spin: float
    cracks: float


def draw(seed: int) -> Draw:
    """Return the lump of a seed."""
    chance = np.random.default_rng([2021, seed])
    edge, stress, ratio, spin, cracks = chance.uniform(size=5).tolist()
    stress = 2e3 * 5**stress
    return Draw(0.020 + 0.010 * edge, stress, (10 + 20 * ratio) * stress, 0.2 * spin, 0.02 * cracks)


def scene(lump: Draw, spin: float | None = None) -> str:
    """Return the scene file of a lump; `spin` in place of its own spin noise."""
    spins = lump.spin if spin is None else spin
    return "\n".join(
        [
            "format: stretch-scene/1",
            f"object: {{type: dough, edge: {1e3 * lump.edge:.6f} mm, yield_stress: {lump.yield_stress:.4f} Pa, modulus: {lump.modulus:.3f} Pa}}",
            "hand: {frame: 12 mm}",
            "tolerance: {roundness: 1 %, height: 0.5 mm}",
            "conditions: {stretch: 0 mm, depth: 12 mm, hold: 0 s, speed: 30 mm/s, frames: 1, travel: 2 m}",
            "effects:",
            f"  spin_noise: {{sd: {spins:.6f}}}",
            f"  edge_cracks: {{roughness: {lump.cracks:.6f}}}",
            *(f"  {name}: on" for name in NOISE),
        ]
    )
