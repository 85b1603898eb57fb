"""Using the devices of a cell from a command, so that they are closed whatever signals come."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from stretch_bt.hardware.cell import Cell
from stretch_bt.runtime.pending_finally import raise_besides
from stretch_bt.runtime.signals import First, signals

__all__ = ["use_cell"]

_Result = TypeVar("_Result")


def use_cell(opening: Callable[[], Cell], use: Callable[[Cell], _Result]) -> _Result:
    """Open a cell, use it, close it, and return what the use returned.

    The first signal breaks off the opening or the use with KeyboardInterrupt; none breaks off the closing. What breaks in closing, as
    a device that cannot be stopped, is raised: a fault of a device before what else was on its way, but for a signal, which notes it.
    """
    cell, first, raised = None, First(), list[BaseException]()
    with signals(first):
        try:
            cell = opening()
            return use(cell)
        except BaseException as error:
            raised.append(error)
            raise
        finally:
            first.breaks = False  # without a call: before one the interpreter looks at signals
            raise_besides(raised, [] if cell is None else cell.close())
