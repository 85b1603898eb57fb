"""Round contacts of a sheet that resists bending, whose mounts stretch it."""

import numpy as np
import pytest

from stretch_bt.accuracy.perception.noise import WHITE_03, observe
from stretch_bt.accuracy.perception.render import render
from stretch_bt.accuracy.perception.view import CAMERA, PLANE_DISTANCE, BodyPress, SheetView
from stretch_bt.errors import InvalidInput
from stretch_bt.perception import find_contact, measure_contact
from stretch_bt.perception.size.prior import SKIRTS, shipped_prior
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.membrane.press import press

MOUNT = 0.0119


def shown(diameter, stretch, depth, at):
    """Return a frame of a press."""
    solved = press(Cylinder(diameter), stretch, depth, at=at, mount_prestretch=MOUNT, effects=("bending",)).detail
    seen, points = render(solved.shape, CAMERA, PLANE_DISTANCE)
    touching = np.isfinite(points[..., 2])
    touching[touching] = solved.touches(points[touching])
    return observe(
        SheetView(BodyPress(Cylinder(diameter), stretch, depth, at), seen.astype(np.float32), touching, 0.0),
        WHITE_03,
        1,
    )


@pytest.mark.parametrize(
    ("diameter", "stretch", "depth", "at"),
    [(0.018, 0.0, 0.009, (1e-3, -2e-3)), (0.024, 0.025, 0.006, (-2e-3, 1e-3)), (0.013, 0.05, 0.012, (0.0, 0.0))],
)
def test_what_is_round_is_found_round_and_to_half_a_millimetre(diameter, stretch, depth, at):
    frame = shown(diameter, stretch, depth, at)
    contact = find_contact(frame)
    size = measure_contact(contact.surface, contact.labels, stretch=stretch + MOUNT, prior=shipped_prior("thick"))
    assert size.shape == "circle"
    assert abs(size.diameter_i - diameter) < 0.5e-3
    assert abs(size.diameter_i - diameter) < 3 * size.diameter_i_sd


def test_a_skirt_that_does_not_exist_is_named():
    with pytest.raises(InvalidInput, match="no skirt 'fat'; write one of thin, thick"):
        shipped_prior("fat")
    assert {shipped_prior(name).covariance(0.03).shape for name in SKIRTS} == {(9, 9)}
