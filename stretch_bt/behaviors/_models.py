"""The common part of nodes that ask a force model: the model by name, loaded once a run and before anything moves."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import ClassVar

from stretch_bt.errors import IllConditioned, InvalidInput, UnsetKey
from stretch_bt.model import ForceModel
from stretch_bt.model.force.force_model import FITTED, PAPER
from stretch_bt.quantity_text import format_apart
from stretch_bt.tree.ports import Behavior, In, port
from stretch_bt.units import KINDS, Estimate

__all__ = ["ModelBehavior", "inverted", "within_range"]

_ROUNDING = 1e-9
STEP = 1e-5  # m, step for the slope of a force: far below any length of a press


class ModelBehavior(Behavior):
    """A node that asks a force model."""

    kind = "model"
    instant: ClassVar[bool] = True
    model: In[str] = port(
        PAPER, doc="shipped model 'paper', 'membrane' or 'sheet', 'fitted', or the path of a calibration file"
    )

    fitted: In[ForceModel | None] = None  # the model that `fit_calibration` fitted

    def prepare(self) -> None:
        """Load the model when its name is known already."""
        try:
            if self.model != FITTED:
                self.force_model()
        except UnsetKey:  # a key names it, and nothing wrote it yet
            return

    def prepare_reach(self, max_stretch: Callable[[], float]) -> None:
        """Refuse a model whose range ends below the largest planned stretch, where both are known already."""
        with suppress(UnsetKey):
            if self.model == FITTED:
                return
            most, planned = self.force_model().range.stretch[1], max_stretch()
            if planned > most + _ROUNDING:
                asked, held = format_apart(KINDS["Length"], planned, most)
                raise InvalidInput(
                    f"max_stretch: {asked} is past {held}, up to which the model {self.model!r} holds; set max_stretch to {held} or less, or "
                    f"calibrate at larger stretches"
                )

    def force_model(self) -> ForceModel:
        """Return the shipped model, or the one that a calibration file holds; each is read once a run."""
        name, memory = self.model, self.context.memory
        if name == FITTED:
            if self.fitted is None:
                raise IllConditioned("no model is fitted yet; run 'fit_calibration' first")
            return self.fitted
        if (ForceModel, name) not in memory:
            memory[ForceModel, name] = ForceModel.load(name)
        model: ForceModel = memory[ForceModel, name]
        return model


def inverted(value: float, predict: Callable[[float], tuple[float, float]]) -> Estimate:
    """Return an inverted value, m, with the standard deviation that the model's own error in force gives it.

    Raises
    ------
    IllConditioned
        The force does not grow with the value there, so the force's error determines no error of the value.
    """
    force, sd = predict(value)
    try:
        slope = (predict(value + STEP)[0] - force) / STEP
    except InvalidInput:  # the value lies at the end of the model's range
        slope = (force - predict(value - STEP)[0]) / STEP
    if not slope > 0:
        raise IllConditioned("the force does not grow there, so the model cannot be inverted")
    return Estimate(value, sd / slope)


@contextmanager
def within_range() -> Iterator[None]:
    """Raise IllConditioned where a model's range is left: measured values left it, not a mistake in the tree."""
    try:
        yield
    except InvalidInput as error:
        raise IllConditioned(str(error)) from error
