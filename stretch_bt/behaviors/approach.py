"""Finding the object: the first touch, and the height of its undeformed top."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import ClassVar

from stretch_bt import model, perception
from stretch_bt.behaviors._force_limit import ForceLimit
from stretch_bt.behaviors._frames import FrameSource, corrected
from stretch_bt.behaviors._motion import MotionBehavior, touched_at
from stretch_bt.behaviors._readings import FirstTouch, Reading
from stretch_bt.behaviors.records import Mounting, TopReadings, Touch
from stretch_bt.errors import NoAnswer, NoContact
from stretch_bt.frames import DepthFrame
from stretch_bt.hardware.interfaces import Arm, DepthCamera, ForceSensor, Gripper, Motion, MotionState
from stretch_bt.perception.pattern import HANG, Pattern
from stretch_bt.perception.types import FloatArray, LabelArray, MaskArray
from stretch_bt.tree.countdown import Countdown
from stretch_bt.tree.ports import In, InOut, Out, Status, Uses, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Estimate, Force, Length, Speed, Time

MAX_AGE = 0.2
FALSE_ALARMS = 1e-6  # per frame: a descent takes hundreds
#: how deep something stands in the membrane at the begin that is called contact, m: a camera's static error looks like 1.3 mm at most
TOUCHING = 0.002
#: how deep the first touch that is felt may be, m
DEEPEST_TOUCH = 0.0025
#: world height that it goes down to where no cell says how far, m
GROUND = 0.0
#: of the way from the highest reading to no force, by which it may be off: objects differ in their power
EXTRAPOLATED = 0.2
FEEL_SPEED = 0.005  # m/s: between readings the hand moves a millimetre


@node
class Approach(MotionBehavior):
    """Lower the hand until it touches, feel a few shallow depths, and extrapolate to the height at no force.

    It goes down as far as the limits of the cell allow. FAILURE when nothing was met there, or when the membrane touches something at
    the begin.

    The reading at a first touch is low already, because a soft object has given way by then; the height that this node
    writes, and from which `press` counts, is that of the undeformed top.

    Up to the touch every frame shows the free membrane, whose shape is known. What they show beside it is the static error
    of the camera; here and in `capture` and `average_frames` it is then taken off all later frames of the run.

    With `mounting` the static error is told from the sag of the membrane.
    """

    arm: Uses[Arm]
    camera: Uses[DepthCamera]
    gripper: Uses[Gripper | None]
    force_sensor: Uses[ForceSensor | None]
    speed: In[Speed] = port(0.010, min=0.001, max=0.050, doc="of the descent", limit="contact_speed")
    max_travel: In[Length | None] = port(
        None, min=0.001, max=2.0, doc="give up when nothing was met this far down, or where the cell ends before that"
    )
    max_force: In[Force] = port(5.0, min=0.05, max=50.0, doc="stop and fail above this", limit="held_force")
    feel_step: In[Length] = port(0.001, min=0.0003, max=0.005, doc="between readings past the first touch")
    readings: In[int] = port(5, min=2, max=20, doc="depths at which to read the height")
    average: In[int] = port(24, min=1, max=64, doc="frames to average at each")
    settle: In[Time] = port(
        0.0, min=0.0, max=60.0, doc="wait at each depth before it is read: a gel gives way for seconds"
    )
    mounting: In[Mounting | None] = None  # of the membrane, as far as it is known
    learn_pattern: In[bool] = port(True, doc="take the camera's static error off later frames")
    contact_height: Out[Length] = port(truth="contact_height")  # world height of the undeformed top
    touch: InOut[Touch | None]  # the same, from which depths count
    pattern: InOut[Pattern | None]  # static error of the camera
    top_readings: InOut[TopReadings | None]  # heights of the top at the depths

    #: frames in a row that must show contact
    ALARMS: ClassVar[int] = 2
    #: frames without contact that the detector needs before the hand may move
    QUIET: ClassVar[int] = 12
    #: frames that tell whether contact was noticed late
    RISING: ClassVar[int] = 4

    def initialise(self) -> None:
        """Forget an earlier contact and begin by looking at the free membrane."""
        super().initialise()
        self.touch = self.pattern = self.top_readings = self.context.hand.contact_height = None
        self.limit = ForceLimit(self.max_force, self.arm, self.force_sensor, self.context)
        self.detector = perception.ContactDetector(false_alarms=FALSE_ALARMS)
        self.source = FrameSource(self.context, self.camera, self.arm, self.gripper)
        self.free = perception.FreeView()
        self.frames: list[DepthFrame] = []
        self.felt: list[tuple[float, float, float]] = []  # membrane depth, world height, sd
        self.read: list[Reading] = []
        self.steps = 0
        self.risen = False
        self.alarms = 0
        self.phase: Callable[[], Status] = self._rest

    def start(self) -> Motion:
        """Move down, as far as allowed."""
        pose, limits = self.arm.pose(MAX_AGE).value, self.context.limits
        lowest = GROUND if limits is None else limits.height.min
        self.goal = min(max(pose.height - (self.max_travel or math.inf), lowest), pose.height)
        return self.arm.move(pose.at_height(self.goal), speed=self.speed, owner=self.path)

    def update(self) -> Status:
        """Go through rest, descent and feeling."""
        return self.phase()

    def _rest(self) -> Status:
        self.reason = "looking at the free membrane"
        frame = self.source.next()
        if frame is not None:
            self.detector.update(frame)
            self.free.add(frame)
            self.frames.append(frame)
        if len(self.frames) >= self.QUIET:
            self._check_free()
            self.free.settle()
            self.motion = self.start()
            self.phase = self._descend
        return Status.RUNNING

    def _check_free(self) -> None:
        """Refuse to begin where the membrane touches something: it would be taken for the shape of the free one."""
        found = self._top(perception.average_frames(self.frames))
        if found is not None and found[0].value > TOUCHING:
            deep = found[0].value * 1e3
            raise NoContact(
                f"the membrane touches something already, {deep:.1f} mm deep; raise the hand before it approaches"
            )

    def _descend(self) -> Status:
        self.reason = "moving down"
        frame = self.source.next()
        if frame is not None:
            self.alarms = self.alarms + 1 if self.detector.update(frame) else 0
            self.free.add(frame)
        if self.alarms >= self.ALARMS:
            self._halt()
            if self.learn_pattern:
                hand, known = self.context.hand.geometry, self.mounting or Mounting(0.0, HANG.value, HANG.sd)
                found = self.free.pattern(hand.gauge + known.prestretch, Estimate(known.sag, known.sag_sd), hand.width)
                self.pattern = None if found is None else replace(found, camera=self.device_names["camera"])
            self._look()
            return Status.RUNNING
        return self._moving(NoContact(f"nothing was met down to {self.goal * 1e3:.0f} mm"))

    def _halt(self) -> None:
        if self.motion is not None:
            self.motion.stop()
            self.motion = None

    def _moving(self, arrived: NoAnswer | None) -> Status:
        """Poll the motion; `arrived` is what it means to get to its end without contact."""
        assert self.motion is not None
        passed = self.limit.passed()
        if passed is not None:
            raise NoContact(passed)
        state = self.motion.poll()
        if state is MotionState.MOVING:
            return Status.RUNNING
        if state is not MotionState.DONE:
            raise NoContact(f"the motion ended early: {state}")
        if arrived is not None:
            raise arrived
        self.motion = None
        self._look()
        return Status.RUNNING

    def _look(self) -> None:
        """Let the object settle where the hand now stands, then collect frames."""
        self.rested = Countdown(self.context, self.settle)
        self.phase = self._settle
        if self.settle == 0:
            self._collect()

    def _settle(self) -> Status:
        self.reason = "letting the object settle"
        if self.rested.over:
            self._collect()
        return Status.RUNNING

    def _collect(self) -> None:
        self.source = FrameSource(self.context, self.camera, self.arm, self.gripper)
        self.frames = []
        self.phase = self._feel

    def _feel(self) -> Status:
        self.reason = f"feeling, {len(self.felt)} of {self.readings} depths"
        frame = self.source.next()
        if frame is not None:
            self.frames.append(frame)
        if len(self.frames) < self.average:
            return self._rise_to_touch() or Status.RUNNING
        self._measure(corrected(perception.average_frames(self.frames), self.pattern, self.device_names["camera"]))
        if len(self.felt) >= self.readings:
            return self._conclude()
        if self.steps >= 2 * self.readings:
            raise NoContact(f"only {len(self.felt)} of {self.steps} depths showed the top of an object")
        self.steps += 1
        pose = self.arm.pose(MAX_AGE).value
        self.motion = self.arm.move(pose.moved(z=-self.feel_step), speed=min(FEEL_SPEED, self.speed), owner=self.path)
        self.phase = lambda: self._moving(None)
        return Status.RUNNING

    def _rise_to_touch(self) -> Status | None:
        """Go back up, once, where contact was noticed late: the lightest touches tell most of the height at no force."""
        if self.risen or len(self.frames) < max(1, min(self.RISING, self.average - 1)):
            return None
        self.risen = True
        found = self._top(corrected(perception.average_frames(self.frames), self.pattern, self.device_names["camera"]))
        if found is None or found[0].value <= DEEPEST_TOUCH:
            return None
        pose = self.arm.pose(MAX_AGE).value
        self.motion = self.arm.move(
            pose.moved(z=found[0].value - DEEPEST_TOUCH), speed=min(FEEL_SPEED, self.speed), owner=self.path
        )
        self.phase = lambda: self._moving(None)
        return Status.RUNNING

    def _measure(self, frame: DepthFrame) -> None:
        """Note one height; a touch too light to be seen is passed over."""
        found = self._top(frame)
        if found is not None and found[0].value > 0:
            top, points, valid, labels = found
            height = top.value + (frame.hand_height or 0.0)
            self.felt.append((top.value, height, top.sd))
            touch = FirstTouch(points, valid, labels)
            self.read.append(Reading(frame.stretch or 0.0, top.value, height, top.sd, touch, self.average))

    # A flat top lifts the membrane; not taken off here, since the extrapolation from light touches may absorb it already: not measured.
    def _top(self, frame: DepthFrame) -> tuple[Estimate, FloatArray, MaskArray, LabelArray] | None:
        """Return how deep the top of a contact stands in the membrane, m, the points seen, which are valid, and what each shows."""
        try:
            contact = perception.find_contact(frame)
            points, valid = perception.deproject(frame)
            points = perception.to_membrane(points, frame.plane_distance or 0.0)
            reach = self.context.hand.geometry.reach(frame.stretch or 0.0)
            return perception.track_height(points, valid, contact.labels, reach=reach), points, valid, contact.labels
        except NoAnswer:
            return None

    def _conclude(self) -> Status:
        depths, heights, sds = zip(*self.felt, strict=True)
        found: Estimate = model.undeformed_height(depths, heights, sds)
        beyond = EXTRAPOLATED * max(found.value - max(heights), 0.0)
        height = Estimate(found.value, math.hypot(found.sd, beyond, self.pattern.hang_sd if self.pattern else 0.0))
        self.touch = Touch(height.value, height.sd)
        touched_at(self.context, self.touch)
        self.contact_height = height
        self.top_readings = TopReadings(tuple(self.read))
        self.reason = ""
        return Status.SUCCESS
