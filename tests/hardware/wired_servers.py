"""Stand-ins in a process of their own, which nothing of a run delays; a program that reads one JSON object a line and answers with one.

A line names a command: `start` stand-ins at a `host`, `inject` a fault into a `device`, report the `state` of all, or `stop`.
`Servers` is the other end.
"""

import json
import mmap
import os
import signal
import struct
import subprocess
import sys
from contextlib import ExitStack

from album import Album, album, enlisted

from stretch_bt.frames import Pose
from stretch_bt.hardware.emulators.serve import serving
from stretch_bt.hardware.emulators.stand_in_world import StandInWorld
from stretch_bt.hardware.priority import raise_priority

_POSE = struct.Struct("6d")


class Place:
    """Where the hand is, in memory that both processes have."""

    def __init__(self, descriptor):
        self._memory = mmap.mmap(descriptor, _POSE.size)

    def put(self, pose):
        self._memory[:] = _POSE.pack(*pose.position, *pose.rotation)

    def get(self):
        six = _POSE.unpack(self._memory)
        return Pose(six[:3], six[3:])


class Noting(StandInWorld):
    """A stage that notes where the arm has the hand."""

    def __init__(self, place):
        super().__init__()
        self._place = place

    def place_hand(self, pose):
        self._place.put(pose)


class Servers:
    """Stand-ins that are begun anew for each run."""

    def __init__(self):
        descriptor = os.memfd_create("place")
        os.ftruncate(descriptor, _POSE.size)
        self.place = Place(descriptor)
        self._process = subprocess.Popen(
            [sys.executable, __file__, str(descriptor)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            pass_fds=[descriptor],
            start_new_session=True,
        )

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._process.communicate()

    def ask(self, **asked):
        self._process.stdin.write(json.dumps(asked) + "\n")
        self._process.stdin.flush()
        return json.loads(self._process.stdout.readline())

    def state(self, device):
        return self.ask(do="state")[device]

    def freeze(self):
        """Stop the process with every stand-in in it, as the kernel stops one: its connections stay open."""
        self._process.send_signal(signal.SIGSTOP)

    def thaw(self):
        self._process.send_signal(signal.SIGCONT)


def answer(asked, place, served, stack):
    """Do what a line asks, and return the answer."""
    match asked.pop("do"):
        case "start":
            stage = Noting(place)
            made = stack.enter_context(serving(asked["names"], stage, host=asked["host"], activated=True))
            served.update(made.stand_ins)
            place.put(served["ur"].hand())
        case "inject":
            served[asked["device"]].inject(asked["fault"], asked["parameters"])
            return {"time": served["ur"].state()["time"]}
        case "state":
            return {name: one.state() for name, one in served.items()}
        case "stop":
            stack.close()
            served.clear()
    return {}


def main():
    place, served = Place(int(sys.argv[1])), {}
    place.put(Pose((0.0, 0.0, 0.2)))
    raise_priority()
    Album.hand = place.get
    album(lambda: 0.0, 30)._expose(0)  # for the first picture code is compiled
    with enlisted(), ExitStack() as stack:
        for line in sys.stdin:
            print(json.dumps(answer(json.loads(line), place, served, stack)), flush=True)  # noqa: T201


if __name__ == "__main__":
    main()
