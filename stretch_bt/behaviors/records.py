"""The records that nodes share: each says when it was true and is read by its fields; nothing else goes from node to node."""

from __future__ import annotations

from dataclasses import dataclass

from stretch_bt.behaviors._readings import Reading
from stretch_bt.model import ForceModel, Limits, Series
from stretch_bt.model.palpation.planning import Plan
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

    height: Length  # height of the hand, world, at which it touches the undeformed top
    height_sd: Length  # standard deviation of height


@dataclass(frozen=True, slots=True)
class FreeMembrane:
    """The free membrane as frames show it, before it touches anything."""

    frames: int  # number of frames
    camera: str  # name in the task of the camera that took them
    view: FreeView  # mean of the frames
    detector: ContactDetector  # detector of contact against them


@dataclass(frozen=True, slots=True)
class Mounting:
    """How the membrane is mounted at stretch 0, as far as a force model knows."""

    prestretch: Length  # prestretch of the membrane between its clamps; 0 where the model does not know it
    sag: Length  # sag of its middle by its own weight, below the flat membrane
    sag_sd: Length  # standard deviation of sag


@dataclass(frozen=True, slots=True)
class ObservedTop:
    """The height of an object's top as one look shows it."""

    height: Length  # height, world, or above the flat membrane where the frame does not say where the hand is
    height_sd: Length  # standard deviation of height
    fixed_sd: Length  # part of height_sd that no averaging of frames takes away
    by_membrane: bool  # whether the whole membrane gave it, and not the contact alone


@dataclass(frozen=True, slots=True)
class TopReadings:
    """The heights of an object's top at each stretch and depth since first contact."""

    readings: tuple[Reading, ...] = ()  # readings in their order

    @property
    def count(self) -> int:
        """How many readings there are."""
        return len(self.readings)


@dataclass(frozen=True, slots=True)
class Felt:
    """The force law of an object, fitted to all readings of its top, and where the latest press stands on it."""

    deflection: Length  # deflection of the top at the latest press
    deflection_sd: Length  # standard deviation of deflection
    force: Force  # force on the object at the latest press, by the force model
    force_sd: Force  # standard deviation of force
    correlation: float  # correlation of the errors of force and deflection
    creep: Length  # creep of the top at the latest press, newer readings less older; below 0 where the object creeps
    creep_sd: Length  # standard deviation of creep
    top: Length  # height of the undeformed top, world
    top_sd: Length  # standard deviation of top
    height: Length  # height of the top at the latest press, world, on the curve
    height_sd: Length  # standard deviation of height
    series: Series  # the curve
    last: Reading  # latest reading

    @classmethod
    def of(cls, series: Series, creep: Estimate, last: Reading) -> Felt:
        """Return the quantities of a curve at its latest reading."""
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
        """Return force over deflection, N/m, on the curve; raises IllConditioned where the deflection is too small."""
        return self.series.stiffness_at(deflection)

    def stay(self) -> Plan:
        """Return the latest press as a plan: the hand stays where it is."""
        return Plan(self.last.stretch, self.last.hand, self.force, self.deflection)


@dataclass(frozen=True, slots=True)
class Candidates:
    """The presses within the limits, at the present stretch and in steps up to the largest, with the forces that the model predicts."""

    model: ForceModel  # force model of the membrane
    radius: Length  # radius of the sphere in contact
    touched_at: Length  # height from which depths count, world
    limits: Limits  # limits of depth, force and stretch
    count: int  # number of stretches


@dataclass(frozen=True, slots=True)
class PlannedPress:
    """The next press, or look at the present one."""

    stretch: Length  # stretch at which to press
    depth: Length  # depth of the hand past first contact
    force: Force  # force expected there
    deflection: Length  # deflection expected there
    frames: int  # number of frames to average there
    gain: float  # expected relative reduction of the variance of the stiffness, 1/s; 0 where nothing is gained
    known: bool  # whether no further look is needed, or none is worth its time

    @classmethod
    def of(cls, plan: Plan, candidates: Candidates, frames: int = 0, gain: float = 0.0, *, known: bool) -> PlannedPress:
        """Return a plan whose depth counts from where the candidates' depths count, 0 where the hand stays above that."""
        depth = max(candidates.touched_at - plan.hand, 0.0)
        return cls(plan.stretch, depth, plan.force, plan.drop, frames, gain, known)


@dataclass(frozen=True, slots=True)
class ForceSample:
    """The force that a sensor measures while the hand stands still, along the hand's axis."""

    force: Force  # mean force, away from the object
    force_sd: Force  # standard error of the mean
    height: Length | None  # height of the hand, world, where there is an arm
    stuck_at: tuple[float, float, float] | None  # the only force read, N, where all readings were equal


@dataclass(frozen=True, slots=True)
class Zero:
    """The force that a sensor measures without a load."""

    offset: Force  # offset that is taken off
    offset_sd: Force  # standard deviation of offset
    sample: ForceSample  # the readings


@dataclass(frozen=True, slots=True)
class Heights:
    """The last heights of a lump that rolls."""

    values: tuple[float, ...]  # heights, m

    @property
    def count(self) -> int:
        """How many heights there are."""
        return len(self.values)


@dataclass(frozen=True, slots=True)
class LumpLook:
    """One look at a lump that rolls."""

    cap: Cap  # cap of the lump that is in contact
    height: Length  # height of its top over the table
    outline: float | None  # circularity of its level line, where it was drawn
    height_sd: Length = 0.0  # standard deviation of the height


@dataclass(frozen=True, slots=True)
class LumpLooks:
    """The last looks at a lump that rolls."""

    looks: tuple[LumpLook, ...]  # looks in their order

    @property
    def count(self) -> int:
        """How many looks there are."""
        return len(self.looks)


@dataclass(frozen=True, slots=True)
class Watch:
    """The membrane without contact, as the frames so far show it."""

    frames: int  # number of frames taken into account
    detector: ContactDetector  # detector of contact against them


@dataclass(frozen=True, slots=True)
class Rise:
    """The sensor at rest, from which its highest place rises, as the frames so far show it."""

    frames: int  # number of frames taken into account
    tracker: HeightTracker  # the sensor at rest, and where it rose last


@dataclass(frozen=True, slots=True)
class PlannedView:
    """Where to press next to see more of an object."""

    x: Length  # x of the hand, world
    y: Length  # y of the hand, world
    yaw: Angle  # turn of the hand about the vertical
    request: str  # request that an operator is asked to confirm; empty where the pose was planned
    coverage: float  # known share of the upper surface; hidden surface counts by its probability to be there
    unseen: Area  # expected area of upper surface that is there and not known, seen from above
    done: bool  # whether nothing is left; the pose is then where the hand is


@dataclass(frozen=True, slots=True)
class TriedViews:
    """The places that were planned, and how many of the latest presses showed nothing new."""

    places: tuple[tuple[float, float, float], ...] = ()  # x, y, m, and turn, rad
    presses: int | None = None  # number of presses made before the latest plan
    known: Area = 0.0  # known area of the upper surface then
    unseen: Area = 0.0  # expected area there and not known then
    fruitless: int = 0  # number of presses in a row that showed nothing new

    @property
    def count(self) -> int:
        """How many places were planned."""
        return len(self.places)

    @property
    def is_fruitless(self) -> bool:
        """Whether so many presses in a row showed nothing new that another is not worth it."""
        return self.fruitless >= PATIENCE
