"""Taking one frame."""

from stretch_bt.behaviors._frames import FrameSource, corrected
from stretch_bt.frames import DepthFrame
from stretch_bt.hardware.interfaces import Arm, DepthCamera, Gripper
from stretch_bt.perception.pattern import Pattern
from stretch_bt.tree.ports import Behavior, In, Out, Status, Uses
from stretch_bt.tree.registry import node


@node
class Capture(Behavior):
    """Take the next frame of the camera; FAILURE when a recording has ended."""

    kind = "perception"
    camera: Uses[DepthCamera]
    arm: Uses[Arm | None]
    gripper: Uses[Gripper | None]
    pattern: In[Pattern | None] = None  # static error of the camera, which is taken off
    frame: Out[DepthFrame]  # the frame, with the hand's height and stretch where an arm and a gripper are declared

    def initialise(self) -> None:
        """Accept frames from now on."""
        self.source = FrameSource(self.context, self.camera, self.arm, self.gripper)

    def update(self) -> Status:
        """Wait for the frame."""
        frame = self.source.next()
        if frame is None:
            return Status.RUNNING
        self.frame = corrected(frame, self.pattern, self.device_names["camera"])
        return Status.SUCCESS
