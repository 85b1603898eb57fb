"""Own nodes with random mistakes and random mocks files: the messages that a user gets, and how long they take.

Run with `python benchmarks/fuzz_inputs.py [count] [seed]`; both parts run so many cases in this process, without a device.
Each case must end as its mistake says, or in findings with a place; only a StretchError may be raised, nothing may be
printed to standard output, and no case may take more than 1 s of CPU. Exits 1 where any does otherwise.
"""

from __future__ import annotations

import gc
import io
import random
import signal
import sys
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from stretch_bt.errors import MocksError, StretchError
from stretch_bt.runtime.check import check_file
from stretch_bt.runtime.runner import Runner
from stretch_bt.runtime.task import run
from stretch_bt.tree.ports import Behavior

#: s of CPU that one case may take
LIMIT = 1.0
MOCKS = Path(__file__).parent.parent / "tests" / "trees" / "mocks"

#: annotation of an output -> values that fit it, and values that do not
VALUES = {
    "Length": (["0.01", "1", "np.float32(0.1)", "Estimate(0.01, 0.001)", "Estimate(0.01, 0)"],
               ["None", "'two'", "'5 mm'", "True", "float('nan')", "float('inf')", "-np.inf", "10**400", "1j", "[0.1]",
                "np.zeros(3)", "np.array(0.1)", "object()", "Estimate(0.01, -1)", "Estimate(0.01, float('nan'))",
                "Estimate(float('nan'), 0.1)", "b'1'", "type", "Decimal('1')", "np.datetime64('2026-01-01')"]),
    "int": (["3", "np.int64(3)"], ["3.0", "None", "True", "'3'", "float('nan')", "np.float64(3)", "1j"]),
    "bool": (["True", "np.bool_(False)"], ["1", "None", "'true'", "np.array([True, False])", "0.0"]),
    "str": (["'a'", "''"], ["1", "None", "b'a'", "['a']", "object()"]),
    "Literal['mean', 'either']": (["'mean'"], ["'maen'", "None", "1", "'Mean'"]),
    "list[Length]": (["[0.1, 1]", "()", "[np.float64(1)]", "np.zeros(2)"], ["0.1", "'ab'", "[None]", "['1 mm']", "[float('nan')]", "{0.1}", "np.zeros((2, 2))"]),  # noqa: E501
}  # fmt: skip
#: what code of a node may raise -> how the run ends then
RAISES = {
    "ValueError('boom')": "ERROR", "KeyError('x')": "ERROR", "ZeroDivisionError()": "ERROR", "MemoryError()": "ERROR",
    "RecursionError('deep')": "ERROR", "StopIteration()": "ERROR", "GeneratorExit()": "ERROR", "SystemExit(3)": "ERROR",
    "OSError(2, 'gone')": "ERROR", "UnicodeDecodeError('utf-8', b'x', 0, 1, 'odd')": "ERROR", "BaseException()": "ERROR",
    "NoAnswer('nothing there')": "FAILURE", "DeviceFault('arm', 'no')": "FAULT", "KeyboardInterrupt()": "INTERRUPTED",
    "InvalidInput('wrong')": "ERROR", "NodeError('main', 'odd')": "ERROR", "Odd()": "ERROR",
}  # fmt: skip
NAMES = [*sorted(n for n in {*dir(Behavior), *vars(Behavior())} if n.isidentifier() and not n.startswith("__")),
         "name", "doc", "timeout", "finally_", "guard", "_x", "größe", "log", "retry"]  # fmt: skip
FITTING = ("finally_",)
RETURNS = ["None", "True", "'SUCCESS'", "Status.INVALID", "0", "Status", "object()", "py_trees"]

HEAD = """
import random
from decimal import Decimal
from typing import Literal
import numpy as np
import py_trees
from stretch_bt import Behavior, In, Out, Status, node, port
from stretch_bt.errors import DeviceFault, InvalidInput, NoAnswer, NodeError
from stretch_bt.units import Estimate, Length

class Odd(Exception):
    def __str__(self):
        return "odd text with \\ud800 and \\x00 and [bold]markup[/]"
"""


class Hang(BaseException):
    """A case used up its time."""


@contextmanager
def limited() -> Iterator[None]:
    """Raise Hang in the block after twice the limit of CPU time."""

    def ring(number: int, frame: Any) -> None:
        raise Hang

    before = signal.signal(signal.SIGVTALRM, ring)
    signal.setitimer(signal.ITIMER_VIRTUAL, 2 * LIMIT)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        signal.signal(signal.SIGVTALRM, before)


class Tally:
    """Counts the ends of cases, and keeps the wrong ones."""

    def __init__(self, what: str) -> None:
        self.what = what
        self.ends: Counter[str] = Counter()
        self.wrong: list[str] = []
        self.times: list[float] = []

    def case(self, name: str, wanted: set[str], act: Callable[[], str]) -> None:
        """Run one case, which returns how it ended; `wanted` is how it may end, nothing for anyhow."""
        out, err = io.StringIO(), io.StringIO()
        gc.collect()
        start = time.process_time()
        try:
            with limited(), redirect_stdout(out), redirect_stderr(err):
                end = act()
        except StretchError as error:
            end = "refused" if str(error).strip() else "refused without a word"
        except Hang:
            end = "hang"
        except BaseException:
            end = "traceback"
            self.wrong.append(f"{name}: {traceback.format_exc(limit=-3)}")
        self.times.append(time.process_time() - start)
        self.ends[end] += 1
        good = end in wanted if wanted else end not in ("hang", "traceback", "refused without a word")
        if end != "traceback" and not good:
            self.wrong.append(f"{name}: {end}, not {' or '.join(sorted(wanted)) or 'findings or a result'}")
        if self.times[-1] > LIMIT:
            self.wrong.append(f"{name}: {self.times[-1]:.1f} s of CPU")
        if out.getvalue() or "Traceback" in err.getvalue():
            self.wrong.append(f"{name}: printed {(out.getvalue() + err.getvalue())[:200]!r}")

    def told(self) -> int:
        """Print the counts; return how many cases were wrong."""
        ends = ", ".join(f"{count} {end}" for end, count in self.ends.most_common())
        print(f"{len(self.times)} {self.what}: {ends}; {len(self.wrong)} otherwise than they should; "
              f"most CPU {max(self.times) * 1e3:.0f} ms, median {sorted(self.times)[len(self.times) // 2] * 1e3:.0f} ms")  # fmt: skip
        for text in self.wrong[:20]:
            print("  ", text)
        return len(self.wrong)


# --- own nodes


def wrong_value(rng: random.Random) -> tuple[str, str, set[str]]:
    """Return ports, body and the ends of a node that writes what may not fit."""
    kind = rng.choice(sorted(VALUES))
    fits = rng.random() < 0.3
    value = rng.choice(VALUES[kind][0 if fits else 1])
    return f"    y: Out[{kind}]\n", f"        self.y = {value}\n", {"SUCCESS" if fits else "ERROR"}


def out_of_bounds(rng: random.Random) -> tuple[str, str, set[str]]:
    """Return a node whose output has bounds."""
    value = rng.uniform(-0.2, 0.3)
    end = "SUCCESS" if 0 <= value <= 0.1 else "ERROR"
    name = rng.choice(["y", "y_sd"])
    ports = "    y: Out[Length] = port(min=0.0, max=0.1)\n    y_sd: Out[Length]\n"
    ends = {"ERROR"} if name == "y_sd" and value < 0 else {"SUCCESS"} if name == "y_sd" else {end}
    other = "y" if name == "y_sd" else "y_sd"
    return ports, f"        self.{other} = 0.01\n        self.{name} = {value!r}\n", ends


def missing(rng: random.Random) -> tuple[str, str, set[str]]:
    """Return a node that leaves out an output, which may be allowed."""
    may = rng.random() < 0.4
    kind = rng.choice(["Length", "int", "str", "bool"])
    body = rng.choice(
        ["        pass\n", "        if self.runs > 1:\n            self.y = 1\n", "        self.reason = 'x'\n"]
    )
    return f"    y: Out[{kind}{' | None' if may else ''}]\n", body, {"SUCCESS" if may else "ERROR"}


def raises(rng: random.Random) -> tuple[str, str, set[str]]:
    """Return a node that raises somewhere."""
    error = rng.choice(sorted(RAISES))
    where = rng.choice(["update", "initialise", "terminate", "prepare", "__init__"])
    ends = {RAISES[error]}
    if where in ("prepare", "__init__"):
        ends = (
            {"refused", "traceback"}
            if error in ("KeyboardInterrupt()", "GeneratorExit()", "BaseException()")
            else {"refused"}
        )
    if where == "terminate" and RAISES[error] != "FAULT":
        ends = {"ERROR", "INTERRUPTED"}
    if error in ("KeyboardInterrupt()", "GeneratorExit()", "BaseException()") and where in ("prepare", "__init__"):
        error, ends = "ValueError()", {"refused"}  # an exception that ends the program is the user's wish
    body = f"        raise {error}\n" if where == "update" else "        self.y = 1\n"
    extra = ""
    if where == "__init__":
        extra = f"    def __init__(self, path=''):\n        super().__init__(path)\n        raise {error}\n"
    elif where != "update":
        extra = f"    def {where}(self, *new):\n        raise {error}\n"
    return "    y: Out[Length]\n" + extra, body, ends


def port_name(rng: random.Random) -> tuple[str, str, set[str]]:
    """Return a node with a port that is called oddly."""
    name, role = rng.choice(NAMES), rng.choice(["In", "Out"])
    ends = {"SUCCESS"} if name in FITTING else {"refused"}
    default = " = 0.1" if role == "In" else ""
    return (
        f"    y: Out[Length]\n    {name}: {role}[Length]{default}\n",
        ("        self.y = 1\n" + (f"        self.{name} = 1\n" if role == "Out" else "")),
        ends,
    )


def odd_default(rng: random.Random) -> tuple[str, str, set[str]]:
    """Return a node with an input whose default may not fit."""
    kind = rng.choice(sorted(VALUES))
    fits = rng.random() < 0.3
    value = rng.choice(VALUES[kind][0 if fits else 1])
    text = value if rng.random() < 0.5 else f"port({value})"
    return (
        f"    y: Out[Length]\n    x: In[{kind}] = {text}\n",
        "        self.x\n        self.y = 1\n",
        {"SUCCESS" if fits else "refused"},
    )


def odd_declaration(rng: random.Random) -> tuple[str, str, set[str]]:
    """Return a node that is declared in a way that cannot be."""
    port = rng.choice([
        "x: In[Length] = port(0.1, min=0.2)", "x: In[Length] = port(min='1 mm')", "x: In[Length] = port(min=2, max=1)",
        "x: Out[Length] = 0.1", "x: In[dict | str]", "x: In[complex | int]", "x: In[Missing]", "x: In[Length] = port(max=float('nan'))",
        "__init__ = lambda self: None", "__init__ = lambda self, path, more: None", "__doc__ = None", "x: Out['no type']",
    ])  # fmt: skip
    return f"    y: Out[Length]\n    {port}\n", "        self.y = 1\n", {"refused"}


def returns(rng: random.Random) -> tuple[str, str, set[str]]:
    """Return a node whose update returns no status."""
    return "    y: Out[Length]\n", f"        self.y = 1\n        return {rng.choice(RETURNS)}\n", {"ERROR"}


def prints(rng: random.Random) -> tuple[str, str, set[str]]:
    """Return a node that prints, and has a repr that breaks."""
    return (
        "    y: Out[Length]\n    def __repr__(self):\n        return 1 / 0\n",
        "        self.y = 1\n        print(self.y)\n",
        {"SUCCESS"},
    )


MISTAKES = (wrong_value, wrong_value, out_of_bounds, missing, raises, raises, port_name, odd_default, odd_declaration, returns, prints)  # fmt: skip


def own_nodes(count: int, rng: random.Random, folder: Path) -> Tally:
    """Run nodes with a random mistake each."""
    tally = Tally("own nodes")
    for k in range(count):
        ports, body, ends = rng.choice(MISTAKES)(rng)
        place = folder / f"n{k}"
        place.mkdir()
        source = f'{HEAD}\n@node\nclass Fuzz{k}(Behavior):\n    """Fuzz."""\n{ports}    def update(self):\n{body}        return Status.SUCCESS\n'
        (place / f"fuzz_{k}.py").write_text(source, "utf-8")
        wired = "y: $y" if "y: Out[Length" in ports and rng.random() < 0.7 else ""
        tree = f"format: stretch-tree/1\nimports: {{own: fuzz_{k}}}\nkeys: {{y: Length}}\ntrees:\n  main: {{fuzz{k}: {{{wired}}}}}\n"
        (place / "tree.yaml").write_text(tree, "utf-8")
        tally.case(f"node {k}: {ports.strip()} / {body.strip()}", ends, partial(run_one, place))
    return tally


def run_one(place: Path) -> str:
    """Check and run the tree of a folder, and return how that ended."""
    check_file(place / "tree.yaml")
    with redirect_stdout(sys.stderr):  # as the command line does
        result = run(place / "tree.yaml", out=place / "record")
    if result.status in ("ERROR", "FAULT") and not result.reason.startswith("main"):
        return "an error that names no node"
    return result.status


# --- mocks

ODD = ["", "~", "''", "[]", "{}", "[[]]", "-1", "1e999", ".nan", "10 mm", "nothing", "**", "**/*", "'*'", "*a", "&a [*a]", "5 s", "true",
       "{value: 1 mm, sd: -1 mm}", "{value: 1 mm}", "١٠ mm", "main", "main/press[9]", "a/" * 300 + "b", "'" + "**/" * 200 + "x'",
       "'" + "a*" * 300 + "'", "success", "[success, failure]", "running", "9" * 400, "\\ud800", "!!python/object:os.system x", "öl",
       "main/press#nothing", "lib/none.yaml", "palpate_stiffness", "/dev/zero", "0x1F", "100000"]  # fmt: skip
WORDS = ["match", "status", "status_when", "after", "outputs", "then", "message", "mocks", "expect", "readings", "result", "visited",
         "never", "ticks_max", "tree", "format", "doc"]  # fmt: skip


def mutated(text: str, rng: random.Random) -> str:
    """Return a mocks file with one to three mistakes."""
    for _ in range(rng.randint(1, 3)):
        lines = text.split("\n")
        at = rng.randrange(len(lines))
        way = rng.randrange(9)
        if way == 0:
            del lines[at]
        elif way == 1:
            lines.insert(at, lines[rng.randrange(len(lines))])
        elif way == 2:
            lines[at] = " " * rng.randint(0, 6) + lines[at].lstrip()
        elif way == 3 and ": " in lines[at]:
            head, _, _ = lines[at].partition(": ")
            lines[at] = f"{head}: {rng.choice(ODD)}"
        elif way == 4:
            spot = rng.randrange(len(lines[at]) + 1)
            lines[at] = lines[at][:spot] + rng.choice("{}[]:,-'\"*&#!|>%@`\t\x07é0 ") + lines[at][spot:]
        elif way == 5:
            word = rng.choice(WORDS)
            lines[at] = lines[at].replace(word, rng.choice([word[:-1], word.upper(), rng.choice(WORDS)]), 1)
        elif way == 6:
            lines.insert(at, f"  - {{match: {rng.choice(ODD)}, {rng.choice(WORDS)}: {rng.choice(ODD)}}}")
        elif way == 7:
            lines = lines[:at]
        else:
            pieces = lines[at].split(", ")
            rng.shuffle(pieces)
            lines[at] = ", ".join(pieces)
        text = "\n".join(lines) or "x"
    return text


def mocks_files(count: int, rng: random.Random, folder: Path) -> Tally:
    """Check and run mutated mocks files."""
    tally = Tally("mocks files")
    texts = [path.read_text("utf-8") for path in sorted(MOCKS.glob("*.yaml"))]
    for k in range(count):
        path = folder / f"mocks{k}.yaml"
        path.write_text(mutated(rng.choice(texts), rng), "utf-8")
        tally.case(f"mocks {k}", set(), partial(check_and_run, path, folder / f"r{k}"))
    return tally


def check_and_run(path: Path, record: Path) -> str:
    """Return how a mocks file fared: refused in findings with a place, or how its run ended, without any device."""
    found = check_file(path)
    if any(d.severity == "error" for d in found):
        right = all(d.file and d.line >= 1 and d.column >= 1 and d.code and d.message for d in found)
        return "refused in place" if right else "a finding without a place"
    tree = next(
        line.partition(":")[2].strip() for line in path.read_text("utf-8").split("\n") if line.startswith("tree:")
    )
    try:
        result = run(tree, mocks=path, out=record, devices={}, watch=few_ticks)
    except MocksError:
        return "refused by run after check was silent"
    return f"run to {result.status}"


def few_ticks(runner: Runner) -> None:
    """End what waits for ever sooner than a user would."""
    runner._max_ticks = min(runner._max_ticks or 500, 500)


def main(count: int, seed: int) -> int:
    """Run both parts; return the exit code."""
    gc.collect()
    gc.freeze()  # what was there before belongs to no case, and would be walked through before each
    with TemporaryDirectory() as place:
        folder = Path(place)
        tallies = [own_nodes(count, random.Random(seed), folder), mocks_files(count, random.Random(seed + 1), folder)]
    return 1 if sum(tally.told() for tally in tallies) else 0


if __name__ == "__main__":
    given = [int(a) for a in sys.argv[1:]]
    sys.exit(main(*given, *(500, 0)[len(given) :]))
