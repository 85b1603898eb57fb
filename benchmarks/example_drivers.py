"""How often the example drivers pass the contract of devices: python benchmarks/example_drivers.py 20 [--busy 1].

Both packages must be installed: pip install examples/modbus_gripper examples/ros_bag_camera
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

__all__ = ["main"]

EXAMPLES = Path(__file__).parents[1] / "examples"
PACKAGES = ("modbus_gripper", "ros_bag_camera")


def main() -> None:
    """Run the tests of both packages again and again, and print how often all passed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("times", type=int)
    parser.add_argument("--busy", type=int, default=0, help="so many processes that only compute take cores meanwhile")
    asked = parser.parse_args()
    load = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(asked.busy)]
    try:
        for package in PACKAGES:
            _repeat(package, asked.times, asked.busy)
    finally:
        for process in load:
            process.kill()


def _repeat(package: str, times: int, busy: int) -> None:
    passed, begun = 0, time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(times):
            done = run(package, Path(folder))
            passed += done.returncode == 0
            if done.returncode:
                print(done.stdout, done.stderr)
    seconds = (time.monotonic() - begun) / times
    print(
        f"{package}: {passed} of {times} passed with {busy} cores of {os.cpu_count()} taken, {seconds:.0f} s each",
        flush=True,
    )


def run(package: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run the contract of a package as its author would, in a process of its own."""
    tests = EXAMPLES / package / "tests" / "test_contract.py"
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-q",
        "-p",
        "no:cacheprovider",
        "--rootdir",
        str(tests.parent),
        "-c",
        os.devnull,
        str(tests),
    ]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


if __name__ == "__main__":
    main()
