"""Sizes on surfaces of the sheet solver, none of which the prior was made from."""

import numpy as np
import pytest

from stretch_bt.accuracy.perception.noise import CORRELATED, WHITE_05, observe
from stretch_bt.accuracy.perception.view import PLANE_DISTANCE, BodyPress, seen
from stretch_bt.perception import deproject, diameters, measure_contact, to_membrane
from stretch_bt.perception.smooth import smooth
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder

PRESSES = [
    BodyPress(Cylinder(0.016), 0.0, 0.012, (0.004, -0.006)),
    BodyPress(Cylinder(0.018), 0.025, 0.011, (-0.007, 0.003)),
    BodyPress(Cylinder(0.026), 0.055, 0.011, (0.002, 0.007)),
]


def surface_of(press, noise, seed):
    """Return points and labels: what the smoothed height shows, as a segmentation would roughly have it."""
    points, valid = deproject(observe(seen(press), noise, seed))
    points = to_membrane(points, PLANE_DISTANCE)
    height, _ = smooth(np.where(valid, points[..., 2], 0.0).astype(np.float32), valid.astype(np.float32), 6.0)
    return points, np.where(valid, np.where(height > 0.85 * height.max(), 2, 1), 255).astype(np.uint8)


@pytest.mark.parametrize(
    ("press", "noise", "within"),
    [
        pytest.param(press, noise, within, id=f"{how}-{name}", marks=pytest.mark.slow if how == slow else ())
        for press, name, slow in zip(
            PRESSES, ("slack", "middle", "tight"), ("correlated", "white", "correlated"), strict=True
        )
        for noise, within, how in ((WHITE_05, 0.6e-3, "white"), (CORRELATED, 3e-3, "correlated"))
    ],
)
def test_a_cylinder_is_a_circle_of_its_diameter(press, noise, within):
    for seed in range(3):
        size = measure_contact(*surface_of(press, noise, seed), stretch=press.stretch, fillet_sd=0.0)
        error = size.diameter_i - press.indenter.diameter
        assert size.shape == "circle"
        assert size.evidence["circle"] > size.evidence["ellipse"] - 5.0
        assert abs(error) < min(within, 4.5 * size.diameter_i_sd)
        assert size.diameter_i_sd < within
        assert size.center == pytest.approx(press.at, abs=4 * max(size.center_sd))
        assert size.depth == pytest.approx(press.depth, abs=5 * size.depth_sd)


@pytest.mark.parametrize("press", PRESSES[1:], ids=["middle", "tight"])
def test_free_of_roundness_both_axes_are_found(press):
    size = measure_contact(*surface_of(press, WHITE_05, 0), stretch=press.stretch, hypothesis="ellipse", fillet_sd=0.0)
    assert size.shape == "ellipse"
    assert abs(size.diameter_i - press.indenter.diameter) < 0.5e-3
    assert abs(size.diameter_j - press.indenter.diameter) < 4 * size.diameter_j_sd < 5e-3
    assert size.diameter_j_sd > 2 * size.diameter_i_sd


@pytest.mark.parametrize("thinned", [np.s_[::2], np.s_[:, ::2]], ids=["rows", "columns"])
def test_pixels_need_not_be_square(thinned):
    points, labels = surface_of(PRESSES[1], WHITE_05, 0)
    size = measure_contact(points[thinned], labels[thinned], stretch=PRESSES[1].stretch, fillet_sd=0.0)
    assert size.shape == "circle"
    assert abs(size.diameter_i - PRESSES[1].indenter.diameter) < 4.5 * size.diameter_i_sd < 3e-3


def test_without_the_stretch_the_error_grows_and_is_stated():
    points, labels = surface_of(PRESSES[1], WHITE_05, 0)
    known, unknown = diameters(points, labels, stretch=PRESSES[1].stretch), diameters(points, labels)
    assert known.i_sd < unknown.i_sd < 1e-3
    assert abs(unknown.i - 0.018) < 4 * unknown.i_sd


def test_the_fillet_and_its_error_enter_the_size():
    points, labels = surface_of(PRESSES[1], WHITE_05, 0)
    sharp, blunt = (
        diameters(points, labels, stretch=0.025, hypothesis="circle", fillet=f, fillet_sd=0.0) for f in (0.5e-3, 1e-3)
    )
    # an edge that is rounder by 0.5 mm makes the object wider by up to twice that
    assert 0.3e-3 < blunt.i - sharp.i < 1e-3
    unsure = diameters(points, labels, stretch=0.025, hypothesis="circle", fillet_sd=0.5e-3)
    by_fillet = np.sqrt(unsure.i_sd**2 - blunt.i_sd**2)
    assert by_fillet == pytest.approx(blunt.i - sharp.i, rel=0.3)
