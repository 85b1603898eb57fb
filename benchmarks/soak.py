"""Arm, gripper, force sensor and camera over their wires for a long time, all at once.

Run with `python benchmarks/soak.py [minutes]`: `arm_soak.py`, `wires_soak.py` and `camera_soak.py` beside each other, each line with the
name of its part. Ends with 1 where one of them broke.
"""

from __future__ import annotations

import subprocess
import sys
import threading
from pathlib import Path

PARTS = ("arm", "wires", "camera")


def soak(part: str, minutes: str, failed: list[str]) -> None:
    """Run one of them, and print what it says."""
    command = [sys.executable, str(Path(__file__).with_name(f"{part}_soak.py")), minutes]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as process:
        assert process.stdout is not None
        for line in process.stdout:
            print(f"{part:7s}{line}", end="", flush=True)
    if process.returncode:
        failed.append(part)


def main(minutes: str) -> int:
    """Run all of them, and return 1 where one broke."""
    failed: list[str] = []
    threads = [threading.Thread(target=soak, args=(part, minutes, failed)) for part in PARTS]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1] if len(sys.argv) > 1 else "60"))
