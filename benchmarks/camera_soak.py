"""A camera that is read for long over librealsense's software device: leaks, frames that are lost, and faults.

Run with `python benchmarks/camera_soak.py [minutes]`. The stand-in is in a process of its own. Every tenth of the time a line: new frames
that were read, the longest that two were apart, the counters, and memory, files and threads of this process and the driver's.
After a fault that nobody injected, which is printed, the camera is opened anew.
"""

from __future__ import annotations

import os
import sys
import time

from arm_soak import weight
from wires import opened

from stretch_bt.errors import DeviceFault
from stretch_bt.hardware.emulators.serve import free_ports, serving_elsewhere
from stretch_bt.hardware.realsense.camera import RealsenseCamera


def part(camera: RealsenseCamera, seconds: float) -> tuple[int, float, int]:
    """Read for some seconds; return how many frames were new, the longest that two were apart, s, and the faults."""
    end = time.monotonic() + seconds
    frames, longest, faults, seen, last = 0, 0.0, 0, 0, time.monotonic()
    while (now := time.monotonic()) < end:
        try:
            reading = camera.frame()
            if reading.sequence != seen:
                frames, longest, seen, last = frames + 1, max(longest, now - last), reading.sequence, now
        except DeviceFault as fault:
            faults += 1
            print(f"  fault: {fault}", flush=True)
            again(camera)
        time.sleep(0.005)
    return frames, longest, faults


def again(camera: RealsenseCamera) -> None:
    """Open the camera anew as soon as that can be done."""
    while True:
        camera.close()
        try:
            camera.open()
        except DeviceFault:
            time.sleep(0.05)
            continue
        return


def main(minutes: float) -> None:
    """Print ten lines."""
    with serving_elsewhere(["realsense"], ports=free_ports(["realsense"])) as servers:
        camera = opened(servers.served, "realsense", "depth", "DepthCamera", "realsense", {})
        assert isinstance(camera, RealsenseCamera)
        for k in range(10):
            frames, longest, faults = part(camera, minutes * 6)
            pids = os.getpid(), camera.process
            own, driver = (weight(pid) if pid is not None else (0.0, 0, 0) for pid in pids)
            print(f"{(k + 1) * minutes / 10:6.1f} min {frames:6d} frames, at most {longest * 1e3:.0f} ms apart, {faults} faults; "
                  f"{camera.counters()}; MB, files, threads here {own[0]:.1f} {own[1]} {own[2]}, "
                  f"in the driver's process {driver[0]:.1f} {driver[1]} {driver[2]}", flush=True)  # fmt: skip
        camera.close()


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 60)
