"""Hands that no force model knows: their forces without noise, as the protocol presses them, kept in a folder.

    python -m benchmarks.force_hands FOLDER [--hands 12] [--first 0]

It takes some two minutes of one core a hand. `python -m benchmarks.force_model FOLDER` prints the errors of force models on them.
"""

from __future__ import annotations

import argparse
from dataclasses import asdict
from pathlib import Path

import numpy as np

from stretch_bt.accuracy.force.hands import DEPTHS, DIAMETERS, FINER, STRETCHES, TrueHand, forces_of


def main() -> None:
    """Press hands that are not in the folder yet."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--hands", type=int, default=12)
    parser.add_argument("--first", type=int, default=0)
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    for seed in range(given.first, given.first + given.hands):
        path = given.folder / f"hand_{seed:03d}.npz"
        if not path.exists():
            hand = TrueHand.drawn(seed)
            force = forces_of(hand.sheet(), DIAMETERS, STRETCHES, DEPTHS, FINER)
            np.savez(path, force=force, **asdict(hand))
            print(f"{path}: {hand}", flush=True)


if __name__ == "__main__":
    main()
