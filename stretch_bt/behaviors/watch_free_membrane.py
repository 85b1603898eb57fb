"""Looking at the membrane before it touches anything."""

from __future__ import annotations

from stretch_bt import perception
from stretch_bt.behaviors._first_touch import top_of
from stretch_bt.behaviors._frames import FrameSource
from stretch_bt.behaviors.records import FreeMembrane
from stretch_bt.errors import NoContact
from stretch_bt.frames import DepthFrame
from stretch_bt.hardware.interfaces import Arm, DepthCamera, Gripper
from stretch_bt.tree.ports import Behavior, In, Out, Status, Uses, port
from stretch_bt.tree.registry import node

FALSE_ALARMS = 1e-6  # per frame: a descent takes hundreds
#: depth in the membrane from which something counts as contact, m: a camera's static error looks like 1.3 mm at most
TOUCHING = 0.002


@node
class WatchFreeMembrane(Behavior):
    """Look at the free membrane, so that contact and the camera's static error show against it; FAILURE when it touches something."""

    kind = "perception"
    camera: Uses[DepthCamera]
    arm: Uses[Arm | None]
    gripper: Uses[Gripper | None]
    count: In[int] = port(12, min=6, max=256, doc="number of frames before the hand may move")
    free_membrane: Out[FreeMembrane]  # the free membrane as they show it

    def initialise(self) -> None:
        """Accept frames from now on."""
        self.source = FrameSource(self.context, self.camera, self.arm, self.gripper)
        self.view = perception.FreeView()
        self.detector = perception.ContactDetector(false_alarms=FALSE_ALARMS)
        self.frames: list[DepthFrame] = []

    def update(self) -> Status:
        """Collect."""
        self.reason = "looking at the free membrane"
        frame = self.source.next()
        if frame is not None:
            self.detector.update(frame)
            self.view.add(frame)
            self.frames.append(frame)
        if len(self.frames) < self.count:
            return Status.RUNNING
        self._check_free()
        self.view.settle()
        self.free_membrane = FreeMembrane(len(self.frames), self.device_names["camera"], self.view, self.detector)
        self.reason = ""
        return Status.SUCCESS

    def _check_free(self) -> None:
        """Refuse to begin where the membrane touches something: it would be taken for the shape of the free one."""
        found = top_of(perception.average_frames(self.frames), self.context.hand.geometry)
        if found is not None and found[0].value > TOUCHING:
            deep = found[0].value * 1e3
            raise NoContact(
                f"the membrane touches something already, {deep:.1f} mm deep; raise the hand before it approaches"
            )
