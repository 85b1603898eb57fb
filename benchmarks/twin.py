"""The worth of each effect in each shipped scene, and the cost of the advisor's choice.

    python -m benchmarks.twin judge [SCENE ...]     switch each effect over: does the mean result change by the tolerance?
    python -m benchmarks.twin table [SCENE ...]     results and CPU time: auto, everything on, nothing on, the least that does

Ten paired seeds; runs with friction or softening, which cost ten times as much and hardly depend on the seed, get two. Outcomes are kept in
the file that --keep names, so that a long run can be taken up again.
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path

from stretch_bt.accuracy.twin.judge import Judged, Priced, judge, matters, price
from stretch_bt.accuracy.twin.ledger import Ledger, Runs
from stretch_bt.simulation.scene import scene_names

SEEDS = range(10)
DEAR = {"friction": 2, "mullins": 2}


def main() -> None:
    """Print what was asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=("judge", "table"))
    parser.add_argument("scenes", nargs="*", metavar="SCENE")
    parser.add_argument("--keep", type=Path)
    parser.add_argument("--seeds", type=int, default=len(SEEDS))
    parser.add_argument(
        "--everything-seeds", type=int, default=3, help="of the runs with everything on, which are dear"
    )
    parser.add_argument("--workers", type=int, default=2)
    asked = parser.parse_args()
    ledger, scenes = Ledger(asked.keep, asked.workers), asked.scenes or scene_names()
    if asked.what == "judge":
        print_judgements(scenes, ledger, asked.seeds)
    else:
        print_prices(scenes, ledger, asked.seeds, asked.everything_seeds)


def print_judgements(scenes: list[str], ledger: Ledger, seeds: int) -> None:
    """Print, for each scene, how many choices hold, and the others with their numbers."""
    every: list[Judged] = []
    for name in scenes:
        found = judge(name, ledger, SEEDS[:seeds], DEAR)
        every += found
        right = sum(j.right for j in found)
        print(f"{name}: {right} of {len(found)} choices hold by the mean, {sum(map(right_each, found))} by each run")
        for j in found:
            if j.verdict.on or not (j.right and right_each(j)):
                print(f"  {_line(j)}", flush=True)
    for label, right in (("mean", sum(j.right for j in every)), ("each run", sum(map(right_each, every)))):
        print(f"all scenes, by {label}: {right} of {len(every)} choices hold, {100 * right / max(len(every), 1):.1f} %")


def right_each(judged: Judged) -> bool:
    """Whether the advisor's choice holds by the change in each run."""
    return (judged.rms > 1) is judged.verdict.on


def _line(j: Judged) -> str:
    verdict = j.verdict
    estimate = (
        f"estimate {matters(verdict):.3g} of {verdict.observable}" if verdict.estimate is not None else "no estimate"
    )
    flag = "" if j.right else "  <- not by the mean"
    return (
        f"{verdict.name:20s} {'on' if verdict.on else 'off':3s} {estimate:32s} mean {j.mean:8.3g} rms {j.rms:8.3g} "
        f"(tolerances, {j.seeds} seeds){flag}{'' if right_each(j) else '  <- not by each run'}"
    )


def print_prices(scenes: list[str], ledger: Ledger, seeds: int, few: int) -> None:
    """Print results and CPU time of each scene with each set of effects."""
    for name in scenes:
        found = price(name, ledger, SEEDS[:seeds], SEEDS[: min(seeds, few)])
        least, auto = found.runs["least"].cpu_seconds, found.runs["auto"].cpu_seconds
        full = found.runs["everything"].cpu_seconds
        print(
            f"{name}: auto costs {auto / least:.2f} of the least, everything {full / auto:.1f} times auto; "
            f"apart: from everything on, in tolerances, mean of {found.pairs} paired runs"
        )
        for label, runs in found.runs.items():
            on = ", ".join(found.sets[label]) or "-"
            print(
                f"  {label:10s} {runs.cpu_seconds:7.2f} s  apart {found.apart[label]:5.2f}  {_results(found, runs):60s} {on}",
                flush=True,
            )


def _results(found: Priced, runs: Runs) -> str:
    if runs.failed == len(runs.outcomes):
        return f"fails: {runs.outcomes[0].reason[:50]}"
    units = {
        "height": (1e3, "mm"),
        "size": (1e3, "mm"),
        "force": (1.0, "N"),
        "stiffness": (1e-3, "N/mm"),
        "roundness": (100.0, "%"),
    }
    parts = []
    for observable in found.tolerance:
        mean = runs.mean(observable)
        scale, unit = units[observable]
        parts.append(
            f"{observable} {math.nan if mean is None else mean * scale:.3f} {unit}"
            if mean is not None
            else f"no {observable}"
        )
    failed = f", {runs.failed} of {len(runs.outcomes)} fail" if runs.failed else ""
    return "; ".join(parts) + failed


if __name__ == "__main__":
    main()
