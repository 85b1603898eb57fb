"""The domain perception: every step answers, within its bound, and beside the least error there can be."""

import math

import pytest

from stretch_bt.accuracy import domain_perception
from stretch_bt.accuracy.perception.measure import QUICK
from stretch_bt.accuracy.points import ANSWERED, REFERENCE, SKIPPED

#: how many cases of each step are measured
CASES = 2

#: largest error under white noise, in units of 1, rad, m and 1/m
BOUNDS = {
    "normals: kernel 1.9 mm": 0.06,
    "curvature: kernel 1.9 mm": 45.0,
    "height: true labels": 0.4e-3,
    "height: our labels": 0.3e-3,
    "contact size: circle": 0.3e-3,
    "contact size: auto": 0.3e-3,
    "contact size: ellipse": 1.2e-3,
    "circularity: contour": 0.05,
    "sphere fit, true contact: all points": 0.2,
}

#: by how much more smooth noise may err
SMOOTH = 5.0


@pytest.fixture(scope="module")
def rows(measured):
    """The first cases of each step, on few frames."""
    jobs = [job for cases in domain_perception.by_case(QUICK) for case in cases[:CASES] for job in case]
    return [row for row in measured("perception", domain_perception.DOMAIN, jobs) if row.status != SKIPPED]


@pytest.mark.parametrize("setting", BOUNDS)
def test_errors_stay_below_their_bounds(rows, setting):
    found = [row for row in rows if str(row.setting) == setting]
    assert found
    for row in found:
        assert 0 <= row.error < BOUNDS[setting] * (SMOOTH if "correlated" in row.case else 1.0), row
        assert row.cpu_seconds > 0


def test_every_row_has_an_error_or_says_why_not(rows):
    for row in rows:
        answered = row.status in ANSWERED
        assert answered == (row.error is not None and math.isfinite(row.error)), row
        assert answered or (row.status, row.reason is None) == ("refused", False), row
        assert row.error_kind in domain_perception.DOMAIN.kinds
    assert {row.error_kind for row in rows} == domain_perception.DOMAIN.kinds.keys()


def test_our_rule_errs_less_than_that_of_the_paper(rows):
    ours, paper = (
        {row.case: row.error for row in rows if (row.error_kind, row.setting.variant) == ("overlap", rule)}
        for rule in ("rule mean", "rule either")
    )
    assert ours.keys() == paper.keys() != set()
    for case in ours:
        assert ours[case] < paper[case]


def test_a_sphere_fit_comes_near_the_least_error(rows):
    found = [row for row in rows if row.error_kind == "radius"]
    bound = next(row.error for row in found if row.status == REFERENCE)
    fit = next(row.error for row in found if str(row.setting) == "sphere fit, true contact: all points")
    assert fit < 3.0 * bound  # the root mean square of four frames
