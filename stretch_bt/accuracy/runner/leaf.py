"""The leaves of the trees that are ticked: one input and one output port, or none."""

from __future__ import annotations

import py_trees
from py_trees.common import Status
from py_trees.ports import BehaviourWithPorts, PortInformation

from stretch_bt.tree.ports import Behavior, In, Out

__all__ = ["Bare", "BenchmarkLeaf", "Ported"]


class Bare(py_trees.behaviour.Behaviour):
    """A leaf without ports."""

    def update(self) -> Status:
        """Succeed."""
        return Status.SUCCESS


class Ported(BehaviourWithPorts):
    """A leaf with py_trees' own ports."""

    INPUT_PORTS = {"given": PortInformation(data_type=float, required=True)}  # noqa: RUF012
    OUTPUT_PORTS = {"result": PortInformation(data_type=float, required=True)}  # noqa: RUF012

    def update(self) -> Status:
        """Pass it on."""
        self._set_output("result", self.get_input("given"))
        return Status.SUCCESS


class BenchmarkLeaf(Behavior):
    """Write what was read."""

    instant = True
    given: In[float]
    result: Out[float]

    def update(self) -> Status:
        """Pass it on."""
        self.result = self.given
        return Status.SUCCESS
