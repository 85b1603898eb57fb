"""Ask whether the hard cases alone notice changes of the code: `python benchmarks/mutants.py [--jobs 16] [--seed 0]`.

Four mutants are drawn in each of ten domains. Each is imported in the place of its file, in a process of its own, with a cache of
compiled kernels of its own; first the cases of its domain are run, then all others, up to the first that does not end as it must.
A process that does not end in time counts as noticed, as a case that never ends does not end as it must. Prints a line a mutant,
and how many are noticed; `--list` only draws. Exits 1 where fewer than 36 of 40 are.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path

from mutation.caches import seed as seed_cache
from mutation.draw import Mutant, draw
from mutation.sources import DOMAINS, module_of

from stretch_bt.hardcases import DOMAINS as CATALOGUE
from stretch_bt.threads import ONE_THREAD

COUNT, NEEDED = 4, 0.9
ROOT = Path(__file__).parents[1]


@dataclass(frozen=True)
class Verdict:
    """What became of a mutant: whether it was noticed, by what, and after how many seconds."""

    mutant: Mutant | None
    noticed: bool
    by: str
    seconds: float

    def __str__(self) -> str:
        said = f"noticed by {self.by}" if self.noticed else f"SURVIVED {self.by}"
        return f"{self.mutant or 'the code as it is'}\n    {said}, {self.seconds:.0f} s"


def judged(mutant: Mutant | None, domains: list[str], limit: float) -> Verdict:
    """Run the cases of domains with a mutant, or with the code as it is."""
    began = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        text, module = Path(folder) / "changed.py", "-"
        if mutant is not None:
            text.write_text(mutant.source(), encoding="utf-8")
            module = module_of(mutant.path)
        cache = Path(folder) / "cache"
        cache.mkdir()
        seed_cache(cache, None if mutant is None else mutant.path)
        command = [
            sys.executable,
            "-m",
            "benchmarks.mutation.child",
            module,
            "-" if mutant is None else str(text),
            *domains,
        ]
        env = {**os.environ, **ONE_THREAD, "NUMBA_CACHE_DIR": str(cache), "PYTHONPATH": str(ROOT)}
        try:
            done = subprocess.run(
                command, cwd=ROOT, env=env, capture_output=True, text=True, timeout=limit, check=False
            )
        except subprocess.TimeoutExpired:
            return Verdict(mutant, True, f"a case that does not end within {limit:.0f} s", time.monotonic() - began)
    return _read(mutant, done, time.monotonic() - began)


def _read(mutant: Mutant | None, done: subprocess.CompletedProcess[str], seconds: float) -> Verdict:
    try:
        found = json.loads(done.stdout.splitlines()[-1])
    except (IndexError, ValueError):
        return Verdict(mutant, True, f"the end of the process ({done.returncode}): {done.stderr[-200:]}", seconds)
    if not found["noticed"]:
        return Verdict(mutant, False, "all cases" if found["used"] else "all cases, none of which imports it", seconds)
    return Verdict(mutant, True, f"{found['case'] or 'the import'}: {found['outcome'][:160]}", seconds)


def main() -> int:
    """Draw mutants, judge them, and print what became of them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--limit", type=float, default=1800.0, help="seconds that the cases may take with a mutant")
    parser.add_argument("--domain", action="append", choices=list(DOMAINS), help="only mutants of this domain")
    parser.add_argument("--own", action="store_true", help="run the cases of the mutant's own domain alone")
    parser.add_argument("--list", action="store_true", help="draw the mutants, and run nothing")
    given = parser.parse_args()
    drawn = [mutant for domain in given.domain or DOMAINS for mutant in draw(domain, COUNT, given.seed)]
    if given.list:
        print("\n".join(map(str, drawn)))
        return 0
    with ThreadPoolExecutor(given.jobs) as pool:
        # the code as it is first, which also compiles what the others take over
        asked = given.domain or list(CATALOGUE)
        wrong = [v for v in pool.map(lambda d: judged(None, [d], given.limit), asked) if v.noticed]
        if wrong:
            print("\n".join(map(str, wrong)))
            return 1
        running = [pool.submit(judged, m, _order(m, given.own), given.limit) for m in drawn]
        verdicts = []
        for done in as_completed(running):
            verdicts.append(done.result())
            print(verdicts[-1], flush=True)
    noticed = sum(verdict.noticed for verdict in verdicts)
    print(f"{noticed} of {len(verdicts)} mutants are noticed by the hard cases alone")
    return int(noticed < NEEDED * len(verdicts))


def _order(mutant: Mutant, own: bool) -> list[str]:
    """Return the domains in the order in which their cases are run."""
    return [mutant.domain] if own else [mutant.domain, *(d for d in CATALOGUE if d != mutant.domain)]


if __name__ == "__main__":
    sys.exit(main())
