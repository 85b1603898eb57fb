"""Run hard cases with one module changed: `python -m benchmarks.mutation.child MODULE SOURCE`.

The module is imported from the text in the file SOURCE, in the place of its own; `-` changes nothing. Standard input is JSON: a list
of cases as [domain, name, seconds of CPU that it may take], run in this order, with a change up to the first that does not end as it must. Each
line of standard output is JSON: the address of a case before it is run, then its outcome, and last the modules that were imported.
A case that takes longer ends the process by SIGPROF.
"""

from __future__ import annotations

import importlib.abc
import importlib.util
import json
import os
import resource
import signal
import sys
from collections.abc import Sequence
from importlib.machinery import ModuleSpec, SourceFileLoader
from pathlib import Path
from types import ModuleType
from typing import IO, TYPE_CHECKING, Any

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer as Buffer

__all__ = ["main"]

#: of data, bytes: what a wrong count asks for must not take the machine's memory
_MEMORY = 6 << 30


class _Changed(SourceFileLoader):
    """Loads a module from another text than the text of its file, and keeps no bytecode."""

    def __init__(self, name: str, path: str, text: bytes) -> None:
        super().__init__(name, path)
        self.text = text

    def get_data(self, path: str) -> bytes:
        return self.text if path == self.path else super().get_data(path)

    def path_stats(self, path: str) -> dict[str, float]:
        raise OSError("no bytecode")

    def set_data(self, path: str, data: Buffer, *, _mode: int = 0o666) -> None:
        pass


class _Finder(importlib.abc.MetaPathFinder):
    """Finds the changed module."""

    def __init__(self, name: str, text: bytes) -> None:
        self.name, self.text = name, text

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if fullname != self.name or path is None:
            return None
        file = str(Path(next(iter(path))) / f"{fullname.rpartition('.')[2]}.py")
        return importlib.util.spec_from_loader(fullname, _Changed(fullname, file, self.text))


def main(module: str, source: str) -> int:
    """Return 1 where a case does not end as it must, 0 where all do."""
    told = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # what a case prints must not get among the lines
    resource.setrlimit(resource.RLIMIT_DATA, (_MEMORY, _MEMORY))
    if source != "-":
        sys.meta_path.insert(0, _Finder(module, Path(source).read_bytes()))
    wrong = False
    for domain, name, seconds in json.load(sys.stdin):
        _tell(told, {"at": [domain, name]})
        signal.setitimer(signal.ITIMER_PROF, seconds)
        wrong = not _ran(told, domain, name) or wrong
        if wrong and source != "-":
            break
    _tell(told, {"imports": sorted(name for name in sys.modules if name.startswith("stretch_bt."))})
    return int(wrong)


def _ran(told: IO[str], domain: str, name: str) -> bool:
    """Report the outcome of a case, and return whether it ended as it must."""
    try:
        from stretch_bt.hardcases import case, run

        row = run(domain, case(domain, name))
    except Exception as broken:  # of the import: a case ends its own errors
        _tell(told, {"ok": False, "outcome": f"{type(broken).__name__}: {broken}", "seconds": 0.0})
        return False
    _tell(told, {"ok": row.ok, "outcome": row.outcome, "seconds": row.seconds})
    return row.ok


def _tell(told: IO[str], what: dict[str, Any]) -> None:
    print(json.dumps(what), file=told, flush=True)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2]))
