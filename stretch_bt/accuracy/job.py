"""A job, the smallest part that is measured by itself, and the parts of a domain."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from stretch_bt.accuracy.points import Answer, Kind, Row, Setting

if TYPE_CHECKING:
    from stretch_bt.accuracy.advice import DomainSummaries

__all__ = ["CPU_MS", "CPU_S", "NODES", "PRESSES", "ROBOT_MIN", "ROBOT_S", "CostAxis", "Domain", "Job", "Panel"]


@dataclass(frozen=True, slots=True)
class Job:
    """A case solved with one setting: `run` returns an Answer for each kind of error.

    `run` may raise NoAnswer. `seconds` is the CPU time that it is expected to take, `error_kind` is for the row where it is
    not run. The first job of a `group` makes what the others need, so that none is run where one before it was not run, or
    where the first has no answer. `once` is for answers that are kept, whose time a second run would not take again: it is
    not compared.
    """

    case: str
    setting: Setting
    error_kind: str
    seconds: float
    run: Callable[[], Iterable[Answer]]
    seed: int | None = None
    default: bool = False
    group: str = ""
    once: bool = False


class CostAxis(NamedTuple):
    """A cost as it is drawn: its name with the unit, and how many of that unit a row costs."""

    name: str
    of: Callable[[Row], float | None]


def _cost(row: Row) -> float | None:
    return None if row.cost is None else row.cost.value


def _scaled(value: float | None, scale: float) -> float | None:
    return None if value is None else value * scale


CPU_MS = CostAxis("CPU ms", lambda row: _scaled(row.cpu_seconds, 1e3))
CPU_S = CostAxis("CPU s", lambda row: row.cpu_seconds)
ROBOT_S = CostAxis("robot s", lambda row: row.robot_seconds)
ROBOT_MIN = CostAxis("robot minutes", lambda row: _scaled(row.robot_seconds, 1 / 60))
PRESSES, NODES = CostAxis("presses", _cost), CostAxis("nodes", _cost)


class Panel(NamedTuple):
    """A diagram: a kind of error by a cost, of all series that have both or of those that are named."""

    kind: str
    axis: CostAxis = CPU_MS
    series: tuple[str, ...] = ()
    title: str = ""


@dataclass(frozen=True, slots=True)
class Domain:
    """The errors that are measured of one subject, and how they are shown.

    `about` names the reference of the errors, `kinds` says how each is shown, `panels` are the diagrams. `take` returns the
    sentence that a reader should take along; `omitted` lists figures that are not drawn or not measured, and why. `peers` are the
    series of other programs. `warm` runs each code once that `jobs(quick)` time.
    """

    about: str
    kinds: Mapping[str, Kind]
    panels: Sequence[Panel]
    take: Callable[[DomainSummaries], str]
    omitted: Mapping[str, str]
    warm: Callable[[], None]
    jobs: Callable[[bool], Iterable[Job]]
    peers: frozenset[str] = field(default_factory=frozenset)
