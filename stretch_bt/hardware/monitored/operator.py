"""The operator as nodes see it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from stretch_bt.hardware.driver import OperatorDriver
from stretch_bt.hardware.interfaces import Motion, Operator
from stretch_bt.hardware.monitored.mover import Mover

__all__ = ["MonitoredOperator"]


class MonitoredOperator(Mover[OperatorDriver]):
    """A person who is asked for one thing at a time, and for nothing that does not exist."""

    readings: ClassVar[Mapping[str, Any]] = Operator.readings

    def mount(self, geometry: str, size: float, *, owner: str) -> Motion:
        """Mount an indenter; `size` is a diameter, m, and for a cone an angle, rad."""
        arguments = {"geometry": geometry, "size": size}
        self.check_command(owner, arguments)
        self.settle()
        self.command("mount", arguments, owner)
        with self.faults():
            poll = self.driver.mount(geometry, size)
        return self.own(poll, owner)

    def confirm(self, request: str, *, owner: str) -> Motion:
        """Wait until the operator lets the robot go on."""
        self.check_command(owner)
        self.settle()
        self.command("confirm", {"request": request}, owner)
        with self.faults():
            poll = self.driver.confirm(request)
        return self.own(poll, owner)
