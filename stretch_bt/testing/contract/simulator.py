"""What stands in for a device while a clause runs: brought up as the test says, and ended within a bound."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing.process import BaseProcess
from subprocess import Popen, TimeoutExpired
from typing import Any

from stretch_bt.errors import InvalidInput

__all__ = ["brought_up", "call_with"]

#: how long a process has after it was asked to end, before it is killed, s
_ENDING = 5.0


@contextmanager
def brought_up(start: Callable[[], Any] | None) -> Iterator[Any]:
    """Give what `start` brings up, and end it: a process, a context manager, a generator, or what has `stop` or `close`."""
    made: Any = None if start is None else start()
    if isinstance(made, Popen | BaseProcess):
        try:
            yield made
        finally:
            _end(made)
    elif hasattr(made, "__enter__"):
        with made as simulator:
            yield simulator
    elif inspect.isgenerator(made):
        try:
            yield _first(made)
        finally:
            next(made, None)
            made.close()
    else:
        try:
            yield made
        finally:
            ends = [getattr(made, name, None) for name in ("stop", "close")]
            next((end for end in ends if end is not None), lambda: None)()


def _first(made: Iterator[Any]) -> Any:
    """Return what a generator yields."""
    for simulator in made:
        return simulator
    raise InvalidInput("the generator of 'start' yields nothing; yield the simulator once, then end it")


def call_with(function: Callable[..., Any], given: Any) -> None:
    """Call a function of the test, with what it acts on where it takes an argument."""
    if inspect.signature(function).parameters:
        function(given)
    else:
        function()


def _end(process: Popen[Any] | BaseProcess) -> None:
    """Terminate a process, and kill it where it does not end."""
    process.terminate()
    if isinstance(process, BaseProcess):
        process.join(_ENDING)
        process.kill()
        process.join()
        process.close()
        return
    try:
        process.wait(_ENDING)
    except TimeoutExpired:
        process.kill()
    with process:  # waits, and closes its pipes
        pass
