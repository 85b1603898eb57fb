"""Where something is over time: its motions one after the other, with a short memory of the past."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Generic, NamedTuple, TypeVar

from stretch_bt.hardware.motion.profile import Profile

__all__ = ["Track"]

T = TypeVar("T")
_MEMORY = 1.0


class _Segment(NamedTuple, Generic[T]):
    start: float
    path: Callable[[float], T]
    profile: Profile
    corners: Sequence[float] = ()

    @property
    def turns(self) -> list[float]:
        """Return the times, s, of its begin, its corners and its end."""
        passed = [self.profile.when(corner) for corner in self.corners if corner < self.profile.length]
        return [self.start + t for t in (0.0, *passed, self.profile.duration)]


class Track(Generic[T]):
    """What a device did and does; a camera asks where it was when a frame was exposed, up to a second ago."""

    def __init__(self, rest: T) -> None:
        self._segments: list[_Segment[T]] = [_Segment(float("-inf"), lambda _: rest, Profile((), 0.0, 0.0))]

    def at(self, time: float) -> T:
        """Return the place at a time, s."""
        segment = next((s for s in reversed(self._segments) if s.start <= time), self._segments[0])
        return segment.path(segment.profile.at(time - segment.start)[0])

    def begin(self, time: float, path: Callable[[float], T], profile: Profile, corners: Sequence[float] = ()) -> float:
        """Start a motion along a path, from rest, and return when it will end, s; an earlier motion is cut short.

        `corners` are the distances, m, at which the path turns.
        """
        recent = [i for i, s in enumerate(self._segments) if s.start <= time - _MEMORY]
        self._segments = [*self._segments[recent[-1] if recent else 0 :], _Segment(time, path, profile, corners)]
        return time + profile.duration

    def stop(self, time: float, acceleration: float) -> None:
        """Brake."""
        last = self._segments[-1]
        self._segments[-1] = last._replace(profile=last.profile.braked(time - last.start, acceleration))

    def turns(self, after: float, until: float) -> list[float]:
        """Return the times in (after, until] at which a motion began, turned or ended, s."""
        return [t for s in self._segments for t in s.turns if after < t <= until]
