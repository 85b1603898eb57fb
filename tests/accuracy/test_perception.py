"""The domain perception: every step answers, within its bound, and beside the least error there can be."""

import math

import pytest

from stretch_bt.accuracy import domain_perception, measure

#: largest error in the quick run, in units of 1, rad, m and 1/m
BOUNDS = {
    "normals: kernel 1.9 mm": 0.06,
    "curvature: kernel 1.9 mm": 45.0,
    "height: true labels": 0.3e-3,
    "height: our labels": 0.3e-3,
    "contact size: circle": 0.3e-3,
    "contact size: auto": 0.3e-3,
    "contact size: ellipse": 1.2e-3,
    "outline: contour": 0.05,
    "sphere fit, true contact: every 1. point": 0.2,
}


@pytest.fixture(scope="module")
def rows():
    return list(measure(["perception"], quick=True))


@pytest.mark.parametrize("setting", BOUNDS)
def test_errors_stay_below_their_bounds(rows, setting):
    found = [row for row in rows if row.setting == setting]
    assert found
    for row in found:
        assert 0 <= row.error < BOUNDS[setting], row
        assert row.cpu_seconds > 0


def test_every_row_has_an_error_or_says_why_not(rows):
    for row in rows:
        answered = row.status in ("ok", "reference")
        assert answered == (row.error is not None and math.isfinite(row.error)), row
        assert answered or row.status.startswith("refused: "), row
        assert row.error_kind in domain_perception.KINDS
    assert {row.error_kind for row in rows} == domain_perception.KINDS.keys()


def test_our_rule_errs_less_than_that_of_the_paper(rows):
    apart = {(row.case, row.setting): row.error for row in rows if row.error_kind == "overlap"}
    cases = {case for case, _ in apart}
    for case in cases:
        assert apart[case, "classes: rule mean"] < apart[case, "classes: rule either"]


def test_a_sphere_fit_comes_near_the_least_error(rows):
    bound = next(row.error for row in rows if row.setting == "sphere fit: Cramer-Rao bound")
    fit = next(row.error for row in rows if row.setting == "sphere fit, true contact: every 1. point")
    assert fit < 3.0 * bound  # the root mean square of four frames
