"""Signals at random instants of `stretch-bt run --json`, from its first line to its exit, whoever reads its output.

Run with `python benchmarks/signals.py [signals] [--seed N] [--at-once N]`. Each signal goes to a process of its own, which
runs a small tree on the twin or on mocks. Its instant is drawn evenly over the processor time of a whole run, so a busy
machine shifts nothing. SIGINT and SIGTERM take turns, as do five readers: standard error read, a full pipe that nobody
reads, closed; standard output closed, a full pipe. These count as wrong:

- `traceback`: one on standard error, or an exception that was ignored
- `hang`: more than 1 s from the signal to the exit, without the time in which the process waited for a processor
- `exit`: another exit code than 130
- `json`: standard output is not one JSON document with the status INTERRUPTED
- `record`: a folder without a result, or one that says otherwise than the JSON
- `moving`: a device whose last command neither ended nor was followed by a stop

`before main` are signals that came before the first line of `main`, which Python or the system answers; `over` are signals
that came after the result had been given, and the exit code is the result's. Neither counts as wrong.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path

COMMAND = Path(sys.executable).with_name("stretch-bt")
TREE = """\
format: stretch-tree/1
devices: {arm: Arm, gripper: Gripper}
scene: water_balloon
trees:
  main:
    sequence:
      - set_stretch: {stretch: 3 mm}
      - retract: {clearance: 20 mm}
    finally:
      - retract: {clearance: 20 mm}
"""
MOCKS = """\
format: stretch-mocks/1
tree: tree.yaml
mocks:
  - {match: "**/set_stretch", after: 2 s}
  - {match: "**/retract", after: 30 s}
"""
DEVICES = ("twin", "mocks")
READERS = ("stderr read", "stderr unread", "stderr closed", "stdout closed", "stdout unread")
#: of these nothing is to be had
SILENT = ("stdout closed", "stdout unread")
WRONG = ("traceback", "hang", "exit", "json", "record", "moving")
#: between a signal and the exit, s
PROMPT = 1.0
#: after which a process is ended by force, s
LIMIT = 60.0


@dataclass
class End:
    """How a process ended after its signal."""

    code: int
    waited: float
    out: bytes
    err: bytes
    record: Path
    sent: bool
    wrong: set[str] = field(default_factory=set)


def schedule(process: int) -> tuple[float, float]:
    """Return how long the main thread of a process has run, and waited for a processor, s."""
    try:
        ran, waited, _ = Path(f"/proc/{process}/schedstat").read_text().split()
    except OSError:
        return 0.0, 0.0
    return int(ran) / 1e9, int(waited) / 1e9


Job = tuple[tuple[str, str], signal.Signals, float, "Future[End]"]


@contextmanager
def full_pipe() -> Iterator[int]:
    """Give the end of a pipe that takes nothing more, and that nobody reads."""
    kept, given = os.pipe()
    os.set_blocking(given, False)
    for piece in (b"x" * 4096, b"x"):
        with suppress(BlockingIOError):
            while True:
                os.write(given, piece)
    os.set_blocking(given, True)
    try:
        yield given
    finally:
        os.close(kept)
        os.close(given)


def command(devices: str, reader: str) -> list[str]:
    """Return the command line, in a shell that closes what is closed."""
    words = ["run", "../tree.yaml", "--json", "--out", "record"]
    words += ["--mocks", "../mocks.yaml"] if devices == "mocks" else []
    closes = {"stderr closed": " 2>&-", "stdout closed": " >&-"}.get(reader, "")
    return ["/bin/sh", "-c", f'exec "{COMMAND}" {" ".join(words)}{closes}']


def run(folder: Path, devices: str, reader: str, after: float, number: signal.Signals) -> End:
    """Run the task in an empty folder, send a signal after some processor time, s, and see how that ends."""
    folder.mkdir()
    with (
        full_pipe() as full,
        (folder / "err").open("wb") as err,
        (folder / "out").open("wb") as out,
        subprocess.Popen(
            command(devices, reader),
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=full if reader == "stdout unread" else out,
            stderr=full if reader == "stderr unread" else err,
        ) as process,
    ):
        while process.poll() is None and schedule(process.pid)[0] < after:
            time.sleep(0.0005)
        sent = process.poll() is None
        began, idle = time.monotonic(), schedule(process.pid)[1]
        if sent:
            process.send_signal(number)
        waited, busy = time.monotonic() - began, 0.0
        while process.poll() is None and waited < LIMIT:
            busy = max(busy, schedule(process.pid)[1] - idle)
            time.sleep(0.001)
            waited = time.monotonic() - began
        process.kill()
    out_, err_ = ((folder / name).read_bytes() for name in ("out", "err"))
    return End(process.returncode, waited - busy, out_, err_, folder / "record", sent)


def judge(end: End, reader: str) -> str:
    """Note the faults of an end, and return its kind: before main, over or heard."""
    if not end.sent:
        return "over"
    told = b"Traceback" in end.err or b"ignored" in end.err
    if end.code < 0 or (end.code == 1 and not end.record.exists()):  # Python's own answer before there is ours
        if b"_carried_out" in end.err or end.record.exists():
            end.wrong.add("exit")
        return "before main"
    found = result_of(end)
    given = found if reader in SILENT else printed(end)
    over = end.code == 0 and (given or {}).get("status") == "SUCCESS"
    wrong = {
        "traceback": told,
        "hang": end.waited > PROMPT,
        "exit": end.code != 130 and not over,
        "json": reader not in SILENT and (given or {}).get("status") != "INTERRUPTED" and not over,
        "record": end.record.exists() and (found is None or not agrees(given or found, found)),
        "moving": bool(moving(end.record)),
    }
    end.wrong |= {name for name, is_so in wrong.items() if is_so}
    return "over" if over else "heard"


def printed(end: End) -> dict[str, str] | None:
    """Return the JSON that was printed."""
    try:
        document = json.loads(end.out)
    except ValueError:
        return None
    return document if isinstance(document, dict) else None


def agrees(given: dict[str, str], kept: dict[str, str]) -> bool:
    """Whether the printed result agrees with the record; a closed record keeps how the task ended before the signal."""
    after = f"came after the task had ended with {kept['status']}"
    return given["status"] == kept["status"] or after in given["reason"]


def result_of(end: End) -> dict[str, str] | None:
    """Return the result in the record."""
    try:
        document: dict[str, str] = json.loads((end.record / "result.json").read_text())
    except (OSError, ValueError):
        return None
    return document


def moving(record: Path) -> set[str]:
    """Return the devices that a record leaves moving."""
    found: set[str] = set()
    path = record / "events.jsonl"
    for line in path.read_text().splitlines() if path.exists() else []:
        event = json.loads(line)
        if event["type"] == "command":
            (found.discard if event["name"] == "stop" else found.add)(event["device"])
        elif event["type"] == "motion" and event["state"] != "moving":
            found.discard(event["device"])
    return found


def whole(folder: Path, devices: str) -> float:
    """Return the processor time of the main thread in a whole run, s; the first compiles what is not compiled yet."""
    for name in ("compiling", "measured"):
        end = run(folder / f"{devices}_{name}", devices, "stderr read", 1e9, signal.SIGINT)
        assert end.code == 0, end.err.decode()
    timed = made(folder / f"{devices}_timed")
    with subprocess.Popen(command(devices, "stdout closed"), cwd=timed, stderr=subprocess.DEVNULL) as process:
        ran = 0.0
        while process.poll() is None:
            ran = max(ran, schedule(process.pid)[0])
            time.sleep(0.001)
    return ran


def made(folder: Path) -> Path:
    """Return a folder, made."""
    folder.mkdir()
    return folder


def main() -> None:
    """Send the signals and print the table."""
    options = argparse.ArgumentParser()
    options.add_argument("signals", type=int, nargs="?", default=500)
    options.add_argument("--seed", type=int, default=0)
    options.add_argument("--at-once", type=int, default=1, help="processes that run beside each other")
    given = options.parse_args()
    for number in (signal.SIGINT, signal.SIGTERM):  # a shell may have them ignored, which processes inherit
        signal.signal(number, signal.default_int_handler)
    draw = random.Random(given.seed)
    with tempfile.TemporaryDirectory() as name, ThreadPoolExecutor(given.at_once) as pool:
        folder = Path(name)
        (folder / "tree.yaml").write_text(TREE)
        (folder / "mocks.yaml").write_text(MOCKS)
        times = {devices: whole(folder, devices) for devices in DEVICES}
        print(", ".join(f"a whole run on {name} takes {1e3 * t:.0f} ms of CPU" for name, t in times.items()))
        jobs: list[Job] = []
        for count in range(given.signals):
            case = DEVICES[count % 2], READERS[count // 2 % len(READERS)]
            number = (signal.SIGINT, signal.SIGTERM)[count // (2 * len(READERS)) % 2]
            after = draw.uniform(0.0, times[case[0]])
            jobs.append((case, number, after, pool.submit(run, folder / str(count), *case, after, number)))
        report(jobs)


def report(jobs: list[Job]) -> None:
    """Print what was wrong one by one, then a row for each case; Ctrl-C leaves out what has not begun."""
    counts: dict[tuple[str, str], Counter[str]] = {}
    slowest: dict[tuple[str, str], float] = {}
    for case, number, after, job in jobs:
        try:
            end = job.result()
        except KeyboardInterrupt:
            for rest in jobs:
                rest[3].cancel()
            break
        row = counts.setdefault(case, Counter())
        kind = judge(end, case[1])
        row.update(["sent", kind, *end.wrong])
        if kind == "heard":
            slowest[case] = max(slowest.get(case, 0.0), end.waited)
        if end.wrong:
            told = (
                f"{case}, {number.name} after {after:.3f} s: {sorted(end.wrong)}, exit {end.code}, {end.waited:.2f} s"
            )
            print(f"{told}: {end.err.decode(errors='replace').strip()[-300:]}", flush=True)
    columns = ("sent", "before main", "over", "heard", *WRONG)
    print(f"{'devices':8}{'reader':15}" + "".join(f"{name:>12}" for name in columns) + f"{'slowest, s':>12}")
    for (devices, reader), row in counts.items():
        cells = "".join(f"{row[name]:12d}" for name in columns)
        print(f"{devices:8}{reader:15}{cells}{slowest.get((devices, reader), 0.0):12.2f}")
    total = sum(counts.values(), Counter())
    print(
        f"{'all':23}"
        + "".join(f"{total[name]:12d}" for name in columns)
        + f"{max(slowest.values(), default=0.0):12.2f}"
    )


if __name__ == "__main__":
    main()
