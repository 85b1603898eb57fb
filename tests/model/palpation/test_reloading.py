"""Readings of an object that does not come back as it went, beside the curve of first loading."""

import numpy as np
import pytest
from scipy.optimize import brentq

from stretch_bt.model import ForceModel, TopReading, fit_series
from stretch_bt.model.palpation.reloading import left_behind, reloads
from stretch_bt.units import Estimate

MODEL = ForceModel.default()
RADIUS, TOP = 0.03, 0.06
FIRST = [(0.0, depth / 1e3) for depth in (3, 5, 7, 9, 11, 13, 15)]
AGAIN = [(0.01, depth / 1e3) for depth in (3, 5, 7, 9)]


def grains(ratio):
    """Return the force by drop of grains that load again `ratio` times as stiff up to their largest drop, and how to push them."""
    largest = [0.0]

    def law(drop):
        first = 800.0 * 1.5e-3 * (max(drop, 0.0) / 1.5e-3) ** 1.5
        set_ = largest[0] * (1 - 1 / ratio)
        return first if drop >= largest[0] else 800.0 * 1.5e-3 * (max(ratio * (drop - set_), 0.0) / 1.5e-3) ** 1.5

    return law, largest


def pressed(ratio, poses, *, sd, noise):
    law, largest = grains(ratio)
    readings = []
    for stretch, depth in poses:
        hand = TOP - depth
        height = brentq(
            lambda h, hand=hand, stretch=stretch: MODEL.predict(RADIUS, stretch, max(h - hand, 0.0))[0] - law(TOP - h),
            max(hand, TOP - 0.02),
            TOP,
            xtol=1e-14,
        )
        largest[0] = max(largest[0], TOP - height)
        readings.append(TopReading(stretch, hand, height + sd * noise.standard_normal(), sd))
    return readings


def below(ratio, seed, sd=5e-5):
    readings = pressed(ratio, FIRST + AGAIN, sd=sd, noise=np.random.default_rng(seed))
    loading = fit_series(MODEL, Estimate(RADIUS, 0.0), readings[: len(FIRST)])
    return left_behind(loading, MODEL, RADIUS, readings[len(FIRST) :], 5e-5)


def test_only_what_lies_clearly_below_an_earlier_press_is_loaded_again():
    readings = pressed(1.0, FIRST + AGAIN + [(0.01, 0.015)], sd=2e-5, noise=np.random.default_rng(0))
    most = reloads(MODEL, RADIUS, readings)
    highest = MODEL.predict(RADIUS, 0.0, readings[len(FIRST) - 1].height - readings[len(FIRST) - 1].hand)[0]
    assert np.all(most[: len(FIRST)] == 0)
    assert most[len(FIRST) : -1] == pytest.approx(highest, rel=0.02)
    assert most[-1] == 0, "more force than ever is first loading again"


def test_looks_at_one_press_are_no_loading_again():
    readings = pressed(1.0, [(0.0, 0.003), *[(0.0, 0.012)] * 6], sd=2e-4, noise=np.random.default_rng(1))
    assert not reloads(MODEL, RADIUS, readings).any()


def test_a_set_is_found_with_its_deviation():
    found = [below(3.0, seed) for seed in range(12)]
    assert all(set_.value > 3 * set_.sd for set_ in found)
    assert np.std([set_.value for set_ in found]) < 1.3 * found[0].sd


def test_an_object_that_comes_back_shows_none():
    found = [below(1.0, seed) for seed in range(60)]
    scores = np.array([set_.value / set_.sd for set_ in found])
    assert np.abs(scores).max() < 3
    assert abs(scores.mean()) < 0.5
