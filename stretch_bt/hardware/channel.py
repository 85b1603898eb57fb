"""Messages between a driver and its process: one JSON object a line over a pair of sockets."""

from __future__ import annotations

import json
import select
import socket
import time
from typing import Any

__all__ = ["Channel", "ChannelClosed", "Message"]

Message = dict[str, Any]

_LONGEST = 1 << 20
_PART = 1 << 16


class ChannelClosed(OSError):
    """The other side is gone, does not read, or sends what is no message."""


class Channel:
    """One end; a message that the other side does not take within `patience` s counts as its end."""

    def __init__(self, end: socket.socket, patience: float = 0.5) -> None:
        self._end, self._patience = end, patience
        self._end.setblocking(False)
        self._rest = b""

    def fileno(self) -> int:
        """Return what `select` waits for."""
        return self._end.fileno()

    def send(self, message: Message) -> None:
        """Send a message; raises ChannelClosed."""
        data = json.dumps(message, allow_nan=False).encode() + b"\n"
        due = time.monotonic() + self._patience
        while data:
            try:
                data = data[self._end.send(data) :]
            except BlockingIOError:
                if not select.select([], [self._end], [], max(due - time.monotonic(), 0.0))[1]:
                    raise ChannelClosed("it takes no messages") from None
            except OSError as error:
                raise ChannelClosed(f"the other side is gone ({error})") from error

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
                    return messages  # the end is told next time
                raise ChannelClosed(f"the other side is gone ({error})") from error
            if not data:
                if messages:
                    return messages
                raise ChannelClosed("the other side is gone")
            *lines, self._rest = (self._rest + data).split(b"\n")
            if len(self._rest) > _LONGEST:
                raise ChannelClosed("a message without an end")
            messages += [_decode(line) for line in lines]

    def close(self) -> None:
        """Close this end; may be called more than once."""
        self._end.close()


def _decode(line: bytes) -> Message:
    try:
        message = json.loads(line)
    except (ValueError, RecursionError) as error:
        raise ChannelClosed(f"no message: {line[:40]!r}") from error
    if not isinstance(message, dict):
        raise ChannelClosed(f"no message: {line[:40]!r}")
    return message
