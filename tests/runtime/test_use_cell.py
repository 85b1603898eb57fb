"""Devices that a command opens are closed, at whatever instant a signal comes."""

import os
import signal
import sys

import pytest

from stretch_bt.runtime.signals import signals
from stretch_bt.runtime.use_cell import use_cell

#: whose instants are tried: those at which the interpreter looks at signals
FILES = (__file__, "signals.py", "contextlib.py", "use_cell.py")


class Opened:
    """A cell that counts how often it is open."""

    def __init__(self):
        self.open = 0

    def opening(self):
        self.open += 1
        return self

    def close(self):
        self.open -= 1


def raised(name):
    raise KeyboardInterrupt(name)


def used(cell, first, second):
    """Use a cell under two signals, each at an instant, and return how many instants there are."""
    seen = 0

    def profile(frame, event, _):
        nonlocal seen
        if event in ("call", "c_return") and frame.f_code.co_filename.endswith(FILES):
            seen += 1
            if seen in (first, second):
                os.kill(os.getpid(), signal.SIGINT)

    with signals(raised):
        sys.setprofile(profile)
        try:
            use_cell(cell.opening, lambda _: max(1, 2))
        except KeyboardInterrupt:
            assert first
        finally:
            sys.setprofile(None)
    return seen


@pytest.mark.parametrize("behind", [0, 1, 2, 3])
def test_a_signal_at_any_instant_leaves_no_device_open(behind):
    instants = used(Opened(), 0, 0)
    assert instants > 10
    for first in range(1, instants - 1):
        cell = Opened()
        used(cell, first, first + behind)
        assert cell.open == 0, first
