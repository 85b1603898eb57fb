"""Cost of gripper, force sensor and camera over their wires, on loopback, and how soon a loss is known.

Run with `python -m benchmarks.wires [exchanges]`. The stand-ins are in a process of their own. One exchange is a whole status of the
gripper: one request by Modbus, seven lines by the URCap's socket. CPU is this process's; frames are of 320 x 240 pixels, and their age
counts from the exposure, without the option `latency`.
"""

from __future__ import annotations

import os
import statistics
import sys
import time
from pathlib import Path
from typing import Any

from stretch_bt.errors import DeviceFault
from stretch_bt.hardware.ati.force_sensor import AtiForceSensor
from stretch_bt.hardware.driver import CellContext, Driver
from stretch_bt.hardware.emulators.control import control
from stretch_bt.hardware.emulators.serve import Served, free_ports, serving_elsewhere
from stretch_bt.hardware.hand import Hand
from stretch_bt.hardware.implementations import driver_class
from stretch_bt.hardware.limits import Limits
from stretch_bt.hardware.realsense.camera import RealsenseCamera
from stretch_bt.hardware.robotiq.driver import RobotiqDriver

POINTS = [{"count": 3, "opening": "140 mm"}, {"count": 230, "opening": "0 mm"}]
GRIPPER = {"model": "2f140", "calibration": {"points": POINTS, "source": "the stand-in's own"}}
SENSOR = {"counts_per_newton": 1000000, "counts_per_newton_metre": 1000000, "source": "the stand-in's own"}
# (title, stand-in, wire, use, options)
WIRES: list[tuple[str, str, str, str, dict[str, Any]]] = [
    ("RTU over TCP", "robotiq", "rtu", "robotiq", {}),
    ("Modbus TCP", "robotiq", "tcp", "robotiq", {"framing": "tcp"}),
    ("RTU, pseudo terminal", "robotiq", "serial", "robotiq", {}),
    ("URCap", "urcap", "urcap", "robotiq_urcap", {}),
]


def opened(served: Served, stand_in: str, wire: str, interface: str, use: str, options: dict[str, Any]) -> Driver:
    """Return a driver that is open on a wire."""
    place = served.wires[stand_in][wire]
    host, _, port = place.partition(":")
    where: dict[str, Any] = {"serial": place} if wire == "serial" else {"host": host, "port": int(port)}
    cls = driver_class(interface, use)
    chosen = cls.Options.model_validate({"type": interface, "use": use, **where, **options})
    driver = cls("device", chosen, CellContext(time.monotonic, 0, Path(), Hand(), Limits()))
    driver.open()
    return driver


def exchanges(title: str, driver: RobotiqDriver, count: int) -> None:
    walls, start = [], time.process_time()
    for _ in range(count):
        begin = time.perf_counter()
        driver.status()
        walls.append((time.perf_counter() - begin) * 1e3)
    spent = (time.process_time() - start) / count * 1e3
    walls.sort()
    print(f"{title:22s}{statistics.median(walls):8.2f} ms median{walls[int(count * 0.99)]:8.2f} ms p99"
          f"{walls[-1]:8.1f} ms longest{spent:8.2f} ms CPU")  # fmt: skip


def idle(title: str, driver: Driver, seconds: float = 5.0) -> None:
    start = time.process_time()
    time.sleep(seconds)
    print(f"{title:22s}{(time.process_time() - start) / seconds * 100:8.2f} % of a core, asked by nobody")


def frames(driver: RealsenseCamera, seconds: float = 5.0) -> None:
    """Print how many frames come, how old they are, and what they cost in the process of the library."""
    pid = driver.process
    assert pid is not None
    before, ages, seen = spent(pid), [], 0
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        reading = driver.frame()
        if reading.sequence != seen:
            seen = reading.sequence
            ages.append((time.monotonic() - reading.host_time - driver.options.latency) * 1e3)
        time.sleep(0.001)
    ages.sort()
    print(f"{len(ages) / seconds:8.1f} frames/s{statistics.median(ages):8.1f} ms old when they are read, median"
          f"{ages[int(0.99 * len(ages))]:8.1f} ms p99{(spent(pid) - before) / seconds * 100:8.1f} % of a core for its process")  # fmt: skip


def spent(pid: int) -> float:
    """Return the CPU time of a process, s."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def loss(served: Served, stand_in: str, fault: str, driver: Driver) -> None:
    """Print how long after the begin of a fault a reading says so."""
    assert served.control is not None
    control(served.control, {"do": "inject", "device": stand_in, "fault": fault})
    begin = time.perf_counter()
    while time.perf_counter() < begin + 10:
        try:
            read(driver)
        except DeviceFault as told:
            print(f"{stand_in:10s}{fault:14s}{(time.perf_counter() - begin) * 1e3:8.0f} ms   {told.reason[:70]}")
            break
        time.sleep(0.001)
    control(served.control, {"do": "clear"})
    driver.close()


def read(driver: Driver) -> None:
    """Take a reading."""
    if isinstance(driver, RobotiqDriver):
        driver.opening()
    elif isinstance(driver, AtiForceSensor):
        driver.wrench()
    elif isinstance(driver, RealsenseCamera):
        driver.frame()


def main(count: int) -> None:
    names = ["robotiq", "urcap", "ati", "realsense"]
    with serving_elsewhere(names, control=0, activated=True, ports=free_ports(names)) as servers:
        served = servers.served
        print(f"one status of the gripper, {count} of them")
        for title, stand_in, wire, use, options in WIRES:
            driver = opened(served, stand_in, wire, "Gripper", use, {**GRIPPER, **options})
            assert isinstance(driver, RobotiqDriver)
            exchanges(title, driver, count)
            idle(f"  polled at {driver.options.rate:.0f} Hz", driver)
            driver.close()
        sensor = opened(served, "ati", "rdt", "ForceSensor", "ati", {"calibration": SENSOR})
        assert isinstance(sensor, AtiForceSensor)
        idle("ATI at 125 Hz", sensor)
        print(f"  {sensor.counters()}")
        sensor.close()
        begin = time.perf_counter()
        camera = opened(served, "realsense", "depth", "DepthCamera", "realsense", {})
        assert isinstance(camera, RealsenseCamera)
        print(f"camera at 30 Hz, opened in {time.perf_counter() - begin:.2f} s")
        idle("  asked by nobody", camera)
        frames(camera)
        camera.close()
        print("how soon a loss is known, with the default times")
        for fault in ("drop", "freeze", "crc", "garbage", "deactivate", "code"):
            driver = opened(served, "robotiq", "rtu", "Gripper", "robotiq", GRIPPER)
            assert isinstance(driver, RobotiqDriver)
            loss(served, "robotiq", fault, driver)
        for fault in ("silence", "freeze", "status", "restart"):
            sensor = opened(served, "ati", "rdt", "ForceSensor", "ati", {"calibration": SENSOR})
            assert isinstance(sensor, AtiForceSensor)
            time.sleep(0.5)
            loss(served, "ati", fault, sensor)
        for fault in ("drop", "freeze", "repeat", "clock", "stale", "torn", "dark", "corrupt", "restart", "jump"):
            camera = opened(served, "realsense", "depth", "DepthCamera", "realsense", {})
            time.sleep(0.5)
            loss(served, "realsense", fault, camera)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 500)
