"""Calls of a function, on the engines of a sweep: each is kept in a file, and is not made again by the same code."""

from __future__ import annotations

import hashlib
import inspect
import json
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stretch_bt.sweep.engines import engine_of
from stretch_bt.sweep.job import Ran
from stretch_bt.sweep.package_digest import package_digest
from stretch_bt.sweep.rows import RowFile

__all__ = ["kept"]

Arguments = tuple[Any, ...]


@dataclass(frozen=True, slots=True)
class _Call:
    """A call as a job of an engine."""

    key: str
    function: Callable[..., Any]
    arguments: Arguments

    def run(self) -> Ran:
        return Ran({"key": self.key, "status": "SUCCESS", "found": self.function(*self.arguments)})

    def killed(self) -> Ran:
        return Ran({"key": self.key, "status": "killed", "found": None})


def kept(
    function: Callable[..., Any],
    calls: Iterable[Arguments],
    path: Path | None = None,
    workers: int = 1,
    *,
    call: bool = True,
) -> Iterator[tuple[Arguments, Any]]:
    """Yield the arguments of each call and what it returns, as JSON has it: first what the file holds, then as calls end.

    A call is known by the function, its module, its arguments and the package; a function of a benchmark that is run as a
    program goes to the workers by its text. One that ends its process raises RuntimeError. Without `call` none is made.
    """
    source = hashlib.sha256(Path(inspect.getfile(function)).read_bytes()).hexdigest()
    known = {_key(function, arguments, source): arguments for arguments in calls}
    rows = RowFile(path) if path is not None else None
    try:
        done = {} if rows is None else {row["key"]: row["found"] for row in rows.rows(iter(known))}
        yield from ((known[key], found) for key, found in done.items())
        left = [_Call(key, function, arguments) for key, arguments in known.items() if call and key not in done]
        engine = engine_of("local" if workers > 1 else "serial", workers if workers > 1 else None, None)
        with closing(engine(left)) as rans:
            for ran in rans:
                if ran.row["status"] != "SUCCESS":
                    raise RuntimeError(f"{function.__name__}{known[ran.row['key']]} ended its process")
                if rows is not None:
                    rows.write(ran.row)
                yield known[ran.row["key"]], json.loads(json.dumps(ran.row["found"]))
    finally:
        if rows is not None:
            rows.close()


def _key(function: Callable[..., Any], arguments: Arguments, source: str) -> str:
    content = json.dumps([package_digest(), source, function.__qualname__, list(map(str, arguments))])
    return hashlib.sha256(content.encode()).hexdigest()[:32]
