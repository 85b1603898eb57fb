"""Which frames are taken for a membrane: rooms and people must be refused, presses answered as they were.

    python -m benchmarks.no_membrane [FOLDER]

FOLDER has depth images of a room (PNG, 0.125 mm, 640 x 480, as from an SR305); each is cut in four ways, with its plane said to be at 0.2
to 1 m. Beside them stand synthetic rooms and solved presses. Prints, by scene, how many frames were answered with a height, and by reason
how many were refused.
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from stretch_bt.accuracy.perception.noise import CLEAN, CORRELATED, WHITE_10, observe
from stretch_bt.accuracy.perception.view import BodyPress, seen
from stretch_bt.errors import NoAnswer
from stretch_bt.frames import DepthFrame, Intrinsics
from stretch_bt.perception import find_contact, load_depth_png, mask_membrane, track_height
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.membrane.indenters.sphere import Sphere

LENS = Intrinsics(476.007, 476.007, 313.683, 242.755, 640, 480)
UNIT = 0.125e-3
Depth = npt.NDArray[np.float64]


def rooms() -> dict[str, Depth]:
    """Return depths (480, 640), m, of scenes without a membrane."""
    v, u = np.mgrid[:480, :640]
    x, y = (u - LENS.cx) / LENS.fx, (v - LENS.cy) / LENS.fy
    wall = np.full(x.shape, 0.9)
    ball = 0.45 - np.sqrt(np.maximum(0.1**2 - (0.45 * x) ** 2 - (0.45 * y) ** 2, 0.0))
    on_table = 0.28 / (1.0 + x * x + y * y)  # of the middle of a ball of 40 mm that lies on a table at 0.3 m
    on_ball = on_table**2 * (1.0 + x * x + y * y) - 0.28**2 + 0.02**2
    head = 0.09 * np.sqrt(np.maximum(1.0 - (0.5 * x / 0.075) ** 2 - (0.5 * y / 0.11) ** 2, 0.0))
    fingers = (np.abs(np.mod(0.4 * x, 0.022) - 0.011) < 0.007) & (np.abs(0.4 * x) < 0.044) & (0.4 * y < 0.05)
    return {
        "wall": wall,
        "tilted floor": 0.5 / (1.0 + 0.8 * y),
        "corner": 0.6 - 0.5 * np.abs(x),
        "steps": 0.3 + 0.03 * np.floor(12 * (y + 0.6)),
        "hand before a wall": np.where(fingers | (np.hypot(0.4 * x, 0.4 * y - 0.05) < 0.045), 0.4, 0.7),
        "hand before nothing": np.where(fingers | (np.hypot(0.4 * x, 0.4 * y - 0.05) < 0.045), 0.4, 0.0),
        "ball before a wall": np.where(np.hypot(x, y) < 0.1 / 0.45, ball, 0.8),
        "ball on a table": np.where(
            on_ball > 0.0, on_table - np.sqrt(np.maximum(on_ball, 0.0) / (1.0 + x * x + y * y)), 0.3
        ),
        "block on a table": 0.3 - 0.03 * ((np.abs(0.27 * x) < 0.02) & (np.abs(0.27 * y) < 0.02)),
        "cone on a table": 0.3 - 0.1 * np.maximum(1.0 - np.hypot(0.25 * x, 0.25 * y) / 0.05, 0.0),
        "head before a wall": np.where(head > 0.0, 0.5 - head, 0.8),
        "ball before nothing": np.where(np.hypot(x, y) < 0.1 / 0.45, ball, 0.0),
    }


def frame_of(depth: Depth, seed: int = 0) -> DepthFrame:
    """Return a frame of a depth image, m, with 0.3 mm of noise."""
    noise = np.random.default_rng(seed).normal(scale=0.3e-3, size=depth.shape)
    return DepthFrame(np.where(depth > 0, np.rint((depth + noise) / UNIT), 0).astype(np.uint16), UNIT, LENS, 0.0, 0)


def placements(frame: DepthFrame, distances: npt.NDArray[np.float64]) -> Iterator[DepthFrame]:
    """Yield a frame with its plane at distances, m: whole, cut to membranes of 0.1 and 0.3 m, and as one at 0.2 m would be cut."""
    near = mask_membrane(replace(frame, plane_distance=0.2), gauge=0.1, width=0.09, stretch=0.02)
    for distance in distances.tolist():
        placed = replace(frame, plane_distance=distance)
        small, large = (mask_membrane(placed, gauge=s, width=0.9 * s, stretch=0.02) for s in (0.1, 0.3))
        yield from (f for f in (placed, small, large, replace(near, plane_distance=distance)) if f.raw.any())


def outcome(frame: DepthFrame) -> str:
    """Return "answered", or the start of the reason why there is no height."""
    try:
        contact = find_contact(frame)
        track_height(contact.surface, np.isfinite(contact.surface[..., 2]), contact.labels)
    except NoAnswer as refused:
        return refused.reason.split(":")[0].split(",")[0][:60]
    return "answered"


def presses() -> Iterator[DepthFrame]:
    """Yield frames of solved presses, light to deep, on a slack to a tight sheet, whole and cut to the membrane."""
    for stretch in (0.0, 0.03, 0.06):
        for depth in (0.003, 0.015, 0.028):
            for body in (Cylinder(0.02), Sphere(0.015), Sphere(0.04)):
                view = seen(BodyPress(body, stretch=stretch, depth=depth, mesh=2e-3))
                for noise in (CLEAN, WHITE_10, CORRELATED):
                    frame = observe(view, noise, 1)
                    yield frame
                    yield mask_membrane(frame, gauge=0.1, width=0.09, stretch=stretch)


def main() -> None:
    """Print the table."""
    tell("solved presses", Counter(map(outcome, presses())))
    for name, depth in rooms().items():
        tell(name, Counter(map(outcome, placements(frame_of(depth), np.arange(0.2, 1.01, 0.1)))))
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else None
    for path in sorted(folder.glob("*.png")) if folder else ():
        frame = load_depth_png(path, unit=UNIT, intrinsics=LENS)
        tell(path.stem, Counter(map(outcome, placements(frame, np.arange(0.2, 1.01, 0.05)))))


def tell(name: str, outcomes: Counter[str]) -> None:
    """Print how many frames of a scene were answered, and why others were not."""
    total = outcomes.total()
    others = "; ".join(f"{n} {why}" for why, n in outcomes.most_common() if why != "answered")
    print(f"{name:20} {outcomes['answered']:4} of {total:4}  {others}", flush=True)


if __name__ == "__main__":
    main()
