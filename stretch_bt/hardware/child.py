"""A process of our own that keeps one device, because the device's client hangs or crashes: begun, listened to, ended."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from contextlib import suppress

from stretch_bt.hardware.channel import Channel, ChannelClosed, Message

__all__ = ["Child", "environment"]

_ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


def environment() -> dict[str, str]:
    """Return this process's environment, and what its interpreter finds packages by, so that another one has the same.

    On matrices as small as ours a second thread of BLAS only waits, and takes a core for that.
    """
    return {**os.environ, **_ONE_THREAD, "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)}


class Child:
    """A module run as a process with a channel to it; the number of the socket is its first argument.

    Parameters
    ----------
    module
        What is run.
    first
        Messages that it is sent at its begin.
    descriptors
        Files that it inherits; their numbers are its next arguments.
    """

    def __init__(self, module: str, first: Sequence[Message], descriptors: Sequence[int] = ()) -> None:
        ours, theirs = socket.socketpair()
        self._said = tempfile.TemporaryFile()  # noqa: SIM115  it is open as long as the process
        with theirs:
            given = (theirs.fileno(), *descriptors)
            self._process = subprocess.Popen(  # noqa: S603  the arguments are our own module
                [sys.executable, "-m", module, *map(str, given)],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=self._said,
                pass_fds=given,
                env=environment(),
                start_new_session=True,  # Ctrl-C is for the run, which ends the process
            )
        self.channel = Channel(ours)
        try:
            for message in first:
                self.channel.send(message)
        except BaseException:
            self.end(0.0)
            raise

    @property
    def pid(self) -> int:
        """Number of the process."""
        return self._process.pid

    @property
    def running(self) -> bool:
        """Whether the process has not ended."""
        return self._process.poll() is None

    def why(self, error: ChannelClosed) -> str:
        """Return why the channel closed: what the process said last, or how it ended."""
        if "gone" not in str(error):
            return str(error)
        with suppress(subprocess.TimeoutExpired):
            code = self._process.wait(1.0)
            if code == -signal.SIGALRM:
                return "the client of the device hangs: no answer from there"
            if code < 0:
                return f"its process was ended by {signal.Signals(-code).name}"
            self._said.seek(0)
            lines = self._said.read().decode("utf-8", "replace").strip().splitlines()
            return lines[-1] if lines else f"its process ended with {code}"
        return str(error)

    def kill(self) -> None:
        """End it without its doing."""
        self._process.kill()

    def end(self, grace: float) -> None:
        """Tell it to end, wait `grace` s for that, and end it; leaves no process."""
        with suppress(ChannelClosed):
            self.channel.send({"do": "end"})
        try:
            self._process.wait(grace)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self.channel.close()
        self._said.close()
