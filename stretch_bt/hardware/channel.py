"""Messages between a driver and its process: one a line over a pair of sockets."""

from __future__ import annotations

import select
import socket
import threading
import time

from stretch_bt.hardware.messages import Codec, Message

__all__ = ["Channel", "ChannelClosed", "OtherSideGone"]

_LONGEST = 1 << 20
_PART = 1 << 16


class ChannelClosed(OSError):
    """The other side is gone, does not read, or sends what is no message."""


class OtherSideGone(ChannelClosed):
    """The other side is gone."""


class Channel:
    """One end, which any thread may send by.

    Parameters
    ----------
    end
        A socket of a pair.
    codec
        Codec of the messages of both directions.
    patience
        A message that the other side does not take within this time, s, counts as its end.
    """

    def __init__(self, end: socket.socket, codec: Codec, patience: float = 0.5) -> None:
        self._end, self._codec, self._patience = end, codec, patience
        self._end.setblocking(False)
        self._sending = threading.Lock()
        self._rest = b""

    def fileno(self) -> int:
        """Return what `select` waits for."""
        return self._end.fileno()

    def send(self, message: Message) -> None:
        """Send a message; raises ChannelClosed."""
        data = self._codec.encode(message) + b"\n"
        due = time.monotonic() + self._patience
        with self._sending:
            while data:
                data = data[self._send(data, due) :]

    def _send(self, data: bytes, due: float) -> int:
        try:
            return self._end.send(data)
        except BlockingIOError:
            if not select.select([], [self._end], [], max(due - time.monotonic(), 0.0))[1]:
                raise ChannelClosed("it takes no messages") from None
            return 0
        except OSError as error:
            raise OtherSideGone(f"the other side is gone ({error})") from error

    def first(self) -> list[Message]:
        """Wait for messages, and return those that have come; raises ChannelClosed when there will be none."""
        while not (messages := self.drain()):
            select.select([self._end], [], [])
        return messages

    def drain(self) -> list[Message]:
        """Return the messages that have come, without waiting; raises ChannelClosed when there will be no more."""
        messages: list[Message] = []
        while True:
            try:
                data = self._end.recv(_PART)
            except BlockingIOError:
                return messages
            except OSError as error:
                if messages:
                    return messages  # the end is reported next time
                raise OtherSideGone(f"the other side is gone ({error})") from error
            if not data:
                if messages:
                    return messages
                raise OtherSideGone("the other side is gone")
            *lines, self._rest = (self._rest + data).split(b"\n")
            if len(self._rest) > _LONGEST:
                raise ChannelClosed("a message without an end")
            messages += [self._decode(line) for line in lines]

    def close(self) -> None:
        """Close this end; may be called more than once."""
        self._end.close()

    def _decode(self, line: bytes) -> Message:
        try:
            return self._codec.decode(line)
        except ValueError as error:
            raise ChannelClosed(str(error)) from error
