"""The protocols that are compared, and how much each averages."""

from __future__ import annotations

from pathlib import Path

__all__ = ["AVERAGING", "BALLOONS", "LEVELS", "OWN", "PROTOCOLS"]

BALLOONS = ("air", "water", "pudding", "seeds")
PROTOCOLS = {
    "shipped": "palpate_stiffness",
    "active": "palpate_active",
    "from zero": str(Path(__file__).parent / "palpate_from_zero.yaml"),
}
#: the force model that is the twin's own, by fidelity
OWN = {"sheet": "membrane", "hertz": "paper"}
AVERAGING = ("least", "less", "as shipped", "most")
#: the params of each protocol, by AVERAGING
LEVELS = {
    "shipped": [
        {"touch_frames": 4, "sensing_frames": 8, "frames": 4, "min_hold": 0.2, "settle": 0.0},
        {"touch_frames": 16, "sensing_frames": 16, "frames": 8, "min_hold": 1.5, "settle": 0.5},
        {"touch_frames": 24, "sensing_frames": 24, "frames": 16, "min_hold": 4.5, "settle": 8.0},
        {"touch_frames": 64, "sensing_frames": 64, "frames": 16, "min_hold": 6.0, "settle": 10.0},
    ],
    "active": [
        {"touch_frames": 4, "sensing_frames": 8, "wanted_error": 0.12, "min_hold": 0.2, "settle": 0.0},
        {"touch_frames": 16, "sensing_frames": 16, "wanted_error": 0.08, "min_hold": 1.5, "settle": 0.5},
        {"touch_frames": 24, "sensing_frames": 24, "wanted_error": 0.05, "min_hold": 3.5, "settle": 0.5},
        {"touch_frames": 64, "sensing_frames": 64, "wanted_error": 0.04, "min_hold": 6.0, "settle": 1.0},
    ],
    "from zero": [
        {"touch_frames": 4, "sensing_frames": 8, "frames": 2, "min_hold": 0.2, "settle": 0.0},
        {"touch_frames": 8, "sensing_frames": 16, "frames": 4, "min_hold": 1.5, "settle": 0.5},
        {"touch_frames": 8, "sensing_frames": 24, "frames": 12, "min_hold": 4.5, "settle": 1.5},
        {"touch_frames": 8, "sensing_frames": 64, "frames": 32, "min_hold": 6.0, "settle": 2.0},
    ],
}
