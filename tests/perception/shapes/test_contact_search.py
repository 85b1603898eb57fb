"""Where a fit begins decides over where it ends: presses of which a sphere or a face was once lost."""

import numpy as np
import pytest
from perception_contact_curvature import NOISES, drawn, observed

from stretch_bt.errors import IllConditioned
from stretch_bt.perception import find_contact, fit_contact_sphere


def pressed(kind, noise, seed):
    view = drawn(kind, np.random.default_rng([seed, 71]))
    noise = next(n for n in NOISES if n.name == noise)
    return view.body, find_contact(observed(view, noise, np.random.default_rng([seed, 72])))


@pytest.mark.parametrize("seed", [49, 79])
def test_a_large_ball_whose_first_fit_went_astray_is_found_beside_the_face(seed):
    body, contact = pressed("sphere", "white 1.0", seed)
    sphere = fit_contact_sphere(contact)
    assert abs(sphere.curvature - body.curvature) < 4 * sphere.curvature_sd < 0.05 * body.curvature


@pytest.mark.parametrize(
    ("noise", "seed"),
    [("white 0.3", 3033), ("white 0.5", 3033), ("white 0.5", 3063), ("white 0.5", 3081), ("SR305-like", 3033)],
)
def test_a_face_in_a_window_much_wider_than_it_is_no_ball(noise, seed):
    """Each once got a radius of some 85 mm, its curvature 8 to 28 deviations from zero."""
    with pytest.raises(IllConditioned):
        fit_contact_sphere(pressed("face", noise, seed)[1])
