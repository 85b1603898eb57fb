"""Where the command begins and ends: signals are taken before anything else is imported."""

from __future__ import annotations

import os
import sys
from typing import Any, NoReturn

from stretch_bt.cli.stops import EXIT_INTERRUPTED, stops
from stretch_bt.run.signals import signals

__all__ = ["main", "program"]


def main() -> None:
    """Run the command line; ends with SystemExit."""
    with signals(stops):
        stops.begin(process=False)
        sys.exit(_code())


def program() -> NoReturn:
    """Run the command line as a process of its own: from here to its exit every signal has its answer.

    It ends before the interpreter takes itself apart, when signals have none.
    """
    with signals(stops):
        stops.begin(process=True)
        sys.unraisablehook = _unraisable
        code = _code()
        import atexit

        atexit._run_exitfuncs()
        os._exit(code)


def _code() -> int:
    """Carry the command out, give what it printed to its readers, and return its exit code."""
    from stretch_bt.cli.outlet import Outlets

    outlets = Outlets()
    try:
        code = _carried_out()
    finally:
        stops.note()
        lost = outlets.close(lambda: bool(stops.names))
    if lost is not None:
        stops.say(f"error: cannot write to standard output: {lost.strerror}\n")
        return code or 2  # an exit that says more than that comes first
    return code


def _carried_out() -> int:
    try:
        from stretch_bt.cli.app import carry_out

        carry_out()
    except KeyboardInterrupt:
        if "--json" in sys.argv and not stops.told:
            sys.stdout.write(stops.document())
        return EXIT_INTERRUPTED
    except SystemExit as end:
        if isinstance(end.code, str):
            sys.stderr.write(end.code + "\n")
        return end.code if isinstance(end.code, int) else int(end.code is not None)
    except BaseException:  # a defect of ours
        sys.excepthook(*sys.exc_info())
        return 1
    return 0


def _unraisable(told: Any) -> None:
    """Say nothing of a signal that came where Python can raise nothing; it is noted, and the command ends by that."""
    if told.exc_type is not KeyboardInterrupt:
        sys.__unraisablehook__(told)
