"""Waiting for what comes over a wire, for as long as a busy machine may take."""

import os
import signal
import threading
import time
from contextlib import contextmanager, suppress

import pytest

from stretch_bt.errors import DeviceFault

#: for how long to wait for what is bound to come, s
LIMIT = 20.0


def eventually(ask):
    """Return the answer of `ask` as soon as it has a true one and raises no fault."""
    end = time.monotonic() + LIMIT
    while time.monotonic() < end:
        with suppress(DeviceFault):
            if answer := ask():
                return answer
        time.sleep(0.01)
    raise AssertionError("it does not come")


@contextmanager
def broken_off(ready):
    """Expect of the block that a Ctrl-C ends it, which comes as soon as `ready` has a true answer."""

    def interrupt():
        eventually(ready)
        os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=interrupt)
    thread.start()
    with pytest.raises(KeyboardInterrupt):
        yield
    thread.join()
