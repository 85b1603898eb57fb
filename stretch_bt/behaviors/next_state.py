"""What is left to measure of a characterisation or a sensitivity map."""

from collections.abc import Sequence
from contextlib import suppress
from typing import Literal

from stretch_bt.behaviors._motion import MOST_DEPTH, MOST_STRETCH
from stretch_bt.behaviors._table import check_table, opened
from stretch_bt.errors import InvalidInput, UnsetKey
from stretch_bt.hardware.indenters import check_indenter
from stretch_bt.model.calibration.conditioning import Conditioning
from stretch_bt.model.calibration.protocol import Protocol, State, missing, protocol
from stretch_bt.tree.ports import Behavior, In, Out, Status, port
from stretch_bt.tree.registry import node
from stretch_bt.units import KINDS, Angle, Length, format_quantity

_ROUNDING = 1e-9


@node
class NextState(Behavior):
    """Find the next press of a protocol that the table does not hold yet; `done` when it holds them all.

    Indenters change most seldom, then stretches, then trials; within a trial depths rise, because the membrane is softer up to
    where it has been before. A table that an earlier run began is gone on with: name it in `table`. It must be of the same hand,
    scene, cell and protocol, and its membrane conditioned alike. The record keeps a copy.
    """

    kind = "model"
    instant = True
    protocol: In[Literal["tasks", "paper", "sensitivity"]] = port(
        "tasks", doc="which presses; the last are of flat cylinders alone"
    )
    table: In[str] = ""  # a CSV file, relative to the working folder; without it a new one in the record of the run
    diameters: In[Sequence[Length]] = ()  # of spheres and cylinders, in place of the protocol's
    stretches: In[Sequence[Length]] = ()  # in place of the protocol's
    depths: In[Sequence[Length]] = ()  # in place of the protocol's
    condition: In[bool] = False  # whether the tree first presses each indenter to max_depth at max_stretch
    trials: In[int] = port(0, min=0, max=1000, doc="of each stretch of an indenter; 0 for as many as the protocol has")
    done: Out[bool]  # whether nothing is left; what follows is then not written
    geometry: Out[str | None]  # sphere, cylinder or cone
    diameter: Out[Length | None]  # of a sphere or cylinder; 0 for a cone
    angle: Out[Angle | None]  # of a cone, between its surface and the membrane plane; else 0
    stretch: Out[Length | None]  # past the rest length
    depth: Out[Length | None]  # of the hand, past first contact
    trial: Out[int | None]  # from 1
    new_indenter: Out[bool | None]  # whether it is another one than at the state before in this run
    new_trial: Out[bool | None]  # whether indenter, stretch or trial is another than at the state before in this run
    max_stretch: Out[Length]  # the largest of the protocol
    max_depth: Out[Length]  # the largest of the protocol
    rows: Out[int]  # that the table holds

    def __init__(self, path: str = "") -> None:
        super().__init__(path)
        self.left: list[State] | None = None  # in reverse
        self.before: State | None = None
        self.known = 0

    def prepare(self) -> None:
        """Refuse, where it is known already, what makes no protocol or lies past a limit, and a table that cannot be gone on with."""
        with suppress(UnsetKey):
            wanted = self._wanted()
            self._check_within(wanted)
            if self.table:
                check_table(self.context, self.table, self.protocol, self._conditioning(wanted))

    def update(self) -> Status:
        """Look what is missing, once; then go on whenever a row was written."""
        wanted = self._wanted()
        table = opened(self.context, self.table, self.protocol, self._conditioning(wanted))
        if self.left is None:
            self.left = missing(wanted, table.presses)[::-1]
        elif len(table.presses) > self.known and self.left:
            self.left.pop()
        self.max_stretch, self.max_depth = wanted.stretches[-1], wanted.depths[-1]
        self.rows = self.known = len(table.presses)
        self.done = not self.left
        if self.left:
            self._tell(self.left[-1])
        return Status.SUCCESS

    def _wanted(self) -> Protocol:
        return protocol(
            self.protocol, diameters=self.diameters, stretches=self.stretches, depths=self.depths, trials=self.trials
        )

    def _conditioning(self, wanted: Protocol) -> Conditioning:
        return Conditioning(wanted.stretches[-1], wanted.depths[-1]) if self.condition else Conditioning()

    def _check_within(self, wanted: Protocol) -> None:
        """Raise InvalidInput, with the limit, for a state that no run can reach."""
        limits, least, most, deepest = self.context.limits, 0.0, MOST_STRETCH, MOST_DEPTH
        if limits is not None:
            least, most = max(limits.stretch.min, least), min(limits.stretch.max, most)
            deepest = min(limits.depth, deepest)
        for name, values, low, high in (
            ("stretches", wanted.stretches, least, most),
            ("depths", wanted.depths, 0.0, deepest),
        ):
            beyond = [v for v in values if not low - _ROUNDING <= v <= high + _ROUNDING]
            if beyond:
                asked, lowest, highest = (format_quantity(v, KINDS["Length"]) for v in (beyond[-1], low, high))
                raise InvalidInput(f"{name}: {asked} is past the limits of the hand; use {lowest} to {highest}")
        for geometry, size in wanted.indenters():
            try:
                check_indenter(geometry, size)
            except InvalidInput as error:
                raise InvalidInput(f"diameters: {error}") from None

    def _tell(self, state: State) -> None:
        before, self.before = self.before, state
        cone = state.geometry == "cone"
        self.geometry = state.geometry
        self.diameter, self.angle = (0.0, state.size) if cone else (state.size, 0.0)
        self.stretch, self.depth, self.trial = state.stretch, state.depth, state.trial
        self.new_indenter = before is None or before.indenter != state.indenter
        self.new_trial = before is None or before.series != state.series
