"""The whole of `stretch-bt accuracy` on a machine with many cores, in parts that can be taken up again.

    python -m benchmarks.accuracy_parts FOLDER [NAME ...] [--workers 16] [--minutes 1] [--commit SHA]

Each domain is cut into parts of about so many minutes of CPU time. A part is a process of its own with one thread, longest first, and its rows
are FOLDER/NAME.K.jsonl once it is done; a part that is there is not run again. The page in FOLDER/page is made of all parts that are there.
`--commit` names the commit that made the rows where git does not know.
"""

from __future__ import annotations

import argparse
import math
import os
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

from stretch_bt.accuracy import domains, measure, page
from stretch_bt.accuracy.file import merged, read, write
from stretch_bt.accuracy.kernels import load_kernels
from stretch_bt.accuracy.points import Row

ONE = "one"  # the word with which this script calls itself
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS")


class Part(NamedTuple):
    """A part of a domain, of how many, and the CPU seconds that it should take."""

    name: str
    number: int
    of: int
    seconds: float

    def file(self, folder: Path) -> Path:
        """Return where its rows are kept."""
        return folder / f"{self.name}.{self.number:02d}.jsonl"


def parts(names: list[str], seconds: float) -> list[Part]:
    found = []
    for name, domain in domains(names).items():
        whole = sum(job.seconds for job in domain.jobs(False))
        count = max(math.ceil(whole / seconds), 1)
        found += [Part(name, number, count, whole / count) for number in range(1, count + 1)]
        print(f"{name}: {whole:.0f} CPU s in {count} parts", flush=True)
    return sorted(found, key=lambda part: -part.seconds)


def run(part: Part, folder: Path, commit: str) -> None:
    command = [sys.executable, "-m", "benchmarks.accuracy_parts", ONE, part.name, f"{part.number}/{part.of}"]
    began = time.monotonic()
    environment = {**os.environ, **dict.fromkeys(THREADS, "1")}
    done = subprocess.run([*command, str(part.file(folder)), commit], env=environment, check=False)
    spent = time.monotonic() - began
    print(f"{part.name} {part.number}/{part.of}: exit {done.returncode}, {spent:.0f} s", flush=True)


def one(name: str, share: str, path: str, commit: str) -> None:
    number, _, count = share.partition("/")
    unfinished = Path(f"{path}.part")
    rows: list[Row] = []
    write(unfinished, rows)  # a part may have none, where a group is longer than a part
    for row in measure([name], part=(int(number), int(count)), commit=commit or None):
        rows.append(row)
        write(unfinished, rows)
    unfinished.replace(path)


def main() -> None:
    if sys.argv[1:2] == [ONE]:
        one(*sys.argv[2:])
        return
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--minutes", type=float, default=1.0)
    parser.add_argument("--commit", default="")
    asked = parser.parse_args()
    asked.folder.mkdir(parents=True, exist_ok=True)
    wanted = [p for p in parts(asked.names, 60 * asked.minutes) if not p.file(asked.folder).exists()]
    load_kernels("perception", "simulation")  # else each part would compile them
    with ThreadPoolExecutor(asked.workers) as pool:
        list(pool.map(lambda part: run(part, asked.folder, asked.commit), wanted))
    rows = [row for path in sorted(asked.folder.glob("*.jsonl")) for row in read(path)]
    (asked.folder / "page").mkdir(exist_ok=True)
    page.write(asked.folder / "page", merged(rows))


if __name__ == "__main__":
    main()
