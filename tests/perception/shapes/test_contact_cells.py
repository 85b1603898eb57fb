"""A contact that cannot be taken: told by its true cause, too few pixels or too few of them seen."""

from types import SimpleNamespace

import numpy as np
import pytest

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.shapes.contact_cells import cells_of, window_of

PITCH = 0.2e-3


def bump(side: int, width: float, seen: float) -> SimpleNamespace:
    """Return a contact of `side` pixels a side, all in a bump of some `width` pixels, of which a share is seen."""
    at = (np.arange(side) - side / 2) * PITCH
    x, y = np.meshgrid(at, at)
    surface = np.stack([x, y, 2e-3 * np.exp(-(x**2 + y**2) / (width * PITCH) ** 2)], axis=-1)
    surface[np.random.default_rng(0).random((side, side)) >= seen] = np.nan
    points = surface[np.isfinite(surface[..., 2])]
    return SimpleNamespace(surface=surface, points=points, rays=np.tile([0.0, 0.0, -1.0], (len(points), 1)))


@pytest.mark.parametrize(
    ("side", "width", "seen", "why"),
    [
        (34, 20.0, 1.0, r"1156 pixels, .* at least 1470; press deeper, or bring the camera nearer"),
        (98, 0.6, 1.0, r"covers 51 pixels, .* at least 80; press deeper, or bring the camera nearer"),
        (98, 0.6, 0.3, "hardly any pixel"),
        (98, 30.0, 0.1, "hardly any pixel has depth"),
        (34, 20.0, 0.1, "hardly any pixel has depth"),
    ],
)
def test_what_a_contact_lacks_is_told(side: int, width: float, seen: float, why: str) -> None:
    contact = bump(side, width, seen)
    with pytest.raises(IllConditioned, match=why):
        cells_of(contact, window_of(contact.surface))


def test_a_contact_of_enough_pixels_is_taken() -> None:
    contact = bump(98, 8.0, 1.0)
    assert cells_of(contact, window_of(contact.surface)).x.size >= 60
