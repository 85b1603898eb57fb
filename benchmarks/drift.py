"""Very long runs, and the quantities that drift in them: `make drift`, or `python benchmarks/drift.py [ticks] [presses] [revolutions] [--count N]`.

ticks          1e6 ticks of a task on the twin without a record
presses        1e5 presses of the sheet, each from the one before, with the same press again after every hundred
revolutions    1e4 revolutions of a lump of dough on each of two paths, and the same with half of the step

Memory must not grow, a step must not take longer in the end than at first, and equal steps must give equal results. Prints each
figure with its bound, and ends with 1 where one is beyond it. `--count` is for a quick look: how many of each.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable

from drifts.course import Finding
from drifts.presses import presses
from drifts.revolutions import revolutions
from drifts.ticks import ticks

from stretch_bt.threads import one_thread

RUNS: dict[str, tuple[Callable[[int, int], list[Finding]], int]] = {
    "ticks": (ticks, 1_000_000),
    "presses": (presses, 100_000),
    "revolutions": (revolutions, 10_000),
}


def main() -> int:
    """Run what is asked for, or all, and return 1 where something drifts."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("runs", nargs="*", metavar="RUN", help=f"of {', '.join(RUNS)}; all unless named")
    parser.add_argument("--count", type=int, help="ticks, presses or revolutions")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    if strange := [name for name in given.runs if name not in RUNS]:
        parser.error(f"{', '.join(strange)}: no such run; name some of {', '.join(RUNS)}")
    bad = 0
    with one_thread():
        for name in given.runs or RUNS:
            run, usual = RUNS[name]
            count = given.count or usual
            print(f"{count} {name}, seed {given.seed}", flush=True)
            found = run(count, given.seed)
            bad += sum(not finding.good for finding in found)
            print("\n".join(map(str, found)), flush=True)
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
