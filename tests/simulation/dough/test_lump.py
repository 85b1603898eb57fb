"""Rolling and pressing a lump: what is kept, what does not matter, and what the paths make of it."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stretch_bt.hardcases.strategies.dough import CUTS, HEADINGS
from stretch_bt.simulation.dough.lump import cube
from stretch_bt.simulation.dough.material import Dough

EDGE, WEIGHT = 0.025, 0.19
DOUGH = Dough(5e3, 1e5)


def tumbled(lump, seed):
    turned = np.random.default_rng(seed).standard_normal(4)
    return replace(lump, quaternion=turned / np.linalg.norm(turned))


@settings(max_examples=15, deadline=None)
@given(
    cuts=CUTS,
    seed=st.integers(0, 5),
    heading=HEADINGS,
)
def test_the_pieces_of_a_path_do_not_matter(cuts, seed, heading):
    start = tumbled(cube(EDGE, 100), seed)
    way = 0.137 * np.array([math.cos(heading), math.sin(heading)])
    whole, _ = start.rolled(tuple(way), 1.2, DOUGH, weight=WEIGHT, spin=0.05, seed=seed)
    pieces = start
    marks = np.array([0.0, *sorted(cuts), 1.0])
    for part in np.diff(marks):
        pieces, _ = pieces.rolled(tuple(part * way), 1.2, DOUGH, weight=WEIGHT, spin=0.05, seed=seed)
    assert pieces.steps == whole.steps
    assert np.array_equal(pieces.radii, whole.radii)
    assert np.array_equal(pieces.quaternion, whole.quaternion)
    assert (pieces.x, pieces.y) == pytest.approx((whole.x, whole.y), abs=1e-15)
