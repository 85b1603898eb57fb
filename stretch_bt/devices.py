"""The bases and the types for a driver of your own: one class, made known by an entry point or by `imports:` of a cell file.

An entry point of the group `stretch_bt.devices` has the name that `use` takes in a cell file. A driver is constructed from
its options and touches nothing until `open`; ownership, limits, ages of readings and latched faults are added around it.
"""

from stretch_bt.errors import DeviceFault, DeviceLost, NotReady
from stretch_bt.frames import DepthFrame, Intrinsics, Pose, Wrench
from stretch_bt.hardware.driver import (
    ArmDriver,
    DepthCameraDriver,
    ForceSensorDriver,
    GripperDriver,
    Mistake,
    Options,
    Poll,
    missing_file,
)
from stretch_bt.hardware.finding import Finding
from stretch_bt.hardware.interfaces import MotionState, Reading
from stretch_bt.hardware.polled import PolledDriver
from stretch_bt.hardware.wire_thread import Sample, Wire, WireError, WireThread
from stretch_bt.within import Within

__all__ = [
    "ArmDriver",
    "DepthCameraDriver",
    "DepthFrame",
    "DeviceFault",
    "DeviceLost",
    "Finding",
    "ForceSensorDriver",
    "GripperDriver",
    "Intrinsics",
    "Mistake",
    "MotionState",
    "NotReady",
    "Options",
    "Poll",
    "PolledDriver",
    "Pose",
    "Reading",
    "Sample",
    "Wire",
    "WireError",
    "WireThread",
    "Within",
    "Wrench",
    "missing_file",
]
