"""A flat top that is neither a disc nor a block is found as neither."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest
from outline_kinds import ellipse, polygon, radii, rectangle

from stretch_bt.perception import fit_object
from stretch_bt.perception.solids.outline import circle_outline, rectangle_outline
from stretch_bt.perception.solids.unlike import unlike_circle, unlike_rectangle

_spec = importlib.util.spec_from_file_location("membranes", Path(__file__).with_name("membranes.py"))
m = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(m)
MM = 1e-3


def places(corners, noise, seed=0):
    """Return where 72 rays from the middle meet an outline through corners (n, 2), with noise along them."""
    angles = np.tile(np.linspace(0, 2 * np.pi, 24, endpoint=False), 3)
    away = radii(corners, angles) + noise * np.random.default_rng(seed).normal(size=angles.size)
    return away[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])


@pytest.mark.parametrize(
    ("corners", "round_", "square"),
    [
        (ellipse(30 * MM, 30 * MM), True, False),
        (ellipse(33 * MM, 30 * MM, 0.4), False, False),
        (ellipse(36 * MM, 24 * MM, 0.4), False, False),
        (polygon(5, 16 * MM), False, None),
        (polygon(6, 16 * MM), False, False),
        (polygon(8, 16 * MM), False, False),
        (rectangle(30 * MM, 30 * MM, 0.0, 0.3), False, True),
        (rectangle(36 * MM, 28 * MM, 8 * MM, 0.3), False, True),
    ],
)
@pytest.mark.parametrize("noise", [0.02, 0.2])
def test_outlines_are_told_from_circles_and_rectangles(corners, round_, square, noise):
    for seed in range(3):
        seen = places(corners, noise * MM, seed)
        assert (unlike_circle(seen, circle_outline(seen)) == "") == round_
        if square is not None:
            assert (unlike_rectangle(seen, rectangle_outline(seen)) == "") == square


def test_a_hexagonal_prism_is_no_disc():
    found = fit_object(*m.felt(m.prism(polygon(6, 16 * MM), 40 * MM), 40 * MM, places=((0.0, 0.0),)))
    assert found.kind == "extents"
    assert "in 6 places around it" in next(w.refused for w in found.ranking if w.kind == "disc")
    assert abs(found.height - 40 * MM) < 3 * found.dimensions["height"].sd
