"""Pixels that are centimetres off, in a contact that was made by hand."""

import numpy as np
import pytest
from height_noise import NOISES, seen, surface_of

from stretch_bt.perception import find_contact, measure_contact, track_height
from stretch_bt.perception.types import CONTACT

AWAY = 0.03  # m


def contact_of(number, share, away):
    """Return the contact of a box with a share of the pixels beside it off by so much, the top and the width it has without them."""
    surface = surface_of("box", number)
    contact = find_contact(seen(surface, NOISES["white 0.05"], np.random.default_rng((number, 5))))
    whole = contact.surface.copy()
    beside = np.flatnonzero((contact.labels != CONTACT) & np.isfinite(whole[..., 2]))
    rng = np.random.default_rng(9)
    wild = rng.choice(beside, round(share * beside.size), replace=False)
    contact.surface[..., 2].reshape(-1)[wild] += away * rng.uniform(0.5, 1.5, wild.size)
    return contact, whole, surface.top


@pytest.mark.parametrize("away", [AWAY, -AWAY])
def test_a_height_stays_within_what_it_states(away):
    """It was 8 stated deviations off."""
    contact, _, true = contact_of(3, 0.01, away)
    top = track_height(contact.surface, np.isfinite(contact.surface[..., 2]), contact.labels)
    assert abs(top.value - true) < 3 * top.sd < 0.3e-3


@pytest.mark.parametrize("away", [AWAY, -AWAY])
def test_a_size_stays_within_what_it_states(away):
    """A box came out as a circle whose width was 5 stated deviations off."""
    contact, whole, _ = contact_of(1, 0.05, away)
    size = measure_contact(contact.surface, contact.labels, stretch=contact.stretch)
    quiet = measure_contact(whole, contact.labels, stretch=contact.stretch)
    assert size.shape == quiet.shape
    assert abs(size.diameter_i - quiet.diameter_i) < size.diameter_i_sd
