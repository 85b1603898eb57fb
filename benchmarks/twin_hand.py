"""The effective modulus of the twin's default hand by the paper's protocol; the hand's shear modulus and mount were fitted to it.

    python -m benchmarks.twin_hand

A rigid 20 mm hemisphere, depths of 1 to 15 mm in steps of 1 mm, E* the least-squares fit through 0 of the force to the formula of
Hertz. The paper (arXiv 2105.08154) gives about 4 kPa at stretch 0 and 9 kPa at 60 mm.
"""

from __future__ import annotations

import numpy as np

from stretch_bt.frames import Pose
from stretch_bt.model.calibration.calibrate_hertz import effective_modulus
from stretch_bt.simulation.scene import load_scene
from stretch_bt.simulation.world import World

DEPTHS = np.arange(1, 16) * 1e-3


def main() -> None:
    """Print E* by stretch, without any effect and with the effects that the advisor switches on."""
    print("stretch, mm   E*, kPa: no effect   as the advisor has it")
    scene = load_scene("calibration_sphere")
    worlds = World(scene.with_(effects="none")), World(scene)
    for stretch in np.arange(0, 61, 10) * 1e-3:
        found = [modulus(world, float(stretch)) / 1e3 for world in worlds]
        print(f"{stretch * 1e3:8.0f}  {found[0]:18.2f}  {found[1]:18.2f}", flush=True)


def modulus(world: World, stretch: float) -> float:
    """Return the effective modulus, Pa, at a stretch, m; depths count from the flat membrane."""
    top = world.scene.object.top
    forces = [world.contact(Pose((0.0, 0.0, top - float(d))), stretch).force[2] for d in DEPTHS]
    return effective_modulus(DEPTHS, forces, 0.010).value


if __name__ == "__main__":
    main()
