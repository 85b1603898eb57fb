"""Every implementation of a device, by interface and name; imported when a cell file names it."""

from __future__ import annotations

from importlib import import_module

from stretch_bt.hardware.driver import Driver

__all__ = ["IMPLEMENTATIONS", "driver_class", "names_for"]

IMPLEMENTATIONS: dict[tuple[str, str], str] = {
    ("Arm", "simulated"): "stretch_bt.hardware.simulated.arm:SimulatedArm",
    ("Arm", "replay"): "stretch_bt.hardware.replay.arm:ReplayArm",
    ("Arm", "ur"): "stretch_bt.hardware.ur.arm:UrArm",
    ("Gripper", "simulated"): "stretch_bt.hardware.simulated.gripper:SimulatedGripper",
    ("Gripper", "robotiq"): "stretch_bt.hardware.robotiq.gripper:RobotiqGripper",
    ("Gripper", "robotiq_urcap"): "stretch_bt.hardware.robotiq.urcap_gripper:RobotiqUrcapGripper",
    ("DepthCamera", "simulated"): "stretch_bt.hardware.simulated.camera:SimulatedCamera",
    ("DepthCamera", "replay"): "stretch_bt.hardware.replay.camera:ReplayCamera",
    ("DepthCamera", "realsense"): "stretch_bt.hardware.realsense.camera:RealsenseCamera",
    ("ForceSensor", "simulated"): "stretch_bt.hardware.simulated.force_sensor:SimulatedForceSensor",
    ("ForceSensor", "replay"): "stretch_bt.hardware.replay.force_sensor:ReplayForceSensor",
    ("ForceSensor", "ati"): "stretch_bt.hardware.ati.force_sensor:AtiForceSensor",
    ("Operator", "simulated"): "stretch_bt.hardware.simulated.operator:SimulatedOperator",
    ("Operator", "console"): "stretch_bt.hardware.console.operator:ConsoleOperator",
}


def names_for(interface: str) -> list[str]:
    """Return the names that `use` can take for an interface."""
    return [use for kind, use in IMPLEMENTATIONS if kind == interface]


def driver_class(interface: str, use: str) -> type[Driver]:
    """Return the driver behind a name."""
    module, _, name = IMPLEMENTATIONS[interface, use].partition(":")
    found: type[Driver] = getattr(import_module(module), name)
    return found
