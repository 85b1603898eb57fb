"""Run hard cases with one module changed: `python -m benchmarks.mutation.child MODULE SOURCE DOMAIN ...`.

The module is imported from the text in the file SOURCE, in the place of its own; `-` changes nothing. Cases are run from the
quick to the slow ones, those of the first domain first, up to the first that does not end as it must, which is printed as JSON.
"""

from __future__ import annotations

import importlib.abc
import importlib.util
import json
import sys
from collections.abc import Sequence
from importlib.machinery import ModuleSpec, SourceFileLoader
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer as Buffer

__all__ = ["main"]


class _Changed(SourceFileLoader):
    """Loads a module from another text than that of its file, and keeps no bytecode."""

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
        self.used = False

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if fullname != self.name or path is None:
            return None
        self.used = True
        file = str(Path(next(iter(path))) / f"{fullname.rpartition('.')[2]}.py")
        return importlib.util.spec_from_loader(fullname, _Changed(fullname, file, self.text))


def main(module: str, source: str, domains: list[str]) -> int:
    """Return 1 where a case does not end as it must, 0 where all do."""
    finder = None if source == "-" else _Finder(module, Path(source).read_bytes())
    if finder is not None:
        sys.meta_path.insert(0, finder)
    try:
        found = _first_wrong(domains)
    except Exception as broken:
        found = {"case": "", "outcome": f"{type(broken).__name__}: {broken}"}
    used = finder is None or finder.used
    print(json.dumps({"noticed": found is not None, "used": used, **(found or {})}), flush=True)
    return int(found is not None)


def _first_wrong(domains: list[str]) -> dict[str, str] | None:
    from stretch_bt.hardcases import cases, run

    for slow in (False, True):
        for domain in domains:
            for hard in cases(domain).values():
                if hard.costly == slow and not (row := run(domain, hard)).ok:
                    return {"case": f"{domain}: {hard.name}", "expected": row.expected, "outcome": row.outcome}
    return None


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2], sys.argv[3:]))
