"""Errors and cost of the characterisation of a hand in the twin.

    python -m benchmarks.characterize [height] [force] [softening] [--seeds 4]

`height` prints the error of the height of first contact of three indenters, over seeds; `force` runs the
whole protocol `tasks` with one trial and compares each row with the scene's own force at the place where the arm takes the hand to be;
`softening` prints the force of one press before and after the membrane was stretched, with the effect `mullins`.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from stretch_bt import run
from stretch_bt.frames import Pose
from stretch_bt.hardware.simulated.operator import indenter
from stretch_bt.model.calibration.characterization import NAME, Table, read_table
from stretch_bt.simulation.scene import load_scene, parse_scene
from stretch_bt.simulation.world import World

SCENE = "calibration_sphere"
SOFT = "format: stretch-scene/1\nobject: {type: sphere, diameter: 20 mm, rigid: true, base: 40 mm}\neffects: {mullins: on}\n"
STAND = 0.040


def main() -> None:
    """Print what is asked for, all by default."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("parts", nargs="*", choices=[*PARTS, []], default=[])
    parser.add_argument("--seeds", type=int, default=4)
    given = parser.parse_args()
    for name in given.parts or PARTS:
        PARTS[name](given.seeds)


def characterized(seed: int, **params: Any) -> tuple[Table, Any]:
    """Return the table and the result of a run."""
    with tempfile.TemporaryDirectory() as folder:
        result = run(
            "characterize", scene=SCENE, seed=seed, params={"trials": 1, **params}, out=Path(folder) / "record"
        )
        if result.status != "SUCCESS":
            raise SystemExit(f"seed {seed}: {result.status}: {result.reason}")
        return read_table(Path(folder) / "record" / NAME), result


def height(seeds: int) -> None:
    """Print the error of the height of first contact by indenter, and what of it all indenters of a run share."""
    errors = []
    print("seed   error of the height of first contact of spheres of 10, 30, 60 mm, mm")
    for seed in range(seeds):
        table, _ = characterized(seed, diameters=[0.010, 0.030, 0.060], condition=False, stretches=[0.0], depths=[0.0])
        errors.append((table.contact_height - STAND - table.size) * 1e3)
        print(f"{seed:4}   {' '.join(f'{e:+.3f}' for e in errors[-1])}", flush=True)
    found = np.array(errors)
    apart = found - found.mean(axis=1, keepdims=True)
    print(f"rms {np.sqrt(np.mean(found**2)):.3f} mm, apart from the mean of a run {np.sqrt(np.mean(apart**2)):.3f} mm")


def force(seeds: int) -> None:
    """Print the errors of the forces of a whole protocol, and its cost."""
    table, result = characterized(0)
    world = World(load_scene(SCENE))
    known = []
    for press in table.presses():
        world.exchange(indenter(press.geometry, press.size, world.scene.object.position))
        # the rows count from the contact that was found, the scene knows where it is
        known.append(world.truth(Pose((0.0, 0.0, press.contact_height - press.depth)), press.stretch)["force"])
    off = table.force - np.array(known)
    print(
        f"{len(table)} presses, {result.outputs['robot_time']['value']:.0f} s of the robot, {result.cpu_seconds:.1f} s of CPU"
    )
    print(
        f"force {table.force.min():.3f} to {table.force.max():.2f} N, rms error {np.sqrt(np.mean(off**2)) * 1e3:.1f} mN,",
        end=" ",
    )
    print(f"over the stated sd {np.sqrt(np.mean((off / table.force_sd) ** 2)):.2f}")


def softening(seeds: int) -> None:
    """Print what a membrane that was stretched presses with."""
    print("before                     force at stretch 0 and 2, 5, 10 mm depth, N")
    for name, before in (
        ("nothing", None),
        ("5 mm at stretch 0", (0.005, 0.0)),
        ("5 mm at 30 mm", (0.005, 0.030)),
        ("15 mm at 80 mm", (0.015, 0.080)),
    ):
        world = World(parse_scene(SOFT))
        if before is not None:
            world.advance(_at(before[0]), before[1], 1.0)
            world.advance(_at(-0.02), 0.0, 2.0)
        forces = []
        for number, depth in enumerate((0.002, 0.005, 0.010), 3):
            world.advance(_at(depth), 0.0, float(number))
            forces.append(world.truth(_at(depth), 0.0, float(number))["force"])
        print(f"{name:26} {' '.join(f'{f:.3f}' for f in forces)}", flush=True)


def _at(depth: float) -> Pose:
    return Pose((0.0, 0.0, STAND + 0.020 - depth))


PARTS: dict[str, Callable[[int], None]] = {"height": height, "force": force, "softening": softening}


if __name__ == "__main__":
    main()
