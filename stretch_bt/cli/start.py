"""Where the command begins and ends: signals are taken before anything else is imported."""

from __future__ import annotations

import gc
import os
import sys

from stretch_bt.cli.stops import EXIT_INTERRUPTED, stops
from stretch_bt.forked import alone
from stretch_bt.runtime.signals import came, signals

TYPE_CHECKING = False  # see stretch_bt/__init__.py
if TYPE_CHECKING:
    from typing import Any, NoReturn

    from stretch_bt.cli.outlet import Outlets

__all__ = ["main", "program"]

#: allocations after which the garbage collector looks at young objects, and how many such looks pass before it looks at older ones. By Python's
#: own numbers that takes a tenth of a command's time, mostly over classes and functions, which stay.
COLLECTED = (50_000, 20, 20)


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
        gc.set_threshold(*COLLECTED)
        sys.unraisablehook = _unraisable
        code = _code()
        import atexit

        atexit._run_exitfuncs()
        os._exit(code)


def _code() -> int:
    """Carry the command out, give what it printed to its readers, and return its exit code."""
    from stretch_bt.cli.outlet import Outlets

    outlets = Outlets()
    with alone():
        code = _carried_out(outlets)
    lost = outlets.close(lambda: bool(came))  # a run takes those that come in it
    if lost is None:
        return code
    stops.say(f"error: cannot write to standard output: {lost.strerror}\n")
    # a run ended as its task did, and its record says how; any other command gave no answer
    return code if sys.argv[1:2] == ["run"] else code or 1


def _carried_out(outlets: Outlets) -> int:
    """Carry the command out and return its exit code; from the end of it on a signal is only noted."""
    try:
        from stretch_bt.cli.app import carry_out

        carry_out()
    except KeyboardInterrupt:
        stops.way = "note"
        code = EXIT_INTERRUPTED
        if sys.argv[1:2] != ["run"]:  # whose result says so
            stops.say(f"stopped by {stops.name}\n")
    except SystemExit as end:
        stops.way = "note"
        code = end.code if isinstance(end.code, int) else int(end.code is not None)
        if isinstance(end.code, str):
            sys.stderr.write(end.code + "\n")
    except BaseException:  # a defect of ours
        stops.way = "note"
        code = 1
        sys.__excepthook__(*sys.exc_info())
    else:
        stops.way = "note"
        code = 0
    if "--json" in sys.argv and code and not stops.told:
        outlets.answer.write(stops.document() if code == EXIT_INTERRUPTED else stops.refusal(code))
    return code


def _unraisable(told: Any) -> None:
    """Say nothing of a signal that came where Python can raise nothing; it is noted, and the command ends by that."""
    if told.exc_type is not KeyboardInterrupt:
        sys.__unraisablehook__(told)
