"""How far from an edge, the end of a crest or the middle of a wire a membrane bends, against the rules that correct for it.

    python -m benchmarks.conformity

Bodies of several sizes are pressed in the twin without camera noise, with the membrane's bending and without. `bends` is how far inside
the true side or end the straight parts of the membrane meet, `rule` how far `perception/solids/conformity.py` moves that, and `left`
the residual; mm, on the mean over the sides. The offsets of ends and the standard deviations in that file are the means and the spreads
of these.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator

import numpy as np

from stretch_bt.accuracy.twin.felt import around, felt, fused
from stretch_bt.errors import NoAnswer, NoEquilibrium
from stretch_bt.perception import fit_object
from stretch_bt.simulation.scene import Scene, parse_scene

MM = 1e3
BODIES = {
    "block 40 x 40": ("block", "type: box, length: 40 mm, width: 40 mm, height: 40 mm, rigid: true"),
    "block 30 x 20": ("block", "type: box, length: 30 mm, width: 20 mm, height: 40 mm, rigid: true"),
    "block 50 x 25 at 30 deg": (
        "block",
        "type: box, length: 50 mm, width: 25 mm, height: 40 mm, heading: 30 deg, rigid: true",
    ),
    "prism 50": ("ridge", "type: prism, length: 50 mm, width: 40 mm, height: 30 mm, rigid: true"),
    "prism 35 at 90 deg": (
        "ridge",
        "type: prism, length: 35 mm, width: 30 mm, height: 30 mm, heading: 90 deg, rigid: true",
    ),
    "prism 40 at 30 deg": (
        "ridge",
        "type: prism, length: 40 mm, width: 50 mm, height: 25 mm, heading: 30 deg, rigid: true",
    ),
    "half-cylinder 40 x 50": ("half_cylinder", "type: half_cylinder, diameter: 40 mm, length: 50 mm, rigid: true"),
    "half-cylinder 30 x 40 at 90 deg": (
        "half_cylinder",
        "type: half_cylinder, diameter: 30 mm, length: 40 mm, heading: 90 deg, rigid: true",
    ),
    "half-cylinder 50 x 45 at 30 deg": (
        "half_cylinder",
        "type: half_cylinder, diameter: 50 mm, length: 45 mm, heading: 30 deg, rigid: true",
    ),
    "wire circle 50": ("wire_circle", "type: wire_circle, diameter: 50 mm, base: 20 mm"),
    "wire circle 36": ("wire_circle", "type: wire_circle, diameter: 36 mm, base: 20 mm"),
    "wire triangle 50": ("wire_triangle", "type: wire_triangle, side: 50 mm, base: 20 mm"),
    "wire triangle 60 at 20 deg": ("wire_triangle", "type: wire_triangle, side: 60 mm, base: 20 mm, heading: 20 deg"),
}
ASKED = {
    "block": ("length", "width"),
    "ridge": ("length",),
    "half_cylinder": ("length",),
    "wire_circle": ("radius",),
    "wire_triangle": ("side",),
}
SHARES = {"length": 2.0, "width": 2.0, "radius": 1.0, "side": 2 * np.sqrt(3)}  # of a dimension for one side's place


def scene(options: str, bending: bool) -> Scene:
    """Return a scene of a body without noise."""
    effects = "{bending: on, fixed_pattern: off, correlated_noise: off, white_noise: off, drift: off, compliance: off}"
    chosen = effects if bending else "none"
    return parse_scene(f"format: stretch-scene/1\nobject: {{{options}}}\neffects: {chosen}\n")


def rows(depths: tuple[float, ...]) -> Iterator[str]:
    """Yield one line of each body, dimension, depth and membrane."""
    yield "body                              bending  depth  found          dimension    bends    rule    left      sd"
    for name, (kind, options) in BODIES.items():
        for bending in (False, True):
            made = scene(options.replace(", rigid: true", "") if "wire" in name else options, bending)
            for depth in depths:
                head = f"{name:32s}  {'on ' if bending else 'off':7s}  {depth * MM:5.0f}"
                try:
                    yield from _lines(head, made, kind, depth)
                except (NoAnswer, NoEquilibrium) as error:
                    yield f"{head}  {error}"


def _lines(head: str, made: Scene, kind: str, depth: float) -> Iterator[str]:
    contacts = felt(made, 0, around(made), depth, frames=4)
    cloud = fused(contacts)
    auto = fit_object(cloud, contacts)
    found = auto if auto.kind == kind else fit_object(cloud, contacts, shape=kind)
    known = made.object.known()
    for dimension in ASKED[kind]:
        value, share = found.dimensions[dimension], SHARES[dimension]
        off = (known[dimension] - value.seen) / share
        rule = value.steps["membrane"] / share
        yield (
            f"{head}  {auto.kind:13s}  {dimension:9s} {off * MM:+8.2f} {rule * MM:+7.2f} {(off - rule) * MM:+7.2f}"
            f" {value.sd / share * MM:7.2f}"
        )


def main() -> None:
    """Print the table; depths in mm may be named."""
    depths = tuple(float(v) * 1e-3 for v in sys.argv[1:]) or (0.010,)
    for line in rows(depths):
        print(line, flush=True)


if __name__ == "__main__":
    main()
