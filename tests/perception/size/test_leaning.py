"""Sizes of faces of which the labels hold the high side alone."""

import numpy as np
import pytest
from height_noise import NOISES, seen
from leaning_tops import POOL, _leaning

from stretch_bt.errors import NoAnswer
from stretch_bt.perception import find_contact, measure_contact


@pytest.mark.parametrize(("shape", "band"), [("box", 3), pytest.param("cylinder", 2, marks=pytest.mark.slow)])
def test_a_size_is_off_by_what_it_states_or_is_refused(shape, band):
    """Of blocks that lean by 4 to 6 degrees it was 10 mm off, 4.7 stated deviations."""
    over = []
    for number in range(POOL, POOL + 12):
        surface, _, wide = _leaning(shape, band, number)
        contact = find_contact(seen(surface, NOISES["white 0.3"], np.random.default_rng((number - POOL, 7))))
        try:
            size = measure_contact(contact.surface, contact.labels)
        except NoAnswer:
            continue
        over += [(size.diameter_i - wide[0]) / size.diameter_i_sd, (size.diameter_j - wide[1]) / size.diameter_j_sd]
    assert len(over) > 6
    assert np.sqrt(np.mean(np.square(over))) < 1.6
