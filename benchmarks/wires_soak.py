"""Gripper and force sensor over their wires for a long time: memory, threads, times of exchanges, lost records.

Run with `python benchmarks/wires_soak.py [minutes]`. The stand-ins are in a process of their own; the gripper goes to and fro without
end, the sensor is read at 20 Hz. Every tenth of the time a line gives the state; the last line compares begin and end.
"""

from __future__ import annotations

import resource
import sys
import threading
import time

from wires import GRIPPER, SENSOR, opened

from stretch_bt.errors import DeviceFault
from stretch_bt.hardware.ati.force_sensor import AtiForceSensor
from stretch_bt.hardware.emulators.serve import free_ports, serving_elsewhere
from stretch_bt.hardware.interfaces import MotionState
from stretch_bt.hardware.robotiq.driver import RobotiqDriver

ENDS = (0.060, 0.130)
PERIOD = 0.05


def megabytes() -> float:
    """Return the most memory that this process ever had, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def part(gripper: RobotiqDriver, sensor: AtiForceSensor, seconds: float) -> tuple[int, list[float]]:
    """Move and read for some seconds; return how many motions ended at their target, and the times of exchanges, s.

    After a fault, as when this process is suspended for a while, both are opened anew.
    """
    moves, times = 0, []
    poll = gripper.move(ENDS[0], 0.1)
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        try:
            begin = time.perf_counter()
            gripper.status()
            times.append(time.perf_counter() - begin)
            sensor.wrench()
            if poll() is not MotionState.MOVING:
                moves += poll() is MotionState.DONE
                poll = gripper.move(ENDS[moves % 2], 0.1)
        except DeviceFault as fault:
            print(f"  fault: {fault}", flush=True)
            for device in (gripper, sensor):
                device.close()
                device.open()
            poll = gripper.move(ENDS[moves % 2], 0.1)
        time.sleep(PERIOD)
    return moves, sorted(times)


def main(minutes: float) -> None:
    """Print ten lines and a comparison."""
    names = ["robotiq", "ati"]
    with serving_elsewhere(names, activated=True, ports=free_ports(names)) as servers:
        served = servers.served
        gripper = opened(served, "robotiq", "rtu", "Gripper", "robotiq", GRIPPER)
        sensor = opened(served, "ati", "rdt", "ForceSensor", "ati", {"calibration": SENSOR})
        assert isinstance(gripper, RobotiqDriver)
        assert isinstance(sensor, AtiForceSensor)
        found = []
        for k in range(10):
            moves, times = part(gripper, sensor, minutes * 6)
            found.append((megabytes(), times[len(times) // 2]))
            counters = sensor.counters()
            print(f"{(k + 1) * minutes / 10:6.1f} min  {moves:4d} motions  exchange {times[len(times) // 2] * 1e3:.2f} ms median, "
                  f"{times[int(len(times) * 0.99)] * 1e3:.1f} ms p99, {times[-1] * 1e3:.0f} ms longest  {megabytes():.1f} MB  "
                  f"{threading.active_count()} threads  {counters.received} records, {counters.lost} lost", flush=True)  # fmt: skip
        gripper.close()
        sensor.close()
    print(f"memory {found[-1][0] - found[0][0]:+.1f} MB from the first to the last tenth, exchange {(found[-1][1] - found[0][1]) * 1e3:+.2f} ms, "
          f"{threading.active_count()} thread left")  # fmt: skip


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 60)
