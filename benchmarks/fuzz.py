"""Draw hard inputs for some minutes: `python benchmarks/fuzz.py --minutes 60`, or `make fuzz MINUTES=60`.

Every test of a property runs again and again, each round with another seed, on all cores. It ends at the first round in which
a property breaks, and prints its seed and the smallest input that breaks it.
"""

from __future__ import annotations

import argparse
import secrets
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).parents[1]


def properties() -> list[str]:
    """Return the files of tests that draw their inputs, but for tests of wires and processes."""
    files = sorted(p for p in (ROOT / "tests").rglob("test_*.py") if "import given" in p.read_text("utf-8"))
    found = [p.relative_to(ROOT) for p in files]
    return [str(p) for p in found if p.parts[1] not in ("hardware", "cli")]


def one_round(seed: int, files: list[str]) -> int:
    """Run every property with a seed, and return the exit code of pytest."""
    options = ["-m", "hypothesis", "-n", "auto", "--dist", "worksteal", "-q", "--no-header"]
    drawn = ["--hypothesis-profile", "search", f"--hypothesis-seed={seed}"]
    return subprocess.run([sys.executable, "-m", "pytest", *options, *drawn, *files], cwd=ROOT, check=False).returncode


def main() -> int:
    """Run rounds until the time is over or a property breaks."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=60.0)
    ends = time.monotonic() + 60 * parser.parse_args().minutes
    files, rounds = properties(), 0
    while time.monotonic() < ends:
        seed, rounds = secrets.randbits(32), rounds + 1
        if code := one_round(seed, files):
            print(f"round {rounds}: a property breaks; again by --hypothesis-seed={seed}")
            return code
    print(f"{rounds} rounds of {len(files)} files, no property broken")
    return 0


if __name__ == "__main__":
    sys.exit(main())
