"""Tasks that end badly: broken numbers, no end, late ends, a broken finally, trees too deep, too large or empty.

Leaves are mocked, so that no device is opened and no wall time passes.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from textwrap import dedent, indent
from typing import Any, NamedTuple

from stretch_bt.errors import MocksError, TreeError
from stretch_bt.hardcases.expect import Check, Expectation, Refusal
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.runtime.task import run

HEAD = "format: stretch-tree/1\ntick: 100 ms\n"
WAIT = "wait: {{duration: {0}}}"


class _End(NamedTuple):
    """How a task ended: status, reason, ticks, task time, s, outputs, and each place's statuses in order."""

    status: str
    reason: str
    ticks: int
    seconds: float
    outputs: dict[str, Any]
    visited: Mapping[str, tuple[str, ...]]


def _text(body: str, head: str = "", more: str = "") -> str:
    main = indent(dedent(body).strip(), "    ")
    others = indent(dedent(more).strip(), "  ")
    return f"{HEAD}{dedent(head).strip()}\ntrees:\n  main:\n{main}\n{others}\n"


def _ended(
    body: str, head: str = "", more: str = "", *, mocks: Any = None, longest: float = 600.0, **params: Any
) -> _End:
    """Run a tree, and return how it ended."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "tree.yaml"
        path.write_text(_text(body, head, more), encoding="utf-8")
        done = run(path, mocks=mocks, out=Path(folder) / "record", longest=longest, params=params or None)
    values = {name: told["value"] for name, told in done.outputs.items()}
    return _End(done.status, done.reason, done.ticks, done.task_seconds, values, done.visited)


def ends(status: str, reason: str = "", ticks: int | None = None, **outputs: Any) -> Check:
    """Expect a status, a reason that begins so, a number of ticks, and outputs."""

    def check(found: _End) -> bool:
        fits = (
            found.status == status and found.reason.startswith(reason) and bool(found.reason) == (status != "SUCCESS")
        )
        return fits and ticks in (None, found.ticks) and all(found.outputs.get(n) == v for n, v in outputs.items())

    parts = [
        status,
        *([reason] if reason else []),
        *([f"{ticks} ticks"] if ticks else []),
        *(f"{n} = {v}" for n, v in outputs.items()),
    ]
    return Check(", ".join(parts), check)


def _mocked(*rules: str) -> Any:
    return "format: stretch-mocks/1\ntree: tree.yaml\nmocks:\n" + "".join(f"  - {{{rule}}}\n" for rule in rules)


def _chain(depth: int) -> str:
    return "{invert: " * (depth - 1) + "{check: {that: true}}" + "}" * (depth - 1)


def _many(count: int) -> str:
    return "sequence: [" + ", ".join(["set: {n: n + 1}"] * count) + "]"


def _ran_last(*names: str) -> Check:
    """Expect that these places succeeded, and the task did not."""

    def check(found: _End) -> bool:
        return found.status != "SUCCESS" and all("SUCCESS" in found.visited.get(name, ()) for name in names)

    return Check(f"no success, but {' and '.join(names)} ran", check)


NUMBER = "keys: {n: {type: float, default: 0}, m: {type: float, default: 0}}"
COUNT = "keys: {n: {type: int, default: 0}}"
LENGTH = "keys: {d: Length}"
#: a task with something owed, whose two waits are mocked
OWING = "sequence: [{name: work, wait: {duration: 1 s}}]\nfinally: [{name: end, wait: {duration: 1 s}}]"
NESTED = (
    "sequence: [outer: {}]\nfinally: [{name: last, wait: {duration: 100 ms}}]",
    "",
    """
    outer: {sequence: [inner: {}], finally: [{name: outer_end, wait: {duration: 100 ms}}]}
    inner: {sequence: [check: {that: false, name: never}], finally: [{name: inner_end, wait: {duration: 100 ms}}]}
    """,
)

#: body, heading, and how it ends
BROKEN: dict[str, tuple[str, str, Expectation]] = {
    "a division by 0": ("sequence: [set: {m: 1 / n}]", NUMBER, ends("ERROR", "main/set: 1 / 0.0 is no finite number")),
    "a number past all numbers": (
        "sequence: [set: {n: 1e300}, set: {m: n * n}]",
        NUMBER,
        ends("ERROR", "main/set[1]: "),
    ),
    "a root of what is below 0": ("sequence: [set: {m: sqrt(n - 1)}]", NUMBER, ends("ERROR", "main/set: ")),
    "a guard that does not hold": (
        "{guard: {that: task.ticks < 4, name: early}, wait: {duration: 10 s}}",
        "",
        ends("FAILURE", "main/early: ", 4),
    ),
}
ENDLESS: dict[str, tuple[str, str, Expectation]] = {
    "a wait past the longest task": (
        WAIT.format("1 h"),
        "",
        ends("FAILURE", "no end within 10 min of virtual time", 6001),
    ),
    "a timeout": (
        "{timeout: 150 ms, name: a, wait: {duration: 1 s}}",
        "",
        ends("FAILURE", "main/a:timeout: out of time", 3),
    ),
    "a success later than its timeout": (
        "{timeout: 250 ms, name: a, wait: {duration: 260 ms}}",
        "",
        ends("FAILURE", "main/a:timeout: out of time", 4),
    ),
    "three attempts": (
        "{retry: 3, name: a, check: {that: n > 0}}",
        NUMBER,
        ends("FAILURE", "main/a:retry: 3 attempts failed", 3),
    ),
    "a loop up to its bound": (
        "until: {that: n >= 100, max: 7, do: {set: {n: n + 1}}}",
        NUMBER,
        ends("FAILURE", "main/until: "),
    ),
    "a thousand passes": (
        "sequence: [repeat: {times: 1000, do: {set: {n: n + 1}}}]\nout: {n: {type: int, default: 0}}",
        "",
        ends("SUCCESS", n=1000),
    ),
    "an empty list": (
        "for_each: {items: $many, as: $n, do: {check: {that: n > 0}}}",
        "params: {many: {type: 'list[int]', default: []}}",
        ends("SUCCESS"),
    ),
}
OWED: dict[str, tuple[tuple[str, ...], Expectation]] = {
    "both are done": (("match: main/work", "match: main/finally/end"), ends("SUCCESS")),
    "the task fails": (
        ("match: main/work, status: failure, message: no", "match: main/finally/end"),
        _ran_last("main/finally/end"),
    ),
    "its end fails": (
        ("match: main/work", "match: main/finally/end, status: failure, message: no"),
        ends("FAILURE", "the task was done, but its finally failed: main/finally/end: no"),
    ),
    "both fail": (
        ("match: main/work, status: failure, message: no", "match: main/finally/end, status: failure, message: nor"),
        ends("FAILURE", "main/work: no"),
    ),
    "its end never comes": (
        ("match: main/work", "match: main/finally/end, status: running"),
        ends("FAILURE", "the task was done, but its finally failed: main/finally did not end within 60 s"),
    ),
    "the task never ends": (
        ("match: main/work, status: running", "match: main/finally/end"),
        _ran_last("main/finally/end"),
    ),
}
#: body, and the code that is found
LOADED: dict[str, tuple[str, str]] = {
    "a chain of 101": (_chain(101), "depth"),
    "a chain of 400": (_chain(400), "yaml-depth"),
    "a sequence of nothing": ("sequence: []", "value|children|empty|missing"),
    "a parallel of nothing": ("parallel: []", "value|children|empty|missing"),
    "a loop of no pass": ("repeat: {times: 0, do: {check: {that: true}}}", "out-of-bounds"),
    "a wait of no time": ("wait: {duration: 5}", "value|unit|type"),
    "a tree that calls itself": ("main: {}", ""),
}


def _loaded(body: str) -> _End:
    return _ended(body)


CASES: tuple[Hard, ...] = (
    *group(
        "an expression that has no finite value, or reads a key that nothing wrote",
        {name: (partial(_ended, body, head), expect) for name, (body, head, expect) in BROKEN.items()},
    ),
    *group(
        "a task may never end, end too late, or go on for long",
        {name: (partial(_ended, body, head), expect) for name, (body, head, expect) in ENDLESS.items()},
        {
            "an output that overflows on its way": (
                partial(
                    _ended,
                    "sequence: [repeat: {times: 1100, do: {set: {n: n * 2}}}]",
                    "keys: {n: {type: float, default: 1}}",
                ),
                ends("ERROR", "main/"),
            ),
        },
    ),
    *group(
        "however a task ends, its finally is run, and for a bounded time",
        {
            f"owed, {name}": (partial(_ended, OWING, mocks=_mocked(*rules)), expect)
            for name, (rules, expect) in OWED.items()
        },
        {
            "owed three deep": (
                partial(_ended, *NESTED),
                _ran_last("main/outer/inner/finally/inner_end", "main/outer/finally/outer_end", "main/finally/last"),
            ),
        },
    ),
    *group(
        "a tree that is too deep, too large, empty or its own part",
        {name: (partial(_loaded, body), Refusal(TreeError, code)) for name, (body, code) in LOADED.items()},
        {
            "a key that may be unset": (
                partial(
                    _ended,
                    "sequence: [{name: maybe, skip_if: task.ticks < 9, set: {d: 1 mm}}, check: {that: d > 0 mm}]",
                    LENGTH,
                ),
                Refusal(TreeError, "read-before-write"),
            ),
            "a chain of 100": (partial(_ended, _chain(100)), Check("ended", lambda found: found.ticks == 1)),
            "a thousand steps": (partial(_ended, _many(1000), COUNT), ends("SUCCESS")),
            "a mock of a place that is none": (
                partial(_ended, OWING, mocks=_mocked("match: main/nowhere")),
                Refusal(MocksError, "nowhere"),
            ),
        },
    ),
)
