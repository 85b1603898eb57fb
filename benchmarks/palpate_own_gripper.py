"""Palpates with the example gripper, on pymodbus's simulator, beside a simulated arm and camera; prints stiffness and truth.

python benchmarks/palpate_own_gripper.py [RUNS] [--busy N]
"""

import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import stretch_bt

EXAMPLE = Path(__file__).parents[1] / "examples" / "modbus_gripper"
CELL = """\
format: stretch-cell/1
imports: {{own: stretch_bt_modbus_gripper.driver}}
devices:
  gripper: {{type: Gripper, use: two_jaw_gripper, host: 127.0.0.1, port: {}}}
  arm: {{type: Arm, use: simulated, height: 120 mm}}
  camera: {{type: DepthCamera, use: simulated}}
"""


def palpate(folder: Path) -> str:
    """Run once, and return a line."""
    from stretch_bt_modbus_gripper.simulator import Simulator  # type: ignore[import-not-found]

    simulator = Simulator()
    (folder / "cell.yaml").write_text(CELL.format(simulator.port), encoding="utf-8")
    began = time.monotonic()
    try:
        result = stretch_bt.run(
            "palpate_stiffness", cell=folder / "cell.yaml", scene="water_balloon", out=folder / "record"
        )
    finally:
        simulator.stop()
    if result.status != "SUCCESS":
        return f"{result.status} {result.reason}"
    found, truth = result.outputs["stiffness"], result.truth["stiffness"]
    told = f"{found['value']:.3f} +- {found['sd']:.3f} N/mm, true {truth['value']:.3f}"
    return f"{told}; {time.monotonic() - began:.0f} s for {result.task_seconds:.0f} s of the task"


def main() -> None:
    """Run as often as asked."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("runs", nargs="?", type=int, default=1)
    parser.add_argument("--busy", type=int, default=0, help="processes that take a core each meanwhile")
    given = parser.parse_args()
    sys.path.insert(0, str(EXAMPLE))
    busy = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(given.busy)]
    try:
        for _ in range(given.runs):
            with tempfile.TemporaryDirectory() as folder:
                print(palpate(Path(folder)))
    finally:
        for process in busy:
            process.kill()


if __name__ == "__main__":
    main()
