"""Waiting for what comes over a wire, for as long as a busy machine may take."""

import time
from contextlib import suppress

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
