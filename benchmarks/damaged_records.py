"""Damaged records: what `replay` and `report` say of them.

Run with `python benchmarks/damaged_records.py [COUNT] [--seed N] [--show]`. Records of short runs (the twin, mocks, one
that ended in FAILURE, one that was killed) are damaged one at a time: bytes flipped, cut off, lines deleted, doubled and
swapped (in record.mcap its parts), and files emptied and taken away, in each of their four files. Both commands run as from
the command line, in this process. An answer is good where it

- says the damage: exit 2, the code `record-...`, and the file with its line or byte; or
- is `same` (exit 0) or a report, and the reader gives every event, tick and reading as recorded, up to the instant that the
  answer states; or
- is a difference (exit 1) that says the damage too.

Anything else is bad: a traceback, a difference alone, `same` of a record whose content is another, over 1 s
of CPU more than the whole record takes.
"""

from __future__ import annotations

import io
import json
import os
import random
import re
import shutil
import signal
import sys
import time
from argparse import ArgumentParser
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from stretch_bt.cli.app import main as command_line
from stretch_bt.errors import RecordError
from stretch_bt.runtime.onlooker import Onlooker
from stretch_bt.runtime.record import RecordReader
from stretch_bt.runtime.record.folder import EVENTS, MCAP, RESULT, RUN
from stretch_bt.runtime.task import run
from stretch_bt.testing.short_runs import TWIN, short_runs

COUNT, KILLED, HANG, KILLED_AT, LATEST = 2000, 60, 1.0, 12, 0.3
FILES = (RUN, EVENTS, MCAP, RESULT)


def make(folder: Path) -> dict[str, Path]:
    """Return the records to damage, by what they are."""
    runs = short_runs(folder)
    (folder / "fails.yaml").write_text(TWIN.replace("arm.force < 5 N", "arm.force > 5 N"))
    killer = Killer(folder / "twin", folder / "killed")
    run(**runs["twin"], out=folder / "twin", watch=lambda runner: runner.watchers.append(killer))
    run(folder / "fails.yaml", out=folder / "failure", seed=1)
    run(**runs["mocks"], out=folder / "mocks")
    return {name: folder / name for name in ("twin", "failure", "mocks", "killed")}


class Killer(Onlooker):
    """Copies a record in the middle of its run, as its process would leave it that was killed while it wrote a chunk."""

    def __init__(self, record: Path, copy: Path) -> None:
        self.record, self.copy = record, copy

    def begin_tick(self, tick: int, time: float) -> None:
        """Copy it at one tick."""
        if tick == KILLED_AT:
            shutil.copytree(self.record, self.copy)
            with (self.copy / MCAP).open("ab") as file:
                file.write(b"\x06" + (5000).to_bytes(8, "little") + bytes(100))


def parts(name: str, content: bytes) -> list[bytes]:
    """Return the lines of a file; of record.mcap its parts."""
    if name != MCAP:
        return content.splitlines(keepends=True)
    found, at = [content[:8]], 8
    while at + 9 <= len(content):
        end = at + 9 + int.from_bytes(content[at + 1 : at + 9], "little")
        found.append(content[at:end])
        at = end
    return [*found, content[at:]]


def flipped(draw: random.Random, name: str, content: bytes) -> bytes:
    changed = bytearray(content)
    for _ in range(draw.choice((1, 1, 1, 2, 5))):
        changed[draw.randrange(len(changed))] ^= draw.randrange(1, 256)
    return bytes(changed)


def cut(draw: random.Random, name: str, content: bytes) -> bytes:
    return content[: draw.randrange(1, len(content))]


def deleted(draw: random.Random, name: str, content: bytes) -> bytes:
    lines = parts(name, content)
    del lines[draw.randrange(len(lines))]
    return b"".join(lines)


def doubled(draw: random.Random, name: str, content: bytes) -> bytes:
    lines = parts(name, content)
    at = draw.randrange(len(lines))
    return b"".join([*lines[:at], lines[at], *lines[at:]])


def swapped(draw: random.Random, name: str, content: bytes) -> bytes:
    lines = parts(name, content)
    a, b = draw.randrange(len(lines)), draw.randrange(len(lines))
    lines[a], lines[b] = lines[b], lines[a]
    return b"".join(lines)


def emptied(draw: random.Random, name: str, content: bytes) -> bytes:
    return b""


def missing(draw: random.Random, name: str, content: bytes) -> None:
    return None


WAYS = (flipped, cut, deleted, doubled, swapped, emptied, missing)


def content_of(reader: RecordReader) -> tuple[list[Any], list[Any], list[Any]]:
    """Return events, ticks, and what each tick was handed."""
    handed = [[repr_of(h) for h in reader.handed(tick)] for tick in (-1, *(tick for tick, _ in reader.ticks))]
    return [reader.header, *reader.events], reader.ticks, handed


def repr_of(handed: Any) -> Any:
    raw = getattr(getattr(handed.value, "value", None), "raw", None)
    return handed.kind, handed.device, handed.name, repr(handed.value) if raw is None else raw.tobytes()


def unchanged(folder: Path, whole: tuple[list[Any], list[Any], list[Any]]) -> bool:
    """Whether a record reads as it was written, up to where it says that it ends."""
    reader = RecordReader(folder)
    found = content_of(reader)
    return all(new == old[: len(new)] for new, old in zip(found, whole, strict=True)) and (
        not reader.complete or len(found[0]) == len(whole[0])
    )


class Hang(BaseException):
    """An answer took too long."""


@contextmanager
def limit(seconds: float) -> Iterator[None]:
    """Raise Hang after some CPU time, s."""

    def late(*_: Any) -> None:
        raise Hang

    before = signal.signal(signal.SIGPROF, late)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


def command(*arguments: str, seconds: float = 60.0) -> tuple[int | str, str, str]:
    """Return the exit code of a command, or what is bad, with both of its outputs; it may take some CPU time, s."""
    out, err = io.StringIO(), io.StringIO()
    code: int | str = 0
    sys.argv = ["stretch-bt", *arguments]
    try:
        with limit(seconds), redirect_stdout(out), redirect_stderr(err):
            command_line()
    except SystemExit as ended:
        code = ended.code if isinstance(ended.code, int) else 0
    except Hang:
        code = "hang"
    except BaseException as error:  # what a user would see as a traceback
        code = f"traceback {type(error).__name__}"
    return code, out.getvalue(), err.getvalue()


def words(asked: str, folder: Path) -> list[str]:
    """Return the words of a command about a record."""
    return [asked, str(folder), *(["--json"] if asked == "replay" else ["--out", str(folder.parent / "report.html")])]


def taken(asked: str, folder: Path) -> float:
    """Return the CPU time, s, that a command takes of a whole record, once everything is loaded."""
    command(*words(asked, folder))
    began = time.process_time()
    command(*words(asked, folder))
    return time.process_time() - began


def killed_at_random(draw: random.Random) -> str:
    """Return what `replay` says of a run whose process was killed at a random moment."""
    with TemporaryDirectory(prefix="killed-") as place:
        record = Path(place) / "record"
        job = short_runs(Path(place))["twin"]
        child = os.fork()
        if child == 0:
            run(**job, out=record)
            os._exit(0)
        while not (record / EVENTS).exists():
            time.sleep(0.001)
        time.sleep(draw.uniform(0.0, LATEST))
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        code, out, err = command("replay", str(record), "--json")
        if code != 0:
            return f"BAD {code} {out} {err}"
        until = json.loads(out)["until"]
        return "ended before" if until is None else "are the same, up to a stated instant"


COMMANDS = ("replay", "report")
PLACE = re.compile(r"(run\.json|events\.jsonl|record\.mcap|result\.json):\d+:\d+ error\[record-[a-z]+\]")


def verdict(code: int | str, out: str, err: str, json_: bool, good: bool) -> str:
    """Return the verdict on an answer; `good` is whether the record reads as it was written."""
    if isinstance(code, str):
        return f"BAD {code}"
    said = PLACE.search(err) is not None
    document = json.loads(out) if json_ else {}
    if code == 2:
        return "damage said" if said and (not json_ or document.keys() == {"error", "reason"}) else "BAD refusal"
    if code == 1:
        return "differs, damage said" if said and document.get("damage") else "BAD difference"
    if not good:
        return "BAD same"
    until = document.get("until") if json_ else "the record ends early" in Path(out.strip()).read_text("utf-8") or None
    return "as recorded" if until is None else "as recorded, to a stated instant"


def main() -> int:
    """Print the table; exit 1 where an answer is bad."""
    given = ArgumentParser(description=__doc__)
    given.add_argument("count", type=int, nargs="?", default=COUNT)
    given.add_argument("--seed", type=int, default=0)
    given.add_argument("--killed", type=int, default=KILLED)
    given.add_argument("--show", action="store_true", help="print each bad answer")
    options = given.parse_args()
    draw = random.Random(options.seed)
    counts: Counter[tuple[str, str, str]] = Counter()
    bad = 0
    with TemporaryDirectory(prefix="damaged-") as place:
        records = make(Path(place))
        whole = {name: content_of(RecordReader(folder)) for name, folder in records.items()}
        usual = {(asked, name): taken(asked, folder) for name, folder in records.items() for asked in COMMANDS}
        for number in range(options.count):
            name = draw.choice(list(records))
            file = draw.choice([n for n in FILES if (records[name] / n).exists()])
            way = draw.choices(WAYS, (30, 15, 15, 15, 15, 5, 5))[0]
            folder = Path(place) / "damaged"
            shutil.copytree(records[name], folder)
            content = way(draw, file, (folder / file).read_bytes())
            (folder / file).unlink() if content is None else (folder / file).write_bytes(content)
            try:
                good = unchanged(folder, whole[name])
            except RecordError:
                good = False
            for asked in COMMANDS:
                answer = command(*words(asked, folder), seconds=usual[asked, name] + HANG)
                found = verdict(*answer, asked == "replay", good)
                counts[asked, f"{file} {way.__name__}", found] += 1
                if found.startswith("BAD"):
                    bad += 1
                    if options.show:
                        print(number, name, file, way.__name__, found, answer, file=sys.stderr)
            shutil.rmtree(folder)
    show(counts)
    print(f"{options.count} damaged records, {bad} bad answers")
    ends = Counter(killed_at_random(draw) for _ in range(options.killed))
    print(f"{options.killed} runs that were killed: " + ", ".join(f"{n} {end}" for end, n in sorted(ends.items())))
    bad += sum(n for end, n in ends.items() if end.startswith("BAD"))
    return 1 if bad else 0


def show(counts: Counter[tuple[str, str, str]]) -> None:
    """Print a row for each command, file and way."""
    answers = sorted({answer for _, _, answer in counts})
    rows = sorted({(asked, what) for asked, what, _ in counts})
    print("".join(f"{text:>34}" for text in ("", *answers)))
    for asked, what in rows:
        print(f"{asked + ' ' + what:>34}" + "".join(f"{counts[asked, what, answer]:34}" for answer in answers))
    for asked in ("replay", "report"):
        sums = [sum(n for (a, _, f), n in counts.items() if (a, f) == (asked, answer)) for answer in answers]
        print(f"{asked + ' all':>34}" + "".join(f"{n:34}" for n in sums))


if __name__ == "__main__":
    sys.exit(main())
