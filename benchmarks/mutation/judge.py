"""Verdicts of hard cases on the code as it is, and on mutants: rows that are kept, each found in a process of its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from threading import Lock
from typing import Any

from mutation.caches import seed
from mutation.draw import Mutant
from mutation.sources import code, module_of
from stretch_bt.hardcases import DOMAINS, cases
from stretch_bt.sweep.rows import RowFile
from stretch_bt.threads import ONE_THREAD

__all__ = ["Judge", "Unfit"]

ROOT = Path(__file__).parents[2]
#: CPU time that a case may take with a mutant: so many times its own, and so many seconds for what is compiled anew
_TIMES, _MORE = 20.0, 180.0

Row = dict[str, Any]
Address = tuple[str, str]


@dataclass
class _Heard:
    """What a child process reported: the case it was at, seconds by case, outcomes that were wrong, and the modules it imported."""

    at: Address = ("", "")
    seconds: dict[Address, float] = field(default_factory=dict)
    wrong: dict[Address, str] = field(default_factory=dict)
    imports: list[str] = field(default_factory=list)


class Unfit(Exception):
    """The code as it is does not pass the hard cases, or there was too little time: nothing is known of mutants."""


class Judge:
    """Runs hard cases with a mutant, in the order of the time that they take, up to the first that notices it.

    Rows are kept in a file. One that was found with the same code and cases is not found again; what noticed a mutant in
    another state of them is run first.
    """

    def __init__(self, kept: RowFile, limit: float) -> None:
        self.kept, self.limit = kept, limit
        self.known: dict[str, Row] = {}
        self._codes: dict[tuple[str, ...], str] = {}
        self._lock = Lock()

    def as_it_is(self, domain: str) -> Row:
        """Return, and keep, how long each case of a domain takes with no mutant, and which modules they import.

        Raises
        ------
        Unfit
            A case does not end as it must.
        """
        row = self._kept(key := f"as it is: {domain}")
        if row is None or row["code"] != self._code(domain):
            heard, rest = self._heard("-", "-", [(domain, name, 600.0) for name in cases(domain)], dict(os.environ))
            wrong = {name: outcome for (_, name), outcome in heard.wrong.items()} | (
                {heard.at[1]: rest} if rest else {}
            )
            row = {
                "key": key,
                "status": "wrong" if wrong else "ok",
                "code": self._code(domain),
                "seconds": {name: spent for (_, name), spent in heard.seconds.items()},
                "imports": heard.imports,
                "wrong": wrong,
            }
            self._keep(row)
        if row["wrong"]:
            lines = [f"{domain}, the code as it is: {name}: {outcome}" for name, outcome in row["wrong"].items()]
            raise Unfit("\n".join(lines))
        self.known[domain] = row
        return row

    def row(self, mutant: Mutant, *, own: bool = False) -> Row:
        """Return, and keep, what became of a mutant; `own` leaves the cases of other domains out."""
        before = self._kept(str(mutant))
        valid = before is not None and before["code"] == self._code(*before["domains"])
        domains = [mutant.domain] if own else list(DOMAINS)
        if before is not None and valid and (before["status"] == "noticed" or set(domains) <= set(before["domains"])):
            return before
        passed = before["domains"] if before is not None and valid else []
        order = self._order(mutant, [d for d in domains if d not in passed], (before or {}).get("case"))
        heard, rest = self._with(mutant, order) if order else (_Heard(), "")
        noticed = bool(rest or heard.wrong)
        row = {
            "key": str(mutant),
            "status": "noticed" if noticed else "survived",
            "domains": (found := [heard.at[0]] if noticed else domains),
            "code": self._code(*found),
            "case": list(heard.at) if noticed else None,
            "outcome": rest or heard.wrong.get(heard.at, ""),
            "cpu_seconds": round(sum(heard.seconds.values()), 2),
        }
        self._keep(row)
        return row

    def _kept(self, key: str) -> Row | None:
        with self._lock:
            return next(self.kept.rows(iter([key])), None)

    def _keep(self, row: Row) -> None:
        with self._lock:
            self.kept.write(row)

    def _code(self, *domains: str) -> str:
        if domains not in self._codes:
            self._codes[domains] = code(*domains)
        return self._codes[domains]

    def _order(self, mutant: Mutant, domains: list[str], first: list[str] | None) -> list[tuple[str, str, float]]:
        """Return cases that import the file of a mutant: what noticed it before, then its own domain, then others, quick ones first."""
        module = module_of(mutant.path)
        found = [
            (domain, name, spent)
            for domain in domains
            if module in self.known[domain]["imports"]
            for name, spent in self.known[domain]["seconds"].items()
        ]
        found.sort(key=lambda case: (list(case[:2]) != first, case[0] != mutant.domain, case[2]))
        return [(domain, name, _TIMES * spent + _MORE) for domain, name, spent in found]

    def _with(self, mutant: Mutant, order: list[tuple[str, str, float]]) -> tuple[_Heard, str]:
        with tempfile.TemporaryDirectory() as folder:
            text, cache = Path(folder) / "changed.py", Path(folder) / "cache"
            text.write_text(mutant.source(), encoding="utf-8")
            cache.mkdir()
            seed(cache, mutant.path)
            env = {**os.environ, "NUMBA_CACHE_DIR": str(cache)}
            return self._heard(module_of(mutant.path), str(text), order, env)

    def _heard(
        self, module: str, source: str, order: list[tuple[str, str, float]], env: dict[str, str]
    ) -> tuple[_Heard, str]:
        """Return what a child process reported, and how it ended where it did not end by itself."""
        command = [sys.executable, "-m", "benchmarks.mutation.child", module, source]
        env = {**env, **ONE_THREAD, "PYTHONPATH": str(ROOT)}
        with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
            child = subprocess.Popen(
                command, cwd=ROOT, env=env, stdin=subprocess.PIPE, stdout=out, stderr=err, text=True
            )
            try:
                child.communicate(json.dumps(order), timeout=self.limit)
                ended = "" if child.returncode in (0, 1) else f"the process ended by {child.returncode}"
            except subprocess.TimeoutExpired:  # a machine that is busy or was halted says nothing of a mutant
                what = "the code as it is" if module == "-" else module
                raise Unfit(f"{what}: no end within {self.limit:.0f} s of wall time; give more by --limit") from None
            finally:
                child.kill()
                child.wait()
            out.seek(0)
            err.seek(0)
            whole = [line for line in out if line.endswith("\n")]
            return _read(whole), ended and f"{ended}: {err.read()[-200:]}".rstrip(": \n")


def _read(lines: list[str]) -> _Heard:
    heard = _Heard()
    for line in map(json.loads, lines):
        if "at" in line:
            heard.at = tuple(line["at"])
        elif "imports" in line:
            heard.imports = line["imports"]
        else:
            heard.seconds[heard.at] = line["seconds"]
            if not line["ok"]:
                heard.wrong[heard.at] = line["outcome"]
    return heard
