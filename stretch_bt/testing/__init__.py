"""For tests of trees and nodes: a scripted device, and the pytest fixtures `cell`, `run`, `scripted_device`, `virtual_clock`."""

from stretch_bt.testing.scripted import ScriptedDevice

__all__ = ["ScriptedDevice"]
