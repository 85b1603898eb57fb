"""Answers of `replay` to a record that another processor made: the same run under settings that change kernels and threads.

Run with `python benchmarks/replay_machines.py [--tree T] [--scene S] [--set PARAMS] [--settings A B ...]`, by default on the tree's
own scene, with the tree's params from JSON. Each
setting runs the tree once in a process of its own, then each replays the records of all. A cell says `identical`, or the largest
difference of a number with `same` or `DIFFERS`; the last column is the largest relative difference of an output from the first setting.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from argparse import ArgumentParser
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

SETTINGS: dict[str, dict[str, str]] = {
    "no setting": {},
    **{f"{n} threads": {"OPENBLAS_NUM_THREADS": str(n)} for n in (1, 2, 4)},
    "Haswell": {"OPENBLAS_CORETYPE": "Haswell"},
    "Nehalem": {"OPENBLAS_CORETYPE": "Nehalem"},
    "numba generic": {"NUMBA_CPU_NAME": "generic"},
    "numpy AVX2 off": {"NPY_DISABLE_CPU_FEATURES": "X86_V4 AVX512_ICL X86_V3"},
}
RUN = """\
import json, sys
from stretch_bt.runtime.task import run
run(sys.argv[1], scene=sys.argv[2] or None, out=sys.argv[3], params=json.loads(sys.argv[4]))
"""
REPLAY = """\
import json, sys
from stretch_bt.runtime.replay import replay
print(json.dumps([replay(record).to_json() for record in sys.argv[1:]]))
"""


def python(setting: str, cache: Path, code: str, *arguments: str) -> str:
    """Return what a piece of Python prints under a setting."""
    own = {"NUMBA_CACHE_DIR": str(cache)} if "NUMBA_CPU_NAME" in SETTINGS[setting] else {}
    command = [sys.executable, "-c", code, *arguments]
    done = subprocess.run(
        command, env={**os.environ, **SETTINGS[setting], **own}, capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise SystemExit(f"{setting}: {done.stderr}")
    return done.stdout


def said(answer: dict[str, Any]) -> str:
    """Return an answer of `replay` in a cell."""
    if answer["identical"]:
        return "identical"
    return f"{'same' if answer['same'] else 'DIFFERS'} {answer['largest_difference']:.0e}"


def outputs(record: Path) -> dict[str, float]:
    """Return the outputs of a record."""
    found = json.loads((record / "result.json").read_text("utf-8"))["outputs"]
    return {name: output["value"] for name, output in found.items() if isinstance(output["value"], int | float)}


def deviation(found: dict[str, float], first: dict[str, float]) -> float:
    """Return the largest relative difference of an output."""
    return max(abs(found[name] - value) / abs(value) for name, value in first.items() if value)


def main() -> int:
    """Print the table; exit 1 where a replay differs."""
    given = ArgumentParser(description=__doc__)
    given.add_argument("--tree", default="palpate_stiffness")
    given.add_argument("--scene", default="")
    given.add_argument("--set", default="{}", dest="params", metavar="PARAMS")
    given.add_argument("--settings", nargs="+", choices=SETTINGS, default=list(SETTINGS))
    options = given.parse_args()
    wrong = 0
    with TemporaryDirectory(prefix="machines-") as place:
        cache, names = Path(place) / "cache", list(options.settings)
        records = {name: Path(place) / name.replace(" ", "_") for name in names}
        for name, record in records.items():
            python(name, cache, RUN, options.tree, options.scene, str(record), options.params)
            print(name, json.loads((record / "run.json").read_text("utf-8"))["machine"]["blas"], flush=True)
        print("".join(f"{text:>17}" for text in ("replayed under", *names, "outputs")))
        for name in names:
            answers = json.loads(python(name, cache, REPLAY, *map(str, records.values())))
            wrong += sum(not answer["same"] for answer in answers)
            change = deviation(outputs(records[name]), outputs(records[names[0]]))
            print("".join(f"{text:>17}" for text in (name, *map(said, answers), f"{change:.0e}")), flush=True)
            for recorded, answer in zip(names, answers, strict=True):
                if not answer["same"]:
                    print(
                        f"recorded under {recorded}: {json.dumps(answer['first_difference'])[:2000]}", file=sys.stderr
                    )
    print(f"{len(names) ** 2} replays, {wrong} not the same")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
