"""A stand-in in a process of its own, as whoever began it has it."""

from __future__ import annotations

import select
import threading
import time
from collections.abc import Mapping, Sequence
from typing import Any

from stretch_bt.errors import InvalidInput
from stretch_bt.hardware.channel import ChannelClosed, OtherSideGone
from stretch_bt.hardware.child import Child
from stretch_bt.hardware.emulators.faults import Fault
from stretch_bt.hardware.emulators.messages import STAND_IN, Clear, Describe, Described, Inject, Serve, TwinRefused
from stretch_bt.hardware.emulators.registry import stand_in_class
from stretch_bt.hardware.messages import Codec, Message

__all__ = ["Process", "RemoteStandIn"]

#: how long an answer may take, and a process to end, s
_ANSWER, _END = 10.0, 2.0


class Process:
    """A process that answers each message by one of its own.

    Parameters
    ----------
    name
        Name in messages.
    module
        Module that it runs.
    codec
        Codec of the messages of both directions.
    first
        First message to it.
    descriptors
        File descriptors that it inherits.
    """

    def __init__(self, name: str, module: str, codec: Codec, first: Message, descriptors: Sequence[int]) -> None:
        self.name = name
        self._child = Child(module, codec, [first], descriptors)
        self._asking = threading.Lock()

    def answer(self, within: float = _ANSWER) -> Message:
        """Return the next message; raises InvalidInput with the reason when it refuses, ends, or says nothing within a time, s."""
        due = time.monotonic() + within
        channel = self._child.channel
        try:
            while not (answers := channel.drain()):
                if not select.select([channel], [], [], max(due - time.monotonic(), 0.0))[0]:
                    raise InvalidInput(f"the process of {self.name} did not answer within {within:.3g} s")
        except ChannelClosed as error:
            raise self._ended(error) from error
        (answer,) = answers
        if isinstance(answer, TwinRefused):
            raise InvalidInput(answer.reason)
        return answer

    def ask(self, message: Message) -> Message:
        """Send a message and return the answer; raises InvalidInput."""
        with self._asking:
            try:
                self._child.channel.drain()  # an answer that came too late is not one to this
                self._child.channel.send(message)
            except ChannelClosed as error:
                raise self._ended(error) from error
            return self.answer()

    @property
    def pid(self) -> int:
        """Number of the process."""
        return self._child.pid

    def check(self) -> None:
        """Raise InvalidInput, with the reason, when it has ended."""
        if not self._child.running:
            raise self._ended(OtherSideGone("it is gone"))

    def _ended(self, error: ChannelClosed) -> InvalidInput:
        return InvalidInput(f"the process of {self.name} ended: {self._child.why(error)}")

    def end(self) -> None:
        """End it."""
        self._child.end(_END)


class RemoteStandIn(Process):
    """One stand-in.

    Parameters
    ----------
    first
        First message to its process.
    descriptors
        File descriptors that it inherits.
    """

    def __init__(self, first: Serve, descriptors: Sequence[int]) -> None:
        self.FAULTS: Mapping[str, Fault] = stand_in_class(first.name).FAULTS
        super().__init__(first.name, "stretch_bt.hardware.emulators.stand_in_process", STAND_IN, first, descriptors)

    def inject(self, fault: str, parameters: Mapping[str, Any] | None = None) -> None:
        """Begin to show a fault."""
        self.ask(Inject(fault, dict(parameters or {})))

    def clear(self, fault: str | None = None) -> None:
        """End a fault, or all of them."""
        self.ask(Clear(fault))

    def active(self) -> list[str]:
        """Return the names of the faults that are shown now."""
        return self._described().active

    def state(self) -> dict[str, Any]:
        """Return how the device stands."""
        return self._described().state

    def _described(self) -> Described:
        answer = self.ask(Describe())
        assert isinstance(answer, Described)
        return answer
