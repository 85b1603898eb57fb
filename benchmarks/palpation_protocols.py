"""Protocols of palpation against each other: error, stated error, presses and robot seconds, at several amounts of averaging.

    python -m benchmarks.palpation_protocols [--seeds 10] [--fidelity hertz] [--levels 0 1 2 3] [--set NAME=VALUE ...]

`shipped` is the tree palpate_stiffness, `active` palpate_active; `from zero` presses at every stretch from zero depth in 1 mm
steps (stretch_bt/accuracy/palpation, where the protocols and levels are).
Errors are of the stiffness at the last press against the scene's truth at the same instant; `at drop`, of the stiffness at 1.5 mm
against the object's own. `err/sd` is the rms of error over stated sd. `height` is the scatter of looks at a pressed membrane
about the run's mean error. `s` are robot seconds, `past` the seconds since the hand stood at the object's top.
`falls` counts presses at whose end the scene's own force was lower than at the last by over 2 % and 10 mN.

The force model is the twin's own: the paper's law at hertz fidelity, the shipped membrane model, which has weight and bending, at
sheet fidelity; --set model=FILE takes another. Scenes are the shipped balloons, with all noise of the `bench` camera; all balloons
of a seed see the same noise.
"""

from __future__ import annotations

import argparse

import numpy as np
import numpy.typing as npt

from stretch_bt.accuracy.palpation.figures import figures
from stretch_bt.accuracy.palpation.palpated import palpated
from stretch_bt.accuracy.palpation.protocols import BALLOONS, PROTOCOLS
from stretch_bt.accuracy.summary import rms

Array = npt.NDArray[np.float64]

SUMMED = ("water", "pudding", "seeds")
#: the pairs of protocols to compare, and the columns of seconds and error to compare them in
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
    print("\nover water, pudding and seeds: presses, robot seconds, of them past the touch, rms error, also at drop")
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
