"""Camera presets: the parameters of the effects that a camera has; a camera adds no effect that its preset does not name."""

from __future__ import annotations

from typing import Any

from stretch_bt.simulation.effects.correlated_noise import CorrelatedNoise
from stretch_bt.simulation.effects.drift import Drift
from stretch_bt.simulation.effects.dropout import Dropout
from stretch_bt.simulation.effects.fixed_pattern import FixedPattern
from stretch_bt.simulation.effects.flying_pixels import FlyingPixels
from stretch_bt.simulation.effects.quantisation import Quantisation
from stretch_bt.simulation.effects.white_noise import WhiteNoise

__all__ = ["PRESETS"]

#: a structured-light camera 200 mm over the membrane: known properties of its parts, put together by judgement
_BENCH: dict[str, Any] = {
    "white_noise": WhiteNoise.Parameters(),
    "correlated_noise": CorrelatedNoise.Parameters(),
    "fixed_pattern": FixedPattern.Parameters(),
    "drift": Drift.Parameters(),
    "quantisation": Quantisation.Parameters(),
    "dropout": Dropout.Parameters(),
    "flying_pixels": FlyingPixels.Parameters(),
}

#: by preset and effect
PRESETS: dict[str, dict[str, Any]] = {
    "bench": _BENCH,
    # the noise of height that the paper (arXiv 2105.08154) states, as if all of it were correlated
    "hard": {**_BENCH, "correlated_noise": CorrelatedNoise.Parameters.model_validate({"sd": "1 mm"})},
    # its noise in frames of a real SR305 at 0.45 to 1 m on smooth surfaces, scaled to 200 mm by the square of depth
    "sr305_texture": {
        "white_noise": WhiteNoise.Parameters.model_validate({"sd": "0.002 mm", "reference_depth": "200 mm"}),
        "correlated_noise": CorrelatedNoise.Parameters.model_validate(
            {"sd": "0.025 mm", "kernel": 2.4, "memory": 0.0, "reference_depth": "200 mm"}
        ),
        "quantisation": Quantisation.Parameters(),
    },
}
