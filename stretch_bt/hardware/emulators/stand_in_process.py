"""The process of one stand-in: it serves its wires, and obeys whoever began it, until that is gone."""

from __future__ import annotations

import os
import select
import socket
import sys

from stretch_bt.errors import InvalidInput, StretchError
from stretch_bt.hardware.channel import Channel, ChannelClosed
from stretch_bt.hardware.emulators.base import StandIn
from stretch_bt.hardware.emulators.messages import (
    SCENE,
    STAND_IN,
    Clear,
    Describe,
    Described,
    Done,
    Inject,
    Serve,
    Serving,
    TwinRefused,
)
from stretch_bt.hardware.emulators.registry import stand_in_class
from stretch_bt.hardware.emulators.scene_stage import SceneStage
from stretch_bt.hardware.emulators.stand_in_world import StandInWorld
from stretch_bt.hardware.messages import End, Message
from stretch_bt.hardware.priority import raise_priority

__all__ = ["main"]

#: how long a thread may keep the others from running, s: a tenth of what Python allows, because a controller has cycles of 2 ms
_SWITCH = 5e-4


def serve(began: Channel, pictures: int, twin: int) -> None:
    """Serve one stand-in until the channel closes."""
    (first,) = began.first()
    assert isinstance(first, Serve)
    sys.setswitchinterval(_SWITCH)
    raise_priority()  # a device does not wait for other programs
    made = begun(first, pictures, twin)
    try:
        began.send(Serving(made.start()))
        while True:
            select.select([began], [], [])
            for message in began.drain():
                began.send(answer(made, message))
    finally:
        made.stop()


def begun(first: Serve, pictures: int, twin: int) -> StandIn:
    """Return a stand-in that is not started."""
    stage: StandInWorld = StandInWorld(seed=first.seed)
    if first.setting is not None:
        stage = SceneStage(first.setting, Channel(socket.socket(fileno=twin), SCENE), pictures)
    made = stand_in_class(first.name)(first.host, stage, first.ports)
    if first.activated:
        made.activated()
    return made


def answer(made: StandIn, message: Message) -> Message:
    """Carry out a message, and return the answer; raises ChannelClosed at the end."""
    try:
        match message:
            case Inject(fault, parameters):
                made.inject(fault, parameters)
            case Clear(fault):
                made.clear(fault)
            case Describe():
                return Described(made.active(), made.state())
            case End():
                raise ChannelClosed("asked to end")
    except InvalidInput as error:
        return TwinRefused(str(error))
    return Done()


def main(control: int, pictures: int = -1, twin: int = -1) -> None:
    """Serve for the process at the other end of a socket; without a scene there are neither pictures nor a twin."""
    began = Channel(socket.socket(fileno=control), STAND_IN)
    try:
        serve(began, pictures, twin)
    except (StretchError, OSError) as error:
        if not isinstance(error, ChannelClosed):
            began.send(TwinRefused(str(error)))
    sys.stderr.flush()
    os._exit(0)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
