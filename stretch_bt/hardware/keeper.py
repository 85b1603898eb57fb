"""The side of a driver's process: begun by its driver, ended with it, however that ends."""

from __future__ import annotations

import ctypes
import os
import signal
import socket
import sys
from collections.abc import Callable
from contextlib import suppress
from typing import NoReturn, Protocol

from stretch_bt.errors import writable
from stretch_bt.hardware.channel import Channel, ChannelClosed
from stretch_bt.hardware.messages import Codec, Lost, Message
from stretch_bt.hardware.priority import raise_priority

__all__ = ["Keeper", "keep"]

_SET_DEATH_SIGNAL = 1


class Keeper(Protocol):
    """Keeps one device."""

    def run(self) -> None:
        """Go on until the driver is gone, which raises ChannelClosed, or the device is lost."""

    def end(self, *, lost: bool) -> None:
        """Leave the device, after `run`; `lost` is whether the device is the reason."""


def keep(
    descriptor: int, codec: Codec, make: Callable[[Channel, list[Message]], Keeper], *, opening: float, package: str
) -> NoReturn:
    """Keep a device for the driver at the other end of a socket; ends without the destructors of clients, which may hang or abort.

    Parameters
    ----------
    descriptor
        Number of the socket.
    codec
        Codec of the messages of both directions.
    make
        Returns the keeper, connected, from the channel and the first messages.
    opening
        How long that may take before an alarm ends the process, s.
    package
        What is missing where an import fails, and how it is installed; `{}` stands for the reason.
    """
    channel = Channel(socket.socket(fileno=descriptor), codec)
    _wake_with_parent()
    raise_priority()  # it does little, and what it watches does not wait
    keeper, lost = None, False
    try:
        signal.setitimer(signal.ITIMER_REAL, opening)
        keeper = make(channel, channel.first())
        keeper.run()
    except ChannelClosed:
        pass  # asked to end, or nobody is there any more
    except BaseException as error:
        lost = True
        _tell(channel, error, package)
    finally:
        if keeper is not None:
            with suppress(Exception):
                keeper.end(lost=lost)
        sys.stderr.flush()
        os._exit(0)


def _wake_with_parent() -> None:
    """Have Linux continue this process when its driver's thread ends: one that was stopped then sees that the channel is closed, and ends."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_SET_DEATH_SIGNAL, signal.SIGCONT)


def _tell(channel: Channel, error: BaseException, package: str) -> None:
    reason = " ".join(writable(error).split()) or type(error).__name__
    missing = isinstance(error, ImportError)
    with suppress(ChannelClosed):
        channel.send(Lost(package.format(reason) if missing else reason, missing))
