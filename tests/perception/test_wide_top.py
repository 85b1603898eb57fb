"""Heights of tops by discs wider than the contact."""

import numpy as np
import pytest
from height_noise import NOISES, height, seen, surface_of

from stretch_bt.perception import wide_top
from stretch_bt.perception.noise_spectrum import NoiseSpectrum
from stretch_bt.perception.top import Points
from stretch_bt.perception.wide_top import by_wide_discs
from stretch_bt.units import Estimate

SIDE, PITCH, RADIUS = 300, 0.4e-3, 8e-3
SHARED = NoiseSpectrum(np.array([0.3e-3**2]), np.array([5.0]))


def points(every, radius):
    """Return the points of every so many rows and columns of a cap within a radius."""
    v, u = (w.reshape(-1) for w in np.mgrid[0:SIDE:every, 0:SIDE:every])
    x, y = (u - SIDE / 2) * PITCH, (v - SIDE / 2) * PITCH
    near = np.hypot(x, y) <= radius
    x, y = x[near], y[near]
    cloud = np.stack([x, y, 0.01 - (x**2 + y**2) / 0.06])
    return Points(cloud, (v * SIDE + u)[near], SIDE, SHARED, every)


def discs(monkeypatch, every, radius=RADIUS):
    """Return the radii of the discs that are tried, over the contact's radius."""
    tried = []
    monkeypatch.setattr(wide_top, "_of_disc", lambda around, middle, radius, share: tried.append(share))
    by_wide_discs(Estimate(0.01, 5e-4), points(every, radius), points(every, 4 * radius))
    return tried


@pytest.mark.parametrize("every", [2, 3])
def test_the_discs_of_a_thinned_contact_are_as_wide(monkeypatch, every):
    whole, thinned = discs(monkeypatch, 1), discs(monkeypatch, every)
    assert len(whole) == len(thinned) > 1
    assert thinned == pytest.approx(whole, rel=0.1)


def test_no_disc_is_wider_than_those_whose_error_is_known(monkeypatch):
    assert not discs(monkeypatch, 1, 2e-3)


def test_the_higher_of_two_bodies_under_shared_noise_is_off_by_what_is_stated():
    """The discs took in both bodies and the skirt: 3.4 mm at a stated 0.3 came out of 4.8."""
    surface = surface_of("two", 0)
    found = height(seen(surface, NOISES["shared 0.3, 5 px"], np.random.default_rng((0, 7))))
    assert abs(found.value - surface.top) < 3 * found.sd < 2.5e-3


def offs(shape, noise, draws):
    """Return the errors, mm, of as many heights of one shape, and these over what is stated."""
    errors = []
    for number in range(draws):
        surface = surface_of(shape, number % 12)
        found = height(seen(surface, NOISES[noise], np.random.default_rng((number, 7))))
        errors.append((1e3 * (found.value - surface.top), (found.value - surface.top) / found.sd))
    return np.sqrt(np.mean(np.square(errors), axis=0))


def test_a_contact_over_which_noise_is_alike_gives_the_height_with_its_error():
    """Wider discs alone were asked: tips were off by 0.85 mm rms, and balls stated twice their error."""
    off, ratio = offs("analytic tip", "shared 0.3, 5 px", 12)
    assert off < 0.5
    assert ratio < 1.3
    off, ratio = offs("sphere", "shared 0.3, 8 px", 12)
    assert off < 0.5
    assert 0.7 < ratio < 1.3


def test_a_cone_that_noise_makes_look_flat_or_round_is_no_surer_than_that():
    """One tip in ten round tops, and flat rather than round, left cones off by 1.8 stated deviations."""
    assert offs("analytic cone", "shared 0.3, 2 px", 24)[1] < 1.5


def test_a_tip_is_not_seen_by_discs_that_it_is_sharper_than():
    """These were 1.7 to 2.3 mm too low: the surest disc, of 8 to 13 mm, lay so far below the tip."""
    errors = []
    for number in (3, 8, 15, 20, 27, 32):
        surface = surface_of("analytic tip", number % 12)
        frame = seen(surface, NOISES["shared 0.3, 3 px"], np.random.default_rng((number, 7)))
        errors.append(height(frame).value - surface.top)
    assert np.sqrt(np.mean(np.square(errors))) < 0.8e-3
