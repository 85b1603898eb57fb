import zlib
from pathlib import Path

import numpy as np
import pytest

from stretch_bt.simulation.camera.view import SR305
from stretch_bt.simulation.effects.base import Exposure

CROP = SR305.cropped(74, 407, 214, 427)  # what of the sensor the membrane fills


@pytest.fixture
def expose():
    """Send depth through effects, as the frame of this number of a run."""

    def exposed(depth, effects, *, number=0, seed=0, lens=CROP, rate=30.0):
        def random(name, k):
            return np.random.default_rng((seed, zlib.crc32(name.encode()), k + (1 << 20)))

        exposure = Exposure(np.array(depth, np.float32, order="C"), lens, number / rate, number, rate, random, 1e-5)
        for effect in effects:
            effect.expose(exposure)
        return exposure

    return exposed


@pytest.fixture
def data():
    folder = Path(__file__).parents[4] / "shared" / "data"
    if not folder.is_dir():
        pytest.skip("the real recordings are not on this machine")
    return folder
