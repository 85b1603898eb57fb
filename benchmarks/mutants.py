"""Ask whether the hard cases alone notice changes of the code: `python benchmarks/mutants.py [--seed 0] [--only DOMAIN] [--keep FILE]`.

Four mutants are drawn in each of ten domains. Each is imported in the place of its file, in a process of its own, with a cache of
compiled kernels of its own; no file of the package is changed. First the cases of its domain are run, then the cases of other domains that
import the file, the quick ones first, up to the first that does not end as it must. A case that takes more than twenty times as long as it
does without the mutant, and three minutes, counts as one, as does the end of the process.

Rows go to the file of `--keep`; rows in it, found with the same code and cases, are not found again. Prints a line a mutant,
and how many are noticed; `--list` only draws. Exits 1 where fewer than nine in ten are.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from mutation.draw import Mutant, draw
from mutation.judge import Judge, Unfit
from mutation.sources import DOMAINS

from stretch_bt.hardcases import DOMAINS as CATALOGUE
from stretch_bt.sweep.rows import RowFile

COUNT, NEEDED = 4, 0.9


def main() -> int:
    """Draw mutants, judge them, and print what became of them."""
    given = _given()
    chosen = {domain: draw(domain, given.count, given.seed) for domain in given.only or DOMAINS}
    drawn = [mutant for mutants in chosen.values() for mutant in mutants]
    if given.list:
        print("\n".join(map(str, drawn)))
        return 0
    with _rows(given.keep) as kept:
        judge = Judge(kept, given.limit)
        # domain by domain, all that it asks for; else all domains are run with the code as it is before the first mutant
        parts = [((domain,), mutants) for domain, mutants in chosen.items()] if given.own else [(CATALOGUE, drawn)]
        try:
            noticed = sum(_noticed(judge, domains, mutants, given) for domains, mutants in parts)
        except Unfit as wrong:
            print(wrong)
            return 1
    print(f"{noticed} of {len(drawn)} mutants are noticed by the hard cases alone")
    return int(noticed < NEEDED * len(drawn))


def _noticed(judge: Judge, domains: Sequence[str], mutants: list[Mutant], given: argparse.Namespace) -> int:
    """Return how many mutants are noticed; prints what became of each."""
    for domain in domains:  # also compiles what the mutants take over
        judge.as_it_is(domain)
    noticed = 0
    with ThreadPoolExecutor(given.jobs) as pool:
        for mutant, row in zip(mutants, pool.map(lambda m: judge.row(m, own=given.own), mutants), strict=True):
            noticed += row["status"] == "noticed"
            print(f"{mutant}\n    {_said(row)}", flush=True)
    return noticed


def _said(row: dict[str, Any]) -> str:
    if row["status"] == "noticed":
        return f"noticed by {': '.join(row['case'])}: {row['outcome'][:160]}"
    return f"SURVIVED the cases of {', '.join(row['domains'])}"


@contextmanager
def _rows(path: Path | None) -> Iterator[RowFile]:
    with tempfile.TemporaryDirectory() as folder:
        kept = RowFile(path or Path(folder) / "rows.jsonl")
        try:
            yield kept
        finally:
            kept.close()


def _given() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--count", type=int, default=COUNT, help="mutants a domain")
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument("--limit", type=float, default=3600.0, help="wall time, s, of all cases with a mutant")
    parser.add_argument("--only", action="append", choices=list(DOMAINS), help="only mutants of this domain")
    parser.add_argument("--own", action="store_true", help="run the cases of the mutant's own domain alone")
    parser.add_argument("--keep", type=Path, help="file of rows, to begin or to go on with")
    parser.add_argument("--list", action="store_true", help="draw the mutants, and run nothing")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
