"""Calibrating the hand from a table of measured forces."""

from contextlib import suppress

from stretch_bt import model as mechanics
from stretch_bt.behaviors.protocol_records import Table
from stretch_bt.errors import IllConditioned, InvalidInput, UnsetKey
from stretch_bt.model.calibration.characterization import PressRow, as_table, read_table
from stretch_bt.model.calibration.characterization import Table as Presses
from stretch_bt.model.force.force_model import FITTED_FILE
from stretch_bt.tree.ports import Behavior, In, Out, Status
from stretch_bt.tree.registry import node


@node
class FitCalibration(Behavior):
    """Fit a force model to a table of measured forces; FAILURE when they do not determine it.

    Nodes use it where their `model` is `fitted`; the record keeps it as `calibration.json`.
    """

    kind = "model"
    instant = True
    table: In[str] = ""  # a CSV file; without it the node takes `measured`
    measured: In[Table | None] = None  # the table of this run, by `plan_protocol`
    fit: In[str] = "membrane"  # model to fit: `membrane`, `paper` or `sheet`
    fitted: Out[mechanics.ForceModel]  # the model
    residual: Out[float]  # relative standard deviation of the model's residual
    presses: Out[int]  # number of presses that it was fitted to

    def prepare(self) -> None:
        """Refuse a model that does not exist, and a file that is no table."""
        with suppress(UnsetKey):  # a key names it, and nothing wrote it yet
            if self.table:
                read_table(self.table)
            self._fit()

    def update(self) -> Status:
        """Fit, and write the model down."""
        table = self._table()
        given = mechanics.Measurements.of(table)
        model = self._fit()(given, {"characterization": dict(table.provenance)})
        self.fitted = model
        if self.context.folder is not None:
            model.save(self.context.folder / FITTED_FILE)
        self.residual, self.presses = model.relative_sd, len(given)
        return Status.SUCCESS

    def _fit(self) -> mechanics.Fit:
        if self.fit not in mechanics.CALIBRATIONS:
            known = ", ".join(mechanics.CALIBRATIONS)
            raise InvalidInput(f"there is no model {self.fit!r} to fit; write one of {known}")
        return mechanics.CALIBRATIONS[self.fit]

    def _table(self) -> Presses:
        if self.table:
            return read_table(self.table)
        if self.measured is None:
            raise IllConditioned("there is no table to fit to; name a file as 'table', or run 'plan_protocol' first")
        content = self.measured.content
        return as_table(content.provenance, list(content.of(PressRow)))
