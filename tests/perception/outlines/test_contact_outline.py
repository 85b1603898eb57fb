"""The border of a contact, with the standard deviation of its place."""

from dataclasses import replace

import numpy as np
import pytest
from height_noise import NOISES, seen
from leaning_tops import leaning

from stretch_bt.errors import IllConditioned
from stretch_bt.perception import Contact, contact_outline, find_contact, outline_of
from stretch_bt.perception.outlines.border import border_of, past_labels
from stretch_bt.perception.outlines.contact_outline import UNPULLED, UNSEEN

PIXEL, RIM = 0.4e-3, 0.038  # m


def ball(radius=0.02, touching=0.006, bend=0.0, reach=0.0, noise=1e-5, stretch=0.02):
    """A ball under a membrane pulled alike: its curvature ends where it stops touching, or falls off over `bend`; labels reach further."""
    v, u = np.mgrid[:200, :200]
    away = np.hypot((u - 100) * PIXEL, (v - 100) * PIXEL)
    r = np.linspace(0.0, 0.06, 12001)
    bent = (r < touching) / radius + (np.exp(-(r - touching) / bend) * (r >= touching) / radius if bend else 0.0)
    # The slope by the balance of a ring: T h' r = - T integral of twice the mean curvature.
    slope = -np.concatenate([[0.0], np.cumsum(2 * bent[1:] * r[1:] * np.diff(r))]) / np.maximum(r, 1e-9)
    height = np.concatenate([[0.0], np.cumsum(0.5 * (slope[1:] + slope[:-1]) * np.diff(r))])
    height -= np.interp(RIM, r, height)
    seen = np.maximum(np.interp(away, r, height), 0.0) + noise * np.random.default_rng(3).standard_normal(away.shape)
    return Contact.from_heights(seen, PIXEL, noise=max(noise, 1e-6), labels=away < touching + reach, stretch=stretch)


@pytest.mark.parametrize("reach", [0.0, 1.5e-3, 3e-3])
@pytest.mark.parametrize("bend", [0.0, 2e-3])
def test_the_border_is_found_from_labels_that_reach_too_far(reach, bend):
    """The labels' area was once taken as it is, with a stated 0.5 mm^2: 85 mm^2 too much at 3 mm."""
    contact, true = ball(bend=bend, reach=reach), np.pi * 0.006**2
    found = contact_outline(contact)
    assert abs(found.area - true) < 2.5 * found.area_sd
    assert abs(found.perimeter - 2 * np.pi * 0.006) < 2.5 * found.perimeter_sd
    if reach > 2e-3:
        labelled = outline_of(contact.labels, contact.surface)
        assert labelled.area - true > 20 * labelled.area_sd


def test_an_error_of_place_moves_area_and_perimeter_together():
    found = contact_outline(ball())
    assert found.place_sd > 0.2e-3
    assert found.area_sd == pytest.approx(found.perimeter * found.place_sd, rel=0.1)
    assert found.perimeter_sd > 2 * np.pi * found.place_sd


def test_noise_and_a_wide_kernel_state_the_place_wider():
    clear, noisy = border_of(ball()), border_of(ball(noise=0.6e-3))
    assert noisy.kernel > clear.kernel
    assert noisy.shift.sd > 1.5 * clear.shift.sd


def test_what_is_labelled_may_have_dropouts():
    contact = ball()
    contact.labels[::7, ::5] = 255
    inside = past_labels(contact)
    assert inside[100, 100] == pytest.approx(-0.006 / PIXEL, abs=1.5)


def unseen(contact, place=UNSEEN):
    """Whether the labels are taken as they are, with a border that may be so far off."""
    found, labelled = contact_outline(contact), outline_of(contact.labels, contact.surface)
    assert found.area == labelled.area
    return found.place_sd == place and found.area_sd > 0.9 * found.perimeter * place


def test_a_membrane_that_is_not_pulled_shows_no_border():
    contact = ball(stretch=0.0)
    assert unseen(contact, UNPULLED)
    with pytest.raises(IllConditioned, match="not pulled"):
        border_of(contact)


def test_labels_of_one_rim_of_a_face_are_no_contact():
    v, u = np.mgrid[:200, :200]
    away = np.hypot((u - 100) * PIXEL, (v - 100) * PIXEL)
    heights = 0.01 * np.clip(np.log(RIM / np.maximum(away, 0.013)) / np.log(RIM / 0.013), 0.0, 1.0)
    part = (away < 0.015) & (v > 118)
    contact = Contact.from_heights(heights, PIXEL, noise=1e-5, labels=part, stretch=0.02)
    assert unseen(contact)
    with pytest.raises(IllConditioned, match="part of it"):
        border_of(contact)
    crescent = (away < 0.006) & (np.hypot((u - 100) * PIXEL, (v - 108) * PIXEL) > 0.005)
    assert unseen(replace(ball(), labels=np.where(crescent, 2, 1).astype(np.uint8)))


def test_noise_that_hides_the_curvature_hides_the_border():
    contact = ball(radius=0.04, touching=0.003, noise=1e-3)
    assert unseen(contact)
    with pytest.raises(IllConditioned, match="stands out of the noise"):
        border_of(contact)


@pytest.mark.parametrize("far", [0.010, 0.026, 0.028])
def test_labels_that_end_far_from_any_border_state_as_much(far):
    """A border was fitted to the concave ring at the edge of the sheet, and stated with 0.35 mm."""
    contact = ball(reach=far)
    found = contact_outline(contact)
    assert found.place_sd > 1e-3


@pytest.mark.parametrize(
    ("shape", "number", "area"), [("box", 0, 26 * 31), ("box", 5, 21 * 18), ("cylinder", 5, 33**2 * np.pi / 4)]
)
def test_a_face_that_leans_states_how_far_it_reaches_past_its_labels(shape, number, area):
    """Its high part, a quarter of a face of 26 by 31 mm, was once taken for all of it, four stated deviations off."""
    surface, _ = leaning(shape, 2, number)
    found = contact_outline(find_contact(seen(surface, NOISES["white 0.3"], np.random.default_rng((number, 7)))))
    assert abs(found.area * 1e6 - area) < 1.3 * found.area_sd * 1e6


@pytest.mark.parametrize(("degrees", "radius"), [(20, 8e-3), (30, 8e-3), (30, 5.5e-3), (45, 6e-3)])
def test_the_border_of_a_cone_is_no_balls(degrees, radius):
    """A cone is curved most at its tip, which was taken for all of the contact: areas came out 5 to 12 times too small."""
    y, x = np.mgrid[-120:121, -120:121] * 4e-4
    away, steep = np.hypot(x, y), np.tan(np.radians(degrees))
    beside = radius * np.log(np.maximum(away, radius) / radius)  # harmonic, and as steep as the cone at its border
    heights = steep * (radius * np.log(75e-3 / radius) - np.where(away < radius, away - radius, beside))
    for seed in range(3):
        noisy = heights + np.random.default_rng(seed).normal(0, 1e-4, heights.shape)
        found = contact_outline(Contact.from_heights(noisy, 4e-4, noise=1e-4))
        assert found.area == pytest.approx(np.pi * radius**2, rel=0.25)
        assert abs(found.area - np.pi * radius**2) < 3 * found.area_sd
