"""How far a membrane that resists bending stands above a flat top."""

import numpy as np
import pytest

from benchmarks.height_noise import NOISES, seen, surface_of
from benchmarks.lift_off import by_law, drawn
from stretch_bt.errors import InvalidInput, NoContact
from stretch_bt.perception import find_contact, lift_off
from stretch_bt.perception.drum import PART
from stretch_bt.perception.types import CONTACT, UNDEFORMED

THICK, STRAIN = 2e-3, 0.12


def found(shape, number, noise="SR305"):
    """Return the lift over a body, and the height that it is told for."""
    surface = surface_of(shape, number)
    contact = find_contact(seen(surface, NOISES[noise], np.random.default_rng(number)))
    return lift_off(contact.surface, contact.labels, surface.top, THICK, STRAIN), surface.top


def test_presses_of_the_solved_sheet_lie_within_what_the_law_states():
    rng = np.random.default_rng(21)
    presses = [drawn(rng) for _ in range(12)]
    ratios = [(press.lift - by_law(press)) / (PART * by_law(press)) for press in presses]
    assert 0.4 < np.sqrt(np.mean(np.square(ratios))) < 1.6
    assert max(press.lift for press in presses) > 0.2e-3


@pytest.mark.parametrize("number", range(4))
def test_a_flat_top_is_lifted_and_a_round_one_hardly(number):
    flat, round_ = found("cylinder", number)[0], found("sphere", number)[0]
    assert flat.value > 0.03e-3
    assert 0.2 * flat.value < flat.sd < 0.8 * flat.value
    assert round_.value < 0.35 * flat.value + 0.02e-3


@pytest.mark.parametrize(("thickness", "strain"), [(0.0, 0.1), (2e-3, 0.0), (-1e-3, 0.1)])
def test_a_membrane_without_thickness_or_strain_is_refused(thickness, strain):
    with pytest.raises(InvalidInput, match="must be above 0"):
        lift_off(np.zeros((4, 4, 3)), np.zeros((4, 4), np.uint8), 0.01, thickness, strain)


def test_no_point_in_contact_is_refused():
    contact = find_contact(seen(surface_of("sphere", 0), NOISES["SR305"], np.random.default_rng(0)))
    with pytest.raises(NoContact, match="press deeper"):
        lift_off(contact.surface, np.full_like(contact.labels, UNDEFORMED), 0.01, THICK, STRAIN)


@pytest.mark.parametrize("seen_of_it", [1, 12, 29])
def test_a_contact_of_few_points_may_be_flat_or_round(seen_of_it):
    surface = surface_of("cylinder", 0)
    contact = find_contact(seen(surface, NOISES["SR305"], np.random.default_rng(0)))
    labels = contact.labels.copy()
    labels.reshape(-1)[np.flatnonzero(labels == CONTACT)[seen_of_it:]] = UNDEFORMED
    lift = lift_off(contact.surface, labels, surface.top, THICK, STRAIN)
    assert lift.sd == lift.value > 0.03e-3


@pytest.mark.parametrize("height", [0.0, -1e-3])
def test_a_contact_at_its_clamps_is_lifted_as_one_of_a_millimetre(height):
    contact = find_contact(seen(surface_of("cylinder", 0), NOISES["SR305"], np.random.default_rng(0)))
    lift = lift_off(contact.surface, contact.labels, height, THICK, STRAIN)
    assert 0.0 < lift.value < 0.2e-3
    assert lift.sd > 0.0
