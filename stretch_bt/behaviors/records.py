"""The records that nodes share: each says when it was true and is read by its fields; nothing else goes from node to node."""

from __future__ import annotations

from dataclasses import dataclass

from stretch_bt.behaviors._readings import Reading
from stretch_bt.model import ForceModel, Limits, Series
from stretch_bt.perception.cap import Cap
from stretch_bt.perception.detect import ContactDetector
from stretch_bt.perception.pattern import FreeView
from stretch_bt.perception.tracker import HeightTracker
from stretch_bt.units import Angle, Area, Estimate, Force, Length

__all__ = [
    "Candidates",
    "Felt",
    "ForceSample",
    "FreeMembrane",
    "Heights",
    "LumpLook",
    "LumpLooks",
    "Mounting",
    "ObservedTop",
    "PlannedPress",
    "PlannedView",
    "Rise",
    "TopReadings",
    "Touch",
    "TriedViews",
    "Watch",
    "Zero",
]

PATIENCE = 3  # presses in a row that show nothing new


@dataclass(frozen=True, slots=True)
class Touch:
    """First contact: depths of the hand count from it."""

    height: Length  # of the hand, world, at which it touches the undeformed top
    height_sd: Length  # standard deviation of height


@dataclass(frozen=True, slots=True)
class FreeMembrane:
    """What frames of the free membrane show, before it touches anything."""

    frames: int  # how many
    camera: str  # that took them, by its name in the task
    view: FreeView  # their mean
    detector: ContactDetector  # what counts as contact against them


@dataclass(frozen=True, slots=True)
class Mounting:
    """How the membrane is mounted at stretch 0, as far as a force model knows."""

    prestretch: Length  # of the membrane between its clamps; 0 where the model does not know it
    sag: Length  # of its middle by its own weight, below the flat membrane
    sag_sd: Length  # standard deviation of sag


@dataclass(frozen=True, slots=True)
class ObservedTop:
    """The height of an object's top as one look shows it."""

    height: Length  # world, or above the flat membrane where the frame does not say where the hand is
    height_sd: Length  # standard deviation of height
    fixed_sd: Length  # part of height_sd that no averaging of frames takes away
    by_membrane: bool  # whether the whole membrane gave it, and not the contact alone


@dataclass(frozen=True, slots=True)
class TopReadings:
    """The heights of an object's top at each stretch and depth since first contact."""

    readings: tuple[Reading, ...] = ()  # in their order

    @property
    def count(self) -> int:
        """How many there are."""
        return len(self.readings)


@dataclass(frozen=True, slots=True)
class Felt:
    """The force law of an object, fitted to all readings of its top, and where the latest press stands on it."""

    deflection: Length  # of the top at the latest press
    deflection_sd: Length  # standard deviation of deflection
    force: Force  # on the object at the latest press, by the force model
    force_sd: Force  # standard deviation of force
    correlation: float  # of the errors of force and deflection
    creep: Length  # of the top at the latest press, newer readings less older; below 0 where the object creeps
    creep_sd: Length  # standard deviation of creep
    top: Length  # height of the undeformed top, world
    top_sd: Length  # standard deviation of top
    height: Length  # of the top at the latest press, world, on the curve
    height_sd: Length  # standard deviation of height
    series: Series  # the curve
    last: Reading  # the latest

    @classmethod
    def of(cls, series: Series, creep: Estimate, last: Reading) -> Felt:
        """Return what a curve says of its latest reading."""
        deflection, force, top, height = series.drop, series.force, series.top, series.height
        return cls(
            deflection.value,
            deflection.sd,
            force.value,
            force.sd,
            series.together,
            creep.value,
            creep.sd,
            top.value,
            top.sd,
            height.value,
            height.sd,
            series,
            last,
        )

    def stiffness_at(self, deflection: Length) -> Estimate:
        """Return force over deflection, N/m, on the curve; raises IllConditioned where the object gave way by too little."""
        return self.series.stiffness_at(deflection)


@dataclass(frozen=True, slots=True)
class Candidates:
    """The presses within the limits, at the present stretch and in steps up to the largest, with the forces that the model predicts."""

    model: ForceModel  # of the membrane
    radius: Length  # of the sphere in contact
    touched_at: Length  # height from which depths count, world
    limits: Limits  # of depth, force and stretch
    count: int  # how many stretches there are


@dataclass(frozen=True, slots=True)
class PlannedPress:
    """The next press, or look at the present one."""

    stretch: Length  # at which to press
    depth: Length  # of the hand, past first contact
    force: Force  # expected there
    deflection: Length  # expected there
    frames: int  # to average there
    gain: float  # part of the variance of the stiffness that this should take away, 1/s; 0 where nothing is gained
    known: bool  # whether no further look is needed, or none is worth its time


@dataclass(frozen=True, slots=True)
class ForceSample:
    """What a force sensor says while the hand stands still, along the hand's axis."""

    force: Force  # mean, away from the object
    force_sd: Force  # standard error of the mean
    height: Length | None  # of the hand, world, where there is an arm
    stuck_at: tuple[float, float, float] | None  # the only reading, N, where all were alike to the last digit


@dataclass(frozen=True, slots=True)
class Zero:
    """What a force sensor says without a load."""

    offset: Force  # that is taken off
    offset_sd: Force  # standard deviation of offset
    sample: ForceSample  # the readings


@dataclass(frozen=True, slots=True)
class Heights:
    """The last heights of a lump that rolls."""

    values: tuple[float, ...]  # m

    @property
    def count(self) -> int:
        """How many there are."""
        return len(self.values)


@dataclass(frozen=True, slots=True)
class LumpLook:
    """One look at a lump that rolls."""

    cap: Cap  # of what is in contact
    height: Length  # of its top over the table
    outline: float | None  # circularity of its level line, where it was drawn


@dataclass(frozen=True, slots=True)
class LumpLooks:
    """The last looks at a lump that rolls."""

    looks: tuple[LumpLook, ...]  # in their order

    @property
    def count(self) -> int:
        """How many there are."""
        return len(self.looks)


@dataclass(frozen=True, slots=True)
class Watch:
    """What the frames so far say of the membrane without contact."""

    frames: int  # taken into account
    detector: ContactDetector  # what counts as contact against them


@dataclass(frozen=True, slots=True)
class Rise:
    """What the frames so far say of the sensor at rest, from which its highest place rises."""

    frames: int  # taken into account
    tracker: HeightTracker  # the sensor at rest, and where it rose last


@dataclass(frozen=True, slots=True)
class PlannedView:
    """Where to press next to see more of an object."""

    x: Length  # of the hand, world
    y: Length  # of the hand, world
    yaw: Angle  # turn of the hand about the vertical
    request: str  # what an operator is asked to confirm; empty where the pose was planned
    coverage: float  # share of the upper surface that is known; what is hidden counts as likely as it is there
    unseen: Area  # upper surface that is likely there and is not known, seen from above
    done: bool  # whether nothing is left; the pose is then where the hand is


@dataclass(frozen=True, slots=True)
class TriedViews:
    """The places that were planned, and how many of the latest presses showed nothing new."""

    places: tuple[tuple[float, float, float], ...] = ()  # x, y, m, and turn, rad
    presses: int | None = None  # made before the latest plan
    known: Area = 0.0  # of the upper surface then
    unseen: Area = 0.0  # likely there and not known then
    fruitless: int = 0  # presses in a row that showed nothing new

    @property
    def count(self) -> int:
        """How many places were planned."""
        return len(self.places)

    @property
    def is_fruitless(self) -> bool:
        """Whether so many presses in a row showed nothing new that another is not worth it."""
        return self.fruitless >= PATIENCE
