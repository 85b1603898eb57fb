"""Whether the first row of each domain of `accuracy` holds any compilation: its CPU time with a cold cache of kernels, and with a warm one.

    python -m benchmarks.accuracy_cold [NAME ...] [--workers 1]

Each domain is measured to its first row with a time in two processes, one after the other; the first finds no compiled code.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor

from stretch_bt.accuracy import domains, measure

ONE = "one"  # the word with which this script calls itself
LIMIT = 1.3


def first(name: str) -> float:
    """Return the CPU time of the first row that has one, s."""
    return next(row.cpu_seconds for row in measure([name]) if row.cpu_seconds)


def measured(name: str, cache: str) -> float:
    command = [sys.executable, "-m", "benchmarks.accuracy_cold", ONE, name]
    environment = {**os.environ, "NUMBA_CACHE_DIR": cache, "OMP_NUM_THREADS": "1"}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    return float(done.stdout.splitlines()[-1])


def compared(name: str) -> str:
    with tempfile.TemporaryDirectory() as cache:
        cold, warm = measured(name, cache), measured(name, cache)
    ratio = cold / warm
    return f"{name:15s} {1e3 * cold:10.2f} {1e3 * warm:10.2f} {ratio:6.2f}{'' if ratio < LIMIT else '  <- over ' + str(LIMIT)}"


def main() -> None:
    if sys.argv[1:2] == [ONE]:
        print(first(sys.argv[2]))
        return
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("names", nargs="*")
    parser.add_argument("--workers", type=int, default=1)
    asked = parser.parse_args()
    print(f"{'domain':15s} {'cold, ms':>10s} {'warm, ms':>10s}  ratio", flush=True)
    with ThreadPoolExecutor(asked.workers) as pool:
        for line in pool.map(compared, domains(asked.names)):
            print(line, flush=True)


if __name__ == "__main__":
    main()
