"""A process of our own that keeps one device, because the device's client hangs or crashes: begun, listened to, ended."""

from __future__ import annotations

import signal
import socket
import subprocess
import tempfile
from collections.abc import Sequence
from contextlib import suppress

from stretch_bt.hardware.channel import Channel, ChannelClosed, OtherSideGone
from stretch_bt.hardware.isolated import environment, interpreter
from stretch_bt.hardware.messages import Codec, End, Message

__all__ = ["LAST_WORD", "Child"]

#: first words of the line of standard error in which a process that ends itself at once says why
LAST_WORD = "lost: "
#: how long a process may take to be gone once its channel is closed, s
_GOING = 1.0


class Child:
    """A module run as a process with a channel to it; the number of the socket is its first argument.

    Parameters
    ----------
    module
        What is run; it calls `keep`.
    codec
        Codec of the messages of both directions.
    first
        Messages that it is sent at its begin.
    descriptors
        Files that it inherits; their numbers are its next arguments.
    """

    def __init__(self, module: str, codec: Codec, first: Sequence[Message], descriptors: Sequence[int] = ()) -> None:
        ours, theirs = socket.socketpair()
        self._said = tempfile.TemporaryFile()  # noqa: SIM115  it is open as long as the process
        with theirs:
            given = (theirs.fileno(), *descriptors)
            self._process = subprocess.Popen(  # noqa: S603  the arguments are our own module
                [*interpreter(), "-m", module, *map(str, given)],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=self._said,
                pass_fds=given,
                env=environment(),
                start_new_session=True,  # Ctrl-C is for the run, which ends the process
            )
        self.channel = Channel(ours, codec)
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
        if not isinstance(error, OtherSideGone):
            return str(error)
        with suppress(subprocess.TimeoutExpired):
            code = self._process.wait(_GOING)
            if code == -signal.SIGALRM:
                return "the client of the device hangs: no answer from there"
            if code < 0:
                return f"its process was ended by {signal.Signals(-code).name}"
            return self._last_word() or f"its process ended with {code}"
        return str(error)

    def _last_word(self) -> str:
        """Return why it says that it ended, else its last line."""
        self._said.seek(0)
        lines = self._said.read().decode("utf-8", "replace").strip().splitlines()
        told = [line.removeprefix(LAST_WORD) for line in lines if line.startswith(LAST_WORD)]
        return (told or lines or [""])[-1]

    def kill(self) -> None:
        """End it at once."""
        self._process.kill()

    def end(self, grace: float) -> list[Message]:
        """Ask it to end, wait `grace` s for that, and end it; leaves no process, and returns what it said last."""
        with suppress(ChannelClosed):
            self.channel.send(End())
        try:
            self._process.wait(grace)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        said: list[Message] = []
        with suppress(ChannelClosed):
            said = self.channel.drain()
        self.channel.close()
        self._said.close()
        return said
