"""Camera presets: the parameters of the effects that a camera has; what a preset does not name, its camera does not add."""

from __future__ import annotations

from typing import Any

from stretch_bt.simulation.effects.dropout import Dropout
from stretch_bt.simulation.effects.quantisation import Quantisation
from stretch_bt.simulation.effects.white_noise import WhiteNoise

__all__ = ["PRESETS"]

#: by preset and effect
PRESETS: dict[str, dict[str, Any]] = {
    "bench": {
        "white_noise": WhiteNoise.Parameters(sd="0.05 mm"),
        "quantisation": Quantisation.Parameters(),
        "dropout": Dropout.Parameters(),
    },
}
