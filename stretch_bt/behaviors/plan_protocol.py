"""The presses that a characterisation or a sensitivity map lacks."""

from collections.abc import Sequence
from contextlib import suppress
from typing import Literal

from stretch_bt.behaviors._motion import MOST_DEPTH, MOST_STRETCH
from stretch_bt.behaviors._table import check_table, open_table
from stretch_bt.behaviors.protocol_records import Left, ProtocolPlan, Table
from stretch_bt.errors import InvalidInput, UnsetKey
from stretch_bt.hardware.indenters import check_indenter
from stretch_bt.hardware.limits import Limits
from stretch_bt.model.calibration.conditioning import Conditioning
from stretch_bt.model.calibration.protocol import Protocol, protocol
from stretch_bt.quantity_text import format_apart
from stretch_bt.tree.ports import Behavior, In, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import KINDS, Length

_ROUNDING = 1e-9


@node
class PlanProtocol(Behavior):
    """List the presses of a protocol that its table lacks, and open the table.

    Indenters change most seldom, then stretches, then trials; within a trial depths rise, because the membrane is softer up to
    where it has been before. To continue a table that an earlier run began, name it in `table`. It must be of the same hand,
    scene, cell and protocol, and its membrane conditioned alike. The record keeps a copy.
    """

    kind = "model"
    instant = True
    protocol: In[Literal["tasks", "paper", "sensitivity"]] = port(
        "tasks", doc="protocol of presses; the last is of flat cylinders alone"
    )
    table: In[str] = ""  # a CSV file, relative to the working folder; without it a new one in the record of the run
    diameters: In[Sequence[Length]] = ()  # diameters of spheres and cylinders, in place of the protocol's
    stretches: In[Sequence[Length]] = ()  # stretches in place of the protocol's
    depths: In[Sequence[Length]] = ()  # depths in place of the protocol's
    condition: In[bool] = False  # whether the tree first presses each indenter to max_depth at max_stretch
    trials: In[int] = port(0, min=0, max=1000, doc="trials at each stretch of an indenter; 0 for the protocol's number")
    plan: Out[ProtocolPlan]  # all presses
    measured: Out[Table]  # presses that the table holds
    left: Out[Left]  # presses that it lacks

    def prepare(self) -> None:
        """Refuse, where they are known already, values that make no protocol or lie past a limit, and a table that cannot be continued."""
        with suppress(UnsetKey):
            wanted = self._wanted()
            _check_within(wanted, self.context.limits)
            if self.table:
                check_table(self.context, self.table, self.protocol, self._conditioning(wanted))

    def update(self) -> Status:
        """Open the table, and list the presses that it lacks."""
        wanted = self._wanted()
        table = open_table(self.context, self.table, self.protocol, self._conditioning(wanted))
        self.plan = ProtocolPlan.of(self.protocol, wanted)
        self.measured, self.left = Table(len(table.presses), table), Left.of(wanted, table.presses)
        return Status.SUCCESS

    def _conditioning(self, wanted: Protocol) -> Conditioning:
        return Conditioning(wanted.stretches[-1], wanted.depths[-1]) if self.condition else Conditioning()

    def _wanted(self) -> Protocol:
        return protocol(
            self.protocol, diameters=self.diameters, stretches=self.stretches, depths=self.depths, trials=self.trials
        )


def _check_within(wanted: Protocol, limits: Limits | None) -> None:
    """Raise InvalidInput, with the limit, for a press that no run can reach."""
    least, most, deepest = 0.0, MOST_STRETCH, MOST_DEPTH
    if limits is not None:
        least, most = max(limits.stretch.min, least), min(limits.stretch.max, most)
        deepest = min(limits.depth, deepest)
    for name, values, low, high in (
        ("stretches", wanted.stretches, least, most),
        ("depths", wanted.depths, 0.0, deepest),
    ):
        beyond = [v for v in values if not low - _ROUNDING <= v <= high + _ROUNDING]
        if beyond:
            asked, lowest, highest = format_apart(KINDS["Length"], beyond[-1], low, high)
            raise InvalidInput(f"{name}: {asked} is past the limits of the hand; use {lowest} to {highest}")
    for geometry, size in wanted.indenters():
        try:
            check_indenter(geometry, size)
        except InvalidInput as error:
            raise InvalidInput(f"diameters: {error}") from None
