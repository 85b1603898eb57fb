"""Force models by name, loaded once."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache

from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.model import ForceModel
from stretch_bt.units import Estimate

__all__ = ["PAPER", "force_model", "inverted", "within_range"]

STEP = 1e-5  # m, over which the slope of a force is taken: far below any length of a press

#: the shipped calibration of the paper's model
PAPER = "paper"


@lru_cache(maxsize=16)
def force_model(name: str) -> ForceModel:
    """Return the shipped model of this name, or the one that a calibration file holds."""
    return ForceModel.default() if name == PAPER else ForceModel.load(name)


def inverted(value: float, predict: Callable[[float], tuple[float, float]]) -> Estimate:
    """Return an inverted value, m, with the standard deviation that the model's own error in force gives it."""
    force, sd = predict(value)
    slope = (predict(value + STEP)[0] - force) / STEP
    return Estimate(value, sd / slope if slope > 0 else 0.0)


@contextmanager
def within_range() -> Iterator[None]:
    """Refuse what a model says lies outside its range: measured values got there, not a mistake in the tree."""
    try:
        yield
    except InvalidInput as error:
        raise IllConditioned(str(error)) from error
