"""Shapes against maps of presses over them, and over something else."""

import importlib.util
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from stretch_bt.perception import fit_object
from stretch_bt.perception.clouds.relief import Relief
from stretch_bt.perception.solids.agree import SURFACES, contradiction, surface_of_domes, surface_of_points
from stretch_bt.perception.solids.result import Dimension

_spec = importlib.util.spec_from_file_location("membranes", Path(__file__).with_name("membranes.py"))
m = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(m)
MM = 1e-3
SIZES = {
    "block": {"length": 40, "width": 28, "height": 20},
    "disc": {"radius": 16, "height": 20},
    "half_cylinder": {"length": 50, "radius": 20, "height": 20},
    "ridge": {"length": 44, "height": 20},
    "wire_circle": {"radius": 22, "height": 20},
    "wire_triangle": {"side": 48, "height": 20},
    "point": {"height": 20},
    "domes": {"radius": 16, "height": 16},
}
MIDDLE, HEADING = np.array([0.012, -0.007]), 0.4
RADIUS = 16 * MM
TOPS = {"domes": 25 * MM, "point": 20 * MM}  # a dome stands on a column
N = 90


def dimensions(kind):
    return {name: Dimension(size * MM, 0.3 * MM, {}) for name, size in SIZES[kind].items()}


def surface_of(kind):
    top = [SimpleNamespace(middle=MIDDLE, height=SimpleNamespace(value=TOPS.get(kind)))]
    if kind == "domes":
        return surface_of_domes(top, [SimpleNamespace(value=RADIUS)], MIDDLE, HEADING)
    return surface_of_points(top, MIDDLE, HEADING) if kind == "point" else SURFACES[kind]


def placed(middle=MIDDLE):
    """Return the places, m, along the shape and across it, of the cells of a map (n, n)."""
    x, y = ((np.arange(N) - N // 2 + 0.5) * MM)[:, None], ((np.arange(N) - N // 2 + 0.5) * MM)[None, :]
    u, v = x - middle[0] + 0 * y, y - middle[1] + 0 * x
    cos, sin = np.cos(HEADING), np.sin(HEADING)
    return u * cos + v * sin, v * cos - u * sin


def mapped(kind, middle=MIDDLE):
    """Return the map of presses over a shape: felt where its surface is not steep, and beside it a membrane that falls away."""
    along, across = placed(middle)
    outside, height = (a.reshape(N, N) for a in surface_of(kind)(dimensions(kind), along.ravel(), across.ravel()))
    if kind == "ridge":
        outside = np.maximum(outside, np.abs(across) - 15 * MM)
    height = np.where(np.isnan(height), 20 * MM - 0.5 * np.abs(across), height)
    on = outside < (1.5 * MM if kind == "wire_circle" else 0.0)
    ceiling = np.where(on, height, np.maximum(height.max() - 1.2 * np.maximum(outside, 0), 1 * MM))
    weight = (on & (np.hypot(*np.gradient(height, MM)) < 1)).astype(float)
    return Relief((-N // 2, -N // 2), ceiling, np.where(weight > 0, ceiling, 0.0), weight, 0 * weight)


def judged(kind, relief):
    return contradiction(kind, surface_of(kind), dimensions(kind), relief, MIDDLE, HEADING)


def changed(relief, there, height, weight=1.0, hung=0.0):
    for values, new in (
        (relief.ceiling, height),
        (relief.height, height),
        (relief.weight, weight),
        (relief.hung, hung),
    ):
        values[there] = new
    return relief


@pytest.mark.parametrize("kind", SIZES)
def test_a_shape_agrees_with_presses_over_it(kind):
    assert judged(kind, mapped(kind)) == ""


@pytest.mark.parametrize("kind", [kind for kind in SIZES if kind != "point"])
def test_a_lower_face_beside_it_is_not_of_it(kind):
    along, across = placed()
    beside = (np.abs(along - 34 * MM) < 5 * MM) & (np.abs(across) < 12 * MM)
    assert "felt outside" in judged(kind, changed(mapped(kind), beside, 8 * MM))


@pytest.mark.parametrize("kind", ["block", "disc", "half_cylinder", "domes"])
@pytest.mark.parametrize(("by", "why"), [(3 * MM, "felt above"), (-3 * MM, "above where the membrane hung")])
def test_a_bump_and_a_hollow_in_its_surface_are_not_of_it(kind, by, why):
    relief = mapped(kind)
    top = relief.ceiling.copy()
    along, across = placed()
    there = np.hypot(along, across) < 5 * MM
    assert why in judged(kind, changed(relief, there, (top + by)[there]))


def test_of_a_small_face_a_small_part_shows_that_it_is_none():
    along, across = placed()
    size = {"radius": Dimension(8 * MM, 0.1 * MM, {}), "height": Dimension(20 * MM, 0.1 * MM, {})}
    away = np.hypot(along, across)
    relief = changed(mapped("disc"), away > 8 * MM, 5 * MM, 0.0)
    assert contradiction("disc", SURFACES["disc"], size, relief, MIDDLE, HEADING) == ""
    hole = changed(relief, away < 3 * MM, 15 * MM, 0.0)
    assert "above where" in contradiction("disc", SURFACES["disc"], size, hole, MIDDLE, HEADING)


def test_a_face_is_no_point():
    along, across = placed()
    there = (np.abs(along) < 20 * MM) & (np.abs(across) < 15 * MM)
    assert "felt above" in judged("point", changed(mapped("point"), there, TOPS["point"]))


@pytest.mark.parametrize(
    ("kind", "lift", "refused"),
    [
        ("block", 0.0, True),
        ("disc", 0.0, True),
        ("half_cylinder", 0.0, False),
        ("block", 0.4, False),
        ("disc", 0.4, False),
    ],
)
def test_a_face_over_which_the_membrane_hangs_is_none_unless_its_edges_lift_it(kind, lift, refused):
    relief = mapped(kind)
    along, across = placed()
    there = np.hypot(along, across) < 9 * MM
    hung = changed(relief, there, relief.ceiling[there], weight=1.0, hung=3.0)
    sizes = dimensions(kind)
    known = {**sizes, "height": Dimension(sizes["height"].value, 0.2 * MM, {"membrane": -lift * MM})}
    assert ("hung freely" in contradiction(kind, surface_of(kind), known, hung, MIDDLE, HEADING)) == refused


def test_what_no_shape_explains_is_told_by_its_extents_unless_a_shape_is_taken_for_granted():
    felt = m.felt(m.block(40 * MM, 28 * MM, 20 * MM, HEADING), 20 * MM, places=((0.0, 0.0),))
    alone = mapped("block", np.zeros(2))
    assert fit_object(*felt, relief=alone).kind == "block"
    along, across = placed(np.zeros(2))
    step = changed(alone, (np.abs(along - 30 * MM) < 8 * MM) & (np.abs(across) < 12 * MM), 8 * MM)
    found = fit_object(*felt, relief=step)
    assert found.kind == "extents"
    assert "outside" in next(w.refused for w in found.ranking if w.kind == "block")
    assert fit_object(*felt, relief=step, shape="block").kind == "block"
