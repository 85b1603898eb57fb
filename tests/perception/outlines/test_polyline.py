"""The local fits of a closed curve."""

import numpy as np
import pytest

from stretch_bt.perception.outlines.polyline import _fits, _half_widths


@pytest.mark.parametrize("count", [16, 17, 48, 97, 211, 400])
def test_fits_are_those_of_savitzky_and_golay_around_the_curve(count):
    from scipy.signal import savgol_filter  # which every process would load for this test alone

    rng = np.random.default_rng(count)
    curve = np.exp(2j * np.pi * np.arange(count) / count) + 0.1 * (rng.normal(size=count) + 1j * rng.normal(size=count))
    narrowest, *others = zip(_half_widths(count), _fits(curve), strict=True)
    assert narrowest[1] == pytest.approx(curve)
    for half, fit in others:
        parts = (savgol_filter(part, 2 * half + 1, 2, mode="wrap") for part in (curve.real, curve.imag))
        assert fit == pytest.approx(next(parts) + 1j * next(parts))
