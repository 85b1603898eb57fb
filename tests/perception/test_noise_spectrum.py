"""How noise that pixels share adds up over a contact."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from stretch_bt.perception.noise_spectrum import NoiseSpectrum


def weights(rows, columns):
    """Design (6, n) of a quadratic over pixels."""
    x, y = (w - w.mean() for w in (columns, rows))
    x, y = x / x.std(), y / y.std()
    return np.stack([np.ones_like(x), x, y, -0.5 * x * x, -x * y, -0.5 * y * y])


@pytest.mark.parametrize("radius", [40, 90, 160])
@pytest.mark.parametrize("length", [1.0, 2.0, 3.0, 6.5])
def test_the_error_of_a_quadratic_over_a_contact_is_that_of_pairs_of_its_pixels(radius, length):
    v, u = np.indices((2 * radius + 1, 2 * radius + 1)) - radius
    rows, columns = np.nonzero(v * v + u * u <= radius * radius)
    design = weights(rows.astype(float), columns.astype(float))
    # White noise of variance 1 after a Gaussian, as wide as makes its correlation exp(-d^2 / 4 length^2).
    maps = np.zeros((len(design), *(2 * radius + 61,) * 2))
    maps[:, rows + 30, columns + 30] = design
    spread = np.stack([gaussian_filter(m, length, truncate=4.5).ravel() for m in maps]) * 2.0 * np.sqrt(np.pi) * length
    gain = np.linalg.inv(design @ design.T)
    wanted = np.sqrt(np.diag(gain @ (spread @ spread.T) @ gain))
    noise = NoiseSpectrum(np.array([0.0, 1.0]), np.array([0.0, length]))
    found = np.sqrt(np.diag(gain @ noise.shared(design, rows, columns) @ gain))
    np.testing.assert_allclose(found, wanted, rtol=0.04)
