"""Hands that no force model knows: their forces without noise, as the protocol presses them, kept in a folder.

    python -m benchmarks.force_hands FOLDER [--hands 12] [--first 0]

It takes some two minutes of one core a hand. `python -m benchmarks.force_model FOLDER` prints the errors of force models on them.
"""

from __future__ import annotations

import argparse
from dataclasses import asdict
from pathlib import Path

import numpy as np

from stretch_bt.accuracy.force.hands import TrueHand, true_forces


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
            np.savez(path, force=true_forces(seed), **asdict(TrueHand.drawn(seed)))
            print(f"{path}: {TrueHand.drawn(seed)}", flush=True)


if __name__ == "__main__":
    main()
