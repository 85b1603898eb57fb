"""What a map says as numbers, on maps whose errors are known."""

from itertools import product

import numpy as np
import pytest

from stretch_bt.errors import IllConditioned
from stretch_bt.model.calibration.sensitivity import METHODS, Found, Sensed
from stretch_bt.model.calibration.sensitivity_trends import cells_of, fine_share, mean_error, trend

SIZES, STRETCHES, DEPTHS = (0.01, 0.02, 0.03), (0.0, 0.03, 0.06), (0.002, 0.005, 0.01, 0.015)


def presses(error, refused=lambda *_: False, trials=1):
    """Return presses on a grid whose errors along i and j are (+e, -e), as a function of size, stretch and depth, m."""
    found = []
    for size, stretch, depth in product(SIZES, STRETCHES, DEPTHS):
        for trial in range(1, trials + 1):
            e = error(size, stretch, depth)
            fit = (
                Found("fit", refused="no") if refused(size, stretch, depth) else Found("fit", size + e, 0, size - e, 0)
            )
            rest = (Found(m, refused="never") for m in METHODS[1:])
            # the arm and the gripper do not stand just where they were sent
            found.append(Sensed("cylinder", size, stretch + 1e-4, depth - 5e-5, trial, (fit, *rest), 0.0))
    return found


def linear(size, stretch, depth):
    return 1e-3 + 0.02 * size + 0.01 * stretch - 0.05 * depth


def test_slopes_and_ranks_are_those_of_the_errors():
    cells = cells_of(presses(linear), "fit")
    for along, slope, sign in (("depth", -0.05, -1), ("stretch", 0.01, 1), ("size", 0.02, 1)):
        found = trend(cells, along)
        assert found.rank.value == pytest.approx(sign)
        assert found.slope.value == pytest.approx(slope, rel=1e-6)
        assert found.slope.sd == pytest.approx(0.0, abs=1e-9)
        assert found.groups == {"depth": 9, "stretch": 12, "size": 12}[along]


def test_noise_has_no_trend_within_its_standard_error():
    far = []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        found = trend(cells_of(presses(lambda *_, rng=rng: abs(rng.normal(0, 1e-3))), "fit"), "depth")
        far.append(found.rank.value / found.rank.sd)
    assert 0.7 < np.sqrt(np.mean(np.square(far))) < 1.4


def test_a_refusal_counts_as_the_largest_error_of_its_group():
    cells = cells_of(presses(lambda *_: 1e-4, refused=lambda _s, _x, depth: depth < 0.004), "fit")
    found = trend(cells, "depth")
    assert found.rank.value < -0.7
    assert found.slope.value == pytest.approx(0.0, abs=1e-9)


def test_equal_errors_have_the_mean_of_their_ranks():
    cells = cells_of(presses(lambda _s, _x, depth: max(depth, 6e-3)), "fit")
    assert trend(cells, "depth").rank.value == pytest.approx(np.corrcoef([1, 2, 3, 4], [1.5, 1.5, 3, 4])[0, 1])


def test_the_share_below_a_millimetre_counts_refusals_as_outside():
    cells = cells_of(presses(lambda _s, x, _d: 0.5e-3 if x < 0.05 else 2e-3, refused=lambda s, *_: s > 0.025), "fit")
    assert len(cells) == 36
    share = fine_share(cells)
    assert share.value == pytest.approx(2 / 3 * 2 / 3)
    assert 0.05 < share.sd < 0.1
    assert fine_share(cells_of(presses(lambda *_: 0.0), "fit")).sd > 0


def test_trials_are_averaged_and_one_refused_spoils_a_place():
    grid = presses(linear, trials=3)
    cells = cells_of(grid, "fit")
    assert len(cells) == 36
    assert {(c.presses, c.refused) for c in cells} == {(3, 0)}
    spoilt = [
        p
        if p.trial > 1
        else Sensed(p.geometry, p.size, p.stretch, p.depth, 1, tuple(Found(m, refused="no") for m in METHODS), 0)
        for p in grid
    ]
    cells = cells_of(spoilt, "fit")
    assert {(c.presses, c.refused) for c in cells} == {(3, 1)}
    assert all(c.absolute is not None for c in cells)
    assert fine_share(cells).value == 0.0


def test_the_mean_error_is_of_deep_presses_or_of_the_deepest():
    grid = presses(lambda _s, _x, depth: 1e-3 if depth > 4e-3 else 5e-3)
    assert mean_error(grid, "fit", 5e-3).value == pytest.approx(1e-3)
    assert mean_error(grid, "fit").value == pytest.approx(2e-3)
    shallow = [p for p in grid if p.depth < 3e-3]
    assert mean_error(shallow, "fit", 5e-3).value == pytest.approx(5e-3)
    assert mean_error(grid, "fit").sd == pytest.approx(np.std([1, 1, 1, 5] * 9, ddof=1) * 1e-3 / 6)


def test_what_says_nothing_is_refused():
    with pytest.raises(IllConditioned, match="'paper_width' measured none of 36 presses"):
        mean_error(presses(linear), "paper_width")
    with pytest.raises(IllConditioned, match="measured none of 0"):
        mean_error([], "fit")
    with pytest.raises(IllConditioned, match="without presses"):
        fine_share([])
    one = [p for p in presses(linear) if p.size == 0.02]
    with pytest.raises(IllConditioned, match="differ in size alone"):
        trend(cells_of(one, "fit"), "size")
    with pytest.raises(IllConditioned, match="differ in depth alone"):
        trend(cells_of(presses(linear), "paper_fit"), "depth")
