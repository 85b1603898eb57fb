"""Taking several frames of a still scene as one."""

from stretch_bt import perception
from stretch_bt.behaviors._frames import FrameSource, corrected
from stretch_bt.frames import DepthFrame
from stretch_bt.hardware.interfaces import Arm, DepthCamera, Gripper
from stretch_bt.perception.pattern import Pattern
from stretch_bt.tree.ports import Behavior, In, Out, Status, Uses, port
from stretch_bt.tree.registry import node


@node
class AverageFrames(Behavior):
    """Take the mean of the next frames while the hand stands still; FAILURE when a recording has ended."""

    kind = "perception"
    camera: Uses[DepthCamera]
    arm: Uses[Arm | None]
    gripper: Uses[Gripper | None]
    pattern: In[Pattern | None] = None  # static error of the camera, which is taken off
    count: In[int] = port(8, min=1, max=256, doc="number of frames")
    frame: Out[DepthFrame]  # mean of the frames, in a finer unit, with the hand's height and stretch

    def initialise(self) -> None:
        """Accept frames from now on."""
        self.source = FrameSource(self.context, self.camera, self.arm, self.gripper)
        self.frames: list[DepthFrame] = []

    def update(self) -> Status:
        """Collect, then average."""
        frame = self.source.next()
        if frame is not None:
            self.frames.append(frame)
        if len(self.frames) < self.count:
            return Status.RUNNING
        self.frame = corrected(perception.average_frames(self.frames), self.pattern, self.device_names["camera"])
        return Status.SUCCESS
