"""Devices that a command opens are closed, at whatever instant a signal comes."""

import os
import signal
import sys
import threading
from contextlib import nullcontext

import pytest

from stretch_bt.errors import DeviceFault, DeviceLost, StretchError
from stretch_bt.runtime.signals import signals, unbroken
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
        return []


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


LOST = DeviceLost("gripper", "the fingers may go on")


class Broken(Opened):
    """A cell with a device that cannot be stopped."""

    def close(self):
        return [StretchError("a file is full"), LOST]


@pytest.mark.parametrize(
    ("ends", "kind"),
    [
        (None, DeviceLost),
        (StretchError("too old"), DeviceLost),
        (DeviceFault("arm", "protective stop"), DeviceFault),
        (KeyboardInterrupt("SIGINT"), KeyboardInterrupt),
    ],
)
def test_what_breaks_in_closing_is_told(ends, kind):
    def use(_):
        if ends is not None:
            raise ends

    with pytest.raises(kind) as raised:
        use_cell(Broken().opening, use)
    said = [str(raised.value), *raised.value.__notes__]
    assert any("the fingers may go on" in text for text in said)
    assert any("a file is full" in text for text in said)


def test_another_thread_hears_and_passes_on_no_signal():
    """It passed on again what an earlier run had been stopped by."""
    with pytest.raises(KeyboardInterrupt), signals(raised):
        signal.raise_signal(signal.SIGINT)
    done = []

    def stopped():
        with unbroken():
            done.append("stopped")

    thread = threading.Thread(target=stopped)
    thread.start()
    thread.join()
    assert done == ["stopped"]


@pytest.mark.parametrize("outer", [True, False])
def test_a_signal_in_what_is_not_broken_off_is_passed_on_after_it(outer):
    done = []

    def stopped():
        with unbroken():
            signal.raise_signal(signal.SIGINT)
            signal.raise_signal(signal.SIGINT)
            done.append("stopped")

    with pytest.raises(KeyboardInterrupt), nullcontext() if outer else signals(raised):
        stopped()
    assert done == ["stopped"]
