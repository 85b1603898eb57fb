"""Protocols of palpation against each other: error, stated error, presses and robot seconds, at several amounts of averaging.

    python -m benchmarks.palpation_protocols [--seeds 10] [--fidelity hertz] [--levels 0 1 2 3] [--set NAME=VALUE ...]

`shipped` is the tree palpate_stiffness, `active` palpate_active; `from zero` presses at every stretch from zero depth in 1 mm
steps (benchmarks/trees).
Errors are of the stiffness at the last press against the scene's truth at the same instant; those `at drop` of that at 1.5 mm
against the object's own. `err/sd` is the rms of error over stated sd. `height` is by how much looks at a pressed membrane
scatter about the run's mean error. `s` are robot seconds, `past` those of them since the hand stood at the object's top.
`falls` counts presses at whose end the scene's own force was lower than at the last by over 2 % and 10 mN.

The force model is the twin's own: the paper's law at hertz fidelity, the shipped membrane model, which has weight and bending, at
sheet fidelity; --set model=FILE takes another. Scenes are the shipped balloons, with all noise of the `bench` camera; all balloons
of a seed see the same noise.
"""

from __future__ import annotations

import argparse
import tempfile
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt import run
from stretch_bt.run.onlooker import Onlooker
from stretch_bt.run.runner import Runner
from stretch_bt.simulation.objects.balloon import BalloonObject
from stretch_bt.simulation.scene import load_scene

Array = npt.NDArray[np.float64]

BALLOONS = ("air", "water", "pudding", "seeds")
SUMMED = ("water", "pudding", "seeds")
PROTOCOLS = {
    "shipped": "palpate_stiffness",
    "active": "palpate_active",
    "from zero": str(Path(__file__).parent / "trees" / "palpate_from_zero.yaml"),
}
DROP = 1.5e-3
OWN = {"sheet": "membrane", "hertz": "paper"}
#: averaging: the params of each protocol, the third those that the trees ship with
LEVELS = {
    "shipped": [
        {"touch_frames": 4, "sensing_frames": 8, "frames": 4, "hold": 0.2, "settle": 0.0},
        {"touch_frames": 16, "sensing_frames": 16, "frames": 8, "hold": 1.5, "settle": 0.5},
        {"touch_frames": 32, "sensing_frames": 24, "frames": 16, "hold": 3.5, "settle": 1.5},
        {"touch_frames": 64, "sensing_frames": 64, "frames": 16, "hold": 6.0, "settle": 2.0},
    ],
    "active": [
        {"touch_frames": 4, "sensing_frames": 8, "wanted": 0.12, "hold": 0.2, "settle": 0.0},
        {"touch_frames": 16, "sensing_frames": 16, "wanted": 0.08, "hold": 1.5, "settle": 0.5},
        {"touch_frames": 32, "sensing_frames": 24, "wanted": 0.05, "hold": 3.5, "settle": 0.5},
        {"touch_frames": 64, "sensing_frames": 64, "wanted": 0.04, "hold": 6.0, "settle": 1.0},
    ],
    "from zero": [
        {"touch_frames": 4, "sensing_frames": 8, "frames": 2, "hold": 0.2, "settle": 0.0},
        {"touch_frames": 8, "sensing_frames": 16, "frames": 4, "hold": 1.5, "settle": 0.5},
        {"touch_frames": 8, "sensing_frames": 24, "frames": 12, "hold": 3.5, "settle": 1.5},
        {"touch_frames": 8, "sensing_frames": 64, "frames": 32, "hold": 6.0, "settle": 2.0},
    ],
}
#: which protocols are compared, and by which columns of seconds and error
PAIRS = (("shipped", "from zero"), ("active", "shipped"), ("active", "from zero"))
COMPARED = {
    "all robot seconds": [0, 2],
    "seconds past the touch": [1, 2],
    "all robot seconds, stiffness at drop": [0, 3],
}
HEAD = (
    f"{'protocol':10s} {'level':5s} {'balloon':8s} {'ok':>6s} {'bias':>7s} {'rms':>6s} {'err/sd':>6s} {'at drop':>8s} {'err/sd':>6s} {'drop mm':>8s} "
    f"{'sd':>6s} {'height':>7s} {'presses':>7s} {'s':>6s} {'past':>6s} {'falls':>6s}"
)


@dataclass
class Seen(Onlooker):
    """Notes what the scene knows: the force at each press' end, the error of each height that was seen, when the object was met."""

    runner: Runner
    top: float
    forces: list[float] = field(default_factory=list)
    errors: list[float] = field(default_factory=list)
    touched: float | None = None

    def begin_tick(self, tick: int, time: float) -> None:
        """Note when the flat membrane first stands at the object's top."""
        if self.touched is None and self.runner.context.devices["arm"].pose(1.0).value.height <= self.top:
            self.touched = time

    def write(self, key: str, value: Any, sd: float | None, path: str) -> None:
        """Note it."""
        cell: Any = self.runner.cell
        if key.endswith("/pressed"):
            self.forces.append(cell.truth()["force"])
        elif "track_height" in path:
            self.errors.append(value - cell.truth()["height"])

    def falls(self) -> int:
        """Return at how many presses the force fell."""
        pairs = zip(self.forces, self.forces[1:], strict=False)
        return sum(after < before - max(0.02 * before, 0.01) for before, after in pairs)


def palpated(
    protocol: str, level: int, balloon: str, fidelity: str, seed: int, extra: dict[str, str]
) -> tuple[Any, Seen]:
    """Return the result of a run, and what the scene knew on its way."""
    notes: list[Seen] = []

    def watch(runner: Runner) -> None:
        notes.append(Seen(runner, load_scene(f"{balloon}_balloon").object.top))
        runner.watchers.append(notes[0])

    shipped = files("stretch_bt") / "trees" / "scenes" / f"{balloon}_balloon.yaml"
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder) / "scene.yaml"
        scene.write_text(shipped.read_text("utf-8") + f"fidelity: {fidelity}\n", encoding="utf-8")
        params = {**LEVELS[protocol][level], "model": OWN[fidelity], **extra}
        result = run(
            PROTOCOLS[protocol], scene=scene, seed=seed, params=params, out=Path(folder) / "record", watch=watch
        )
    return result, notes[0]


def figures(result: Any, seen: Seen, balloon: str) -> list[float]:
    """Return the numbers of one run."""
    out, true = result.outputs, result.truth
    spec = load_scene(f"{balloon}_balloon").object
    assert isinstance(spec, BalloonObject)
    at = spec.secant(DROP) / 1e3
    found, dropped = out["stiffness"], out["stiffness_at_drop"]
    error, off = found["value"] / true["stiffness"]["value"] - 1, dropped["value"] / at - 1
    return [
        error,
        error / (found["sd"] / found["value"]),
        off,
        off / (dropped["sd"] / dropped["value"]),
        out["deflection"]["value"] - true["deflection"]["value"],
        out["deflection"]["sd"],
        float(np.std(seen.errors)) * 1e3 if len(seen.errors) > 1 else np.nan,
        out["presses"]["value"],
        out["robot_time"]["value"],
        out["robot_time"]["value"] - (seen.touched or 0.0),
        seen.falls(),
    ]


def rms(values: Array) -> float:
    """Return the root of the mean square of those that are there."""
    return float(np.sqrt(np.nanmean(values**2)))


def row(protocol: str, level: int, balloon: str, runs: int, found: Array) -> str:
    """Return a line of the table."""
    head = f"{protocol:10s} {level:<5d} {balloon:8s} {len(found):3d}/{runs:<2d}"
    if not len(found):
        return head
    e = found.T
    return (
        f"{head} {e[0].mean():7.1%} {rms(e[0]):6.1%} {rms(e[1]):6.2f} {rms(e[2]):8.1%} {rms(e[3]):6.2f} {rms(e[4]):8.3f} {rms(e[5]):6.3f} "
        f"{rms(e[6]):7.3f} {e[7].mean():7.1f} {e[8].mean():6.1f} {e[9].mean():6.1f} {e[10].sum():6.0f}"
    )


def seconds_at(error: float, curve: Array) -> float:
    """Return the seconds at which a curve of (seconds, error) comes to an error, between its points by logarithms; nan outside it."""
    seconds, errors = np.log(curve[np.argsort(curve[:, 1])]).T
    return float(np.exp(np.interp(np.log(error), errors, seconds, left=np.nan, right=np.nan)))


def best(curve: Array) -> Array:
    """Return the points of a curve of (seconds, error) than which no other has both less time and less error."""
    return np.array([p for p in curve if not any(o[0] < p[0] and o[1] < p[1] for o in curve)])


def compare(curves: dict[str, Array], first: str, second: str) -> None:
    """Print the seconds of both at equal error, where their curves have it."""
    ours, theirs = best(curves[first]), best(curves[second])
    low = max(ours[:, 1].min(), theirs[:, 1].min())
    high = min(ours[:, 1].max(), theirs[:, 1].max())
    for error in np.geomspace(low, high, 4) if low < high else []:
        a, b = seconds_at(error, ours), seconds_at(error, theirs)
        print(f"  rms {error:.1%}: {first} {a:.1f} s, {second} {b:.1f} s, {a / b:.2f}")


def main() -> None:
    """Print the table and, over water, pudding and seeds together, presses and the seconds at equal error."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    parser.add_argument("--fidelity", default="hertz")
    parser.add_argument("--levels", type=int, nargs="+", default=[0, 1, 2, 3])
    parser.add_argument("--balloons", nargs="+", default=list(BALLOONS))
    parser.add_argument("--protocols", nargs="+", default=list(PROTOCOLS))
    parser.add_argument("--set", nargs="*", default=[], help="params of both trees, NAME=VALUE")
    given = parser.parse_args()
    extra = dict(pair.split("=", 1) for pair in given.set)
    print(HEAD)
    totals: dict[tuple[str, int], list[Array]] = {}
    for protocol in given.protocols:
        for level in given.levels:
            for balloon in given.balloons:
                found = []
                for seed in range(given.first, given.first + given.seeds):
                    result, seen = palpated(protocol, level, balloon, given.fidelity, seed, extra)
                    if result.status == "SUCCESS":
                        found.append(figures(result, seen, balloon))
                    else:
                        print(f"    {balloon}, seed {seed}: {result.status}: {result.reason}", flush=True)
                numbers = np.array(found, dtype=float)
                print(row(protocol, level, balloon, given.seeds, numbers), flush=True)
                if balloon in SUMMED and found:
                    totals.setdefault((protocol, level), []).append(numbers)
    summary(totals, given.protocols)


def summary(totals: dict[tuple[str, int], list[Array]], protocols: list[str]) -> None:
    """Print sums over the balloons, and the comparison at equal error."""
    print("\nover water, pudding and seeds: presses, robot seconds, of them past the touch, rms error, that at drop")
    curves: dict[str, list[tuple[float, ...]]] = {}
    for (protocol, level), parts in totals.items():
        sums = [float(sum(part[:, i].mean() for part in parts)) for i in (7, 8, 9)]
        errors = [rms(np.concatenate([part[:, i] for part in parts])) for i in (0, 2)]
        print(
            f"{protocol:10s} level {level}: {sums[0]:5.1f} {sums[1]:6.1f} {sums[2]:6.1f} {errors[0]:6.1%} {errors[1]:6.1%}"
        )
        curves.setdefault(protocol, []).append((sums[1], sums[2], *errors))
    long = [p for p in protocols if len(curves.get(p, ())) > 1]
    for first, second in (pair for pair in PAIRS if set(pair) <= set(long)):
        for name, columns in COMPARED.items():
            print(f"{name} at equal error")
            compare({p: np.array(curves[p])[:, columns] for p in (first, second)}, first, second)


if __name__ == "__main__":
    main()
