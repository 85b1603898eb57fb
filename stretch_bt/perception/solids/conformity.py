"""How far the place where a membrane bends is from the edge, the end or the wire that it bends over."""

from __future__ import annotations

import math
from dataclasses import dataclass

from stretch_bt.perception.solids.bend import Bend

__all__ = ["FILLET", "FILLET_SD", "Beyond", "beyond_end", "inside_wire"]

FILLET = 1e-3  # m: radius of an edge or a wire, where the caller knows no better
#: m; rms of how far any radius from 0 to 3 mm, one as likely as another, is from FILLET
FILLET_SD = 1e-3
EDGE_SD = 0.12e-3  # m, standard deviation of the rule for an edge (benchmarks/conformity.py)
#: m, how much further inside than the rule says the straight parts meet where a membrane leaves an edge, or the end of a crest, at no
#: slope, and the slope from where they do not (benchmarks/conformity.py)
GENTLE_EDGE, GENTLE_END, STEEP = 0.25e-3, 0.5e-3, 0.75
#: from the bend to the end of a sharp crest, over the length of the bend: the membrane falls off to three sides, so that it bends
#: further inside the longer it takes; m from the bend to the end of a round crest beyond the rule for an edge; and the standard
#: deviation of both, m (benchmarks/conformity.py)
SHARP_END, ROUND_END, END_SD = 0.98, -0.35e-3, 0.2e-3
STIFF = 0.7e-3  # m over which a membrane that resists bending passes from slope to slope, at least


@dataclass(frozen=True, slots=True)
class Beyond:
    """Shift of a place outwards, m, and the standard deviation, m, of the rule for it.

    `share` is the change of the shift over the change of the radius of the edge or the wire, whose error all places of an object share.
    """

    shift: float
    sd: float
    share: float


def _beyond(bend: Bend, fillet: float, gentle: float) -> Beyond:
    """Return how far beyond a bend the end of a crest stands whose edge has a radius of `fillet`, m.

    The membrane leaves the fillet where its slope is theta; the straight parts meet f (1 - tan(theta / 2)) inside the end, and a
    little more where it leaves gently.
    """
    share = 1.0 - math.tan(math.atan(max(bend.change, 0.0)) / 2)
    more = gentle * max(1.0 - bend.change / STEEP, 0.0)
    return Beyond(fillet * share + more, EDGE_SD, share)


def beyond_end(bend: Bend, *, sharp: bool, fillet: float = FILLET) -> Beyond:
    """Return how far beyond a bend along a crest its end is, for a ridge or for the crest of a half-cylinder."""
    stiff = bend.length > STIFF
    if sharp and stiff:
        return Beyond(SHARP_END * bend.length, END_SD, 1.0)
    edge = _beyond(bend, fillet, GENTLE_END if stiff else GENTLE_EDGE)
    more = ROUND_END if stiff else 0.0
    return Beyond(edge.shift + more, math.hypot(edge.sd, END_SD if more else 0.0), edge.share)


def inside_wire(bend: Bend, radius: float = FILLET) -> Beyond:
    """Return how far from a bend the middle of a wire of some radius, m, is: negative is nearer to the origin.

    A wire carries the membrane by a force through its own middle, half-way between the two slopes, and the straight parts
    meet on the line of that force, above the wire.
    """
    lean = -(bend.near + bend.far) / 2
    above = bend.change * bend.length / 2 + radius
    return Beyond(-above * lean, math.hypot(0.3 * above * lean, EDGE_SD), -lean)
