"""Calibrating the hand from a table of measured forces."""

from contextlib import suppress

from stretch_bt import model as mechanics
from stretch_bt.behaviors._table import is_of_run, table_of
from stretch_bt.errors import InvalidInput, UnsetKey
from stretch_bt.model.calibration.characterization import Table, as_table, read_table
from stretch_bt.model.force.force_model import FITTED, FITTED_FILE
from stretch_bt.tree.ports import Behavior, In, Out, Status
from stretch_bt.tree.registry import node


@node
class FitCalibration(Behavior):
    """Fit a force model to a table of measured forces; FAILURE when they do not determine it.

    Nodes that come later use it by the name `fitted`; the record keeps it as `calibration.json`.
    """

    kind = "model"
    instant = True
    table: In[str] = ""  # a CSV file, or as `next_state` has it; without a name that of this run
    fit: In[str] = "membrane"  # `membrane`, `paper` or `sheet`
    left: Out[float]  # part of a force that the model does not explain
    presses: Out[int]  # that it was fitted to

    def prepare(self) -> None:
        """Refuse a model that does not exist, and a table that is none."""
        with suppress(UnsetKey):  # a key names it, and nothing wrote it yet
            if self.table and not is_of_run(self.context, self.table):
                read_table(self.table)
            self._fit()

    def update(self) -> Status:
        """Fit, and keep the model for the rest of the run."""
        table = self._table()
        given = mechanics.Measurements.of(table)
        model = self._fit()(given, {"characterization": dict(table.provenance)})
        self.context.memory[mechanics.ForceModel, FITTED] = model
        if self.context.folder is not None:
            model.save(self.context.folder / FITTED_FILE)
        self.left, self.presses = model.relative_sd, len(given)
        return Status.SUCCESS

    def _fit(self) -> mechanics.Fit:
        if self.fit not in mechanics.CALIBRATIONS:
            known = ", ".join(mechanics.CALIBRATIONS)
            raise InvalidInput(f"there is no model {self.fit!r} to fit; write one of {known}")
        return mechanics.CALIBRATIONS[self.fit]

    def _table(self) -> Table:
        if self.table and not is_of_run(self.context, self.table):
            return read_table(self.table)
        table = table_of(self.context, self.table)
        return as_table(table.provenance, table.presses)
