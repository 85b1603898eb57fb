import numpy as np
import pytest

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation import press
from stretch_bt.simulation.membrane.picture import draw_press, save_press


def test_the_contact_shows_and_files_are_written(tmp_path):
    import cv2

    pressed = press("sphere:20mm", 0.03, 0.01).detail
    image = draw_press(pressed).astype(int)
    assert image.shape == (900, 1200, 3)
    red = (image[..., 2] > 150) & (image[..., 0] < 90)
    blue = (image[..., 0] > image[..., 2] + 15) & (image[..., 0] > 100)
    assert 200 < red.sum() < 0.1 * blue.sum()
    save_press(pressed, tmp_path / "press.png")
    assert np.array_equal(cv2.imread(str(tmp_path / "press.png")), image)
    for bad in ("press", "press.doc", "no/such/folder.png"):
        with pytest.raises(InvalidInput):
            save_press(pressed, tmp_path / bad)
