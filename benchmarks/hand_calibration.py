"""How well `calibrate-hand` finds a camera that stands and looks a little wrong, over seeds, beside the standard deviation that it states.

Run with `python benchmarks/hand_calibration.py [seeds] [camera preset]`. Each seed draws offsets of up to 2 mm and tilts of up to a degree.
"""

from __future__ import annotations

import math
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from stretch_bt.clock import VirtualClock
from stretch_bt.hardware.cell import open_cell
from stretch_bt.hardware.cell_file import load_cell
from stretch_bt.runtime.hand_calibration import calibrate_hand
from stretch_bt.simulation.scene import load_scene

SCENE = """\
format: stretch-scene/1
object: {{type: sphere, diameter: 20 mm, rigid: true, base: 40 mm}}
camera: {preset}
hand: {{camera: {{x: {x} mm, y: {y} mm, z: {z} mm, tilt_x: {a} deg, tilt_y: {b} deg}}}}
"""
ANGLES = ("tilt_x", "tilt_y", "yaw")


def one(seed: int, preset: str, folder: Path) -> dict[str, tuple[float, float]]:
    """Return error and standard deviation of each result, SI."""
    random = np.random.default_rng(seed)
    (x, y, z), (a, b) = random.uniform(-2, 2, 3), random.uniform(-1, 1, 2)
    path = folder / f"{seed}.yaml"
    path.write_text(SCENE.format(preset=preset, x=x, y=y, z=z, a=a, b=b))
    clock = VirtualClock()
    cell = open_cell(load_cell("simulated"), now=clock.now, seed=seed, scene=load_scene(path))
    found = calibrate_hand(cell, clock)
    cell.close()
    tilt_x, tilt_y, distance = math.radians(a), math.radians(b), 0.2 + 1e-3 * z
    truth = {"x": 1e-3 * x, "y": 1e-3 * y, "distance": distance, "tilt_x": tilt_x, "tilt_y": tilt_y, "yaw": 0.0}
    truth["aim_x"] = truth["x"] - distance * math.tan(tilt_y) / math.cos(tilt_x)
    truth["aim_y"] = truth["y"] + distance * math.tan(tilt_x)
    rows = {name: (float(found.camera[name]) - value, found.camera[name].sd) for name, value in truth.items()}
    return {**rows, "ratio": (float(found.ratio) - 1.0, found.ratio.sd)}


def main(seeds: int, preset: str) -> None:
    """Print the table."""
    begun = time.process_time()
    with tempfile.TemporaryDirectory() as folder:
        rows = [one(seed, preset, Path(folder)) for seed in range(seeds)]
    print(f"{'':10s}{'rms error':>11s}{'stated sd':>11s}{'rms error/sd':>14s}{'worst':>7s}")
    for name in rows[0]:
        error, sd = np.array([row[name] for row in rows]).T
        scale, unit = (math.degrees(1), "deg") if name in ANGLES else (1.0, "") if name == "ratio" else (1e3, "mm")
        off = error / sd
        print(f"{name:10s}{scale * np.sqrt(np.mean(error**2)):11.4f}{scale * sd.mean():11.4f}{np.sqrt(np.mean(off**2)):14.2f}"
              f"{np.abs(off).max():7.2f} {unit}")  # fmt: skip
    print(f"{seeds} seeds, camera {preset}; CPU {(time.process_time() - begun) / seeds:.1f} s each")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 20, sys.argv[2] if len(sys.argv) > 2 else "bench")
