"""Which presses characterise a hand: indenters, stretches, depths and trials, and the order that costs least time."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace

from stretch_bt.errors import InvalidInput

__all__ = ["PROTOCOLS", "Protocol", "State", "missing", "protocol"]

#: how far a press may be from a state for it to count as that state, m and rad
_SIZE, _STRETCH, _DEPTH = 1e-4, 2e-3, 5e-4
_CONE = math.radians(45.0)


@dataclass(frozen=True, slots=True)
class State:
    """One press: `size` is a diameter, m, or the angle of a cone, rad; `depth` is how far the hand is past first contact, m."""

    geometry: str
    size: float
    stretch: float
    depth: float
    trial: int

    @property
    def indenter(self) -> tuple[str, float]:
        """Geometry and size of the mounted indenter."""
        return self.geometry, self.size

    @property
    def series(self) -> tuple[str, float, float, int]:
        """Geometry, size, stretch and trial, the same in all presses of a trial."""
        return self.geometry, self.size, self.stretch, self.trial


@dataclass(frozen=True, slots=True)
class Protocol:
    """Every indenter at every stretch, trial and depth; lengths in m, rising."""

    spheres: tuple[float, ...]
    cylinders: tuple[float, ...]
    cones: tuple[float, ...]
    stretches: tuple[float, ...]
    depths: tuple[float, ...]
    trials: int

    def indenters(self) -> Iterator[tuple[str, float]]:
        """Yield (geometry, size), each once."""
        for geometry, sizes in (("sphere", self.spheres), ("cylinder", self.cylinders), ("cone", self.cones)):
            for size in sizes:
                yield geometry, size

    def states(self) -> Iterator[State]:
        """Yield every press: indenters change most seldom, then stretches, then trials, in which depths rise."""
        for geometry, size in self.indenters():
            for stretch in self.stretches:
                for trial in range(1, self.trials + 1):
                    for depth in self.depths:
                        yield State(geometry, size, stretch, depth, trial)


def _mm(*values: float) -> tuple[float, ...]:
    return tuple(round(value * 1e-3, 9) for value in values)


_TO_60 = _mm(0, 10, 20, 30, 40, 50, 60)
_TO_15 = _mm(*range(16))
_FIVE = _mm(10, 15, 20, 25, 30)

#: `paper` is the StRETcH paper's (arXiv 2105.08154); `tasks` is for the shipped tasks: balloons are 60 mm across, dough is pressed at
#: 80 mm; `sensitivity` has the paper's flat cylinders, whose diameters are felt
PROTOCOLS = {
    "paper": Protocol(_FIVE, _FIVE, (_CONE,), _TO_60, _TO_15, 5),
    "sensitivity": Protocol((), _FIVE, (), _TO_60, _TO_15[1:], 1),
    "tasks": Protocol(_mm(10, 20, 30, 45, 60), (), (), (*_TO_60, *_mm(80)), _TO_15, 5),
}


def protocol(
    name: str,
    *,
    diameters: Iterable[float] = (),
    stretches: Iterable[float] = (),
    depths: Iterable[float] = (),
    trials: int = 0,
) -> Protocol:
    """Return a protocol of `PROTOCOLS` with other diameters, stretches, depths, m, or number of trials where they are given.

    Raises
    ------
    InvalidInput
        There is no such protocol; a length is no finite number of at least 0.
    """
    if name not in PROTOCOLS:
        raise InvalidInput(f"there is no protocol {name!r}; write one of {', '.join(PROTOCOLS)}")
    found = PROTOCOLS[name]
    chosen = _rising("diameters", diameters)
    return replace(
        found,
        spheres=found.spheres and (chosen or found.spheres),
        cylinders=found.cylinders and (chosen or found.cylinders),
        stretches=_rising("stretches", stretches) or found.stretches,
        depths=_rising("depths", depths) or found.depths,
        trials=trials or found.trials,
    )


def missing(wanted: Protocol, measured: Iterable[State]) -> list[State]:
    """Return the states of a protocol that no press comes near, in its order."""
    near = [_nearest([size for _, size in wanted.indenters()], _SIZE), *_grids(wanted)]
    done = set()
    for press in measured:
        size, stretch, depth = (
            find(value) for find, value in zip(near, (press.size, press.stretch, press.depth), strict=True)
        )
        done.add((press.geometry, size, stretch, depth, press.trial))
    return [s for s in wanted.states() if (s.geometry, s.size, s.stretch, s.depth, s.trial) not in done]


def _grids(wanted: Protocol) -> list[Callable[[float], float | None]]:
    return [_nearest(wanted.stretches, _STRETCH), _nearest(wanted.depths, _DEPTH)]


def _nearest(values: Iterable[float], within: float) -> Callable[[float], float | None]:
    """Return a function that gives the nearest of the values, None when it is further than `within`."""
    known = sorted(set(values))

    def find(value: float) -> float | None:
        best = min(known, key=lambda v: abs(v - value))
        return best if abs(best - value) <= within else None

    return find


def _rising(name: str, values: Iterable[float]) -> tuple[float, ...]:
    found = tuple(sorted({float(v) for v in values}))
    if not all(math.isfinite(v) and v >= 0 for v in found):
        raise InvalidInput(f"{name} are finite and at least 0 m, not {', '.join(f'{v:g}' for v in found)}")
    return found
