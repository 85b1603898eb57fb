"""The stage of a stand-in in a process of its own, around a twin in another one."""

from __future__ import annotations

import select
import threading
from contextlib import suppress
from typing import TYPE_CHECKING

from stretch_bt.frames import Pose, Wrench
from stretch_bt.hardware.channel import Channel, ChannelClosed
from stretch_bt.hardware.emulators.messages import Brake, FeltForce, Fingers, HandAt, LatestFrame, Noise
from stretch_bt.hardware.emulators.setting import Setting
from stretch_bt.hardware.emulators.stand_in_world import StandInWorld
from stretch_bt.hardware.messages import Message

if TYPE_CHECKING:
    from stretch_bt.hardware.emulators.twin_camera import TwinCamera

__all__ = ["SceneStage"]


class SceneStage(StandInWorld):
    """Reports to the twin where hand and fingers go, and keeps its latest messages; no call waits until it has solved something.

    Parameters
    ----------
    setting
        Setting of the scene.
    twin
        Channel to the twin's process.
    pictures
        Descriptor of the memory in which that leaves its pictures.
    """

    def __init__(self, setting: Setting, twin: Channel, pictures: int) -> None:
        super().__init__(now=setting.now, seed=setting.seed)
        self._setting, self._twin, self._pictures = setting, twin, pictures
        self._felt: dict[str, Wrench] = {}
        self._noise: dict[str, float] = {}
        self._seen = (-1, 0)
        self._news = threading.Condition()
        threading.Thread(target=self._listen, name="news of the twin", daemon=True).start()

    def move_fingers(self, to: float, speed: float) -> float:
        """Start moving the fingers, and return when they will be there, s."""
        end = super().move_fingers(to, speed)
        self._send(Fingers(self.now(), to, speed))
        return end

    def stop_fingers(self) -> None:
        """Brake."""
        super().stop_fingers()
        self._send(Brake(self.now()))

    def place_hand(self, pose: Pose) -> None:
        """Take note that an arm has the hand there now."""
        self._send(HandAt(self.now(), [*pose.position, *pose.rotation]))

    def wrench(self, kind: str) -> Wrench:
        """Return the latest that was solved."""
        return self._felt.get(kind) or super().wrench(kind)

    def force_noise(self, kind: str) -> float | None:
        """Return the standard deviation that the scene gives a kind of device."""
        return self._noise.get(kind)

    def camera(self, rate: int) -> TwinCamera:
        """Return what a camera sees of the twin."""
        from stretch_bt.hardware.emulators.twin_camera import TwinCamera

        return TwinCamera(self._setting, self.geometry, self._pictures, rate, self.seen)

    def seen(self, frame: int, until: float) -> tuple[int, int]:
        """Return the numbers of the latest frame that has a picture, and of that picture; before the first it is frame -1.

        Waits until a time, s, at most for the picture of a frame with this number or a later one.
        """
        with self._news:
            self._news.wait_for(lambda: self._seen[0] >= frame, max(until - self.now(), 0.0))
            return self._seen

    def _send(self, message: Message) -> None:
        """Send the twin a message; whoever began its process notices when it is gone."""
        with suppress(ChannelClosed):
            self._twin.send(message)

    def _listen(self) -> None:
        with suppress(ChannelClosed):
            while True:
                select.select([self._twin], [], [])
                for message in self._twin.drain():
                    self._take(message)

    def _take(self, message: Message) -> None:
        match message:
            case FeltForce(forces):
                self._felt = {kind: Wrench((x, y, z)) for kind, (x, y, z) in forces.items()}
            case Noise(sds):
                self._noise = sds
            case LatestFrame(frame, picture):
                with self._news:
                    self._seen = (frame, picture)
                    self._news.notify_all()
