"""How a run ended: the fields of `run --json`, and what only Python has."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, fields
from typing import Any

from stretch_bt.blame import Broken
from stretch_bt.errors import RecordError, named
from stretch_bt.runtime.context import Commanded, Seen
from stretch_bt.runtime.expectation import Expectation
from stretch_bt.runtime.onlooker import Visits
from stretch_bt.runtime.outcome import Outcome
from stretch_bt.runtime.prepare import Task
from stretch_bt.runtime.record import RunRecord
from stretch_bt.runtime.record.plain import plain
from stretch_bt.runtime.truth import Truths, output_values
from stretch_bt.tree.built_tree import BuiltTree
from stretch_bt.tree.cell import MISSING

__all__ = ["RunResult", "interrupt_result", "keys_of_main", "place_of", "result_of", "told_in", "unmet_of"]


_OF_PYTHON = ("visited", "commands", "logged", "keys")


@dataclass(slots=True)
class RunResult:
    """How a run ended, what it found, and where its record is; the fields of `run --json`, and in Python alone some more.

    Parameters
    ----------
    choice
        What the advisor chose for the twin, with its prediction and cost; None where nothing is simulated.
    visited
        By the path of each node that was ticked: the statuses that it came to, each once, in the order in which they first came.
    commands
        What nodes commanded the devices of a cell, or scripted ones, the latest 10,000.
    logged
        The texts of `log`, each with the path of its place, in their order, the latest 10,000.
    keys
        What the keys of `main` held at the end, records included, in SI; a number with a deviation is an Estimate.
    """

    status: str
    reason: str
    outputs: dict[str, dict[str, Any]]
    truth: dict[str, dict[str, Any]]
    ticks: int
    task_seconds: float
    wall_seconds: float
    cpu_seconds: float
    record: str | None
    overruns: int = 0
    errors: list[str] = field(default_factory=list)
    unmet: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    readings: dict[str, Any] = field(default_factory=dict)
    stats: list[dict[str, Any]] = field(default_factory=list)
    choice: dict[str, Any] | None = None
    broken: list[Broken] = field(default_factory=list)
    visited: dict[str, tuple[str, ...]] = field(default_factory=dict)
    commands: list[Commanded] = field(default_factory=list)
    logged: list[tuple[str, str]] = field(default_factory=list)
    keys: dict[str, Any] = field(default_factory=dict)

    @classmethod
    def without_ticks(cls, status: str, reason: str, record: str | None) -> RunResult:
        """Return how a run ended that never ticked; `record` is the path of its record, if it keeps one."""
        return cls(status, reason, {}, {}, 0, 0.0, 0.0, 0.0, record)

    def to_json(self) -> dict[str, Any]:
        """Return the fields that `run --json` prints."""
        return {f.name: plain(getattr(self, f.name)) for f in fields(self) if f.name not in _OF_PYTHON}


def place_of(record: RunRecord) -> str | None:
    """Return the path of a record; None of a run that keeps none."""
    return None if record.folder is None else str(record.folder)


def result_of(task: Task, outcome: Outcome, truths: Truths, visits: Visits, seen: Seen, record: RunRecord) -> RunResult:
    """Return the result of a task that ended."""
    good = outcome.status == "SUCCESS"
    outputs, truth = output_values(task.built.outputs, truths.found, succeeded=good)
    return RunResult(
        status=outcome.status,
        reason=outcome.reason,
        outputs=outputs,
        truth=truth,
        ticks=outcome.ticks,
        task_seconds=outcome.task_seconds,
        wall_seconds=outcome.wall_seconds,
        cpu_seconds=outcome.cpu_seconds,
        record=place_of(record),
        overruns=outcome.overruns,
        errors=outcome.errors,
        broken=outcome.broken,
        unmet=unmet_of(task, outcome, visits.seen, seen),
        notes=[*task.notes, *truths.notes, *outcome.notes],
        readings=seen.shown(),
        visited={path: tuple(statuses) for path, statuses in visits.statuses.items()},
        commands=list(seen.commands),
        logged=list(visits.logged),
        keys=keys_of_main(task.built),
    )


def unmet_of(task: Task, outcome: Outcome, visited: set[tuple[str, str]], seen: Seen) -> list[str]:
    """Return what the mocks of a task expected of it that did not come true; `visited` holds (path, STATUS)."""
    expected = task.mocks.expect if task.mocks else Expectation()
    outputs = {name: cell.value for name, (_, cell) in task.built.outputs.items()}
    commands = [f"{command.device}.{command.name}" for command in seen.commands]
    return expected.unmet(outcome.status, outcome.ticks, visited, outputs, commands)


def keys_of_main(built: BuiltTree) -> dict[str, Any]:
    """Return the present values of the keys of `main`, in SI; a number with a deviation is an Estimate."""
    named = ((cell.name.removeprefix("main/"), cell) for cell in built.cells if cell.name.startswith("main/"))
    return {name: cell.held() for name, cell in named if "/" not in name and cell.value is not MISSING}


@contextmanager
def told_in(result: RunResult, what: str = "") -> Iterator[None]:
    """Add what breaks in the block to the errors of a result: nothing after the last tick changes how a run ended."""
    try:
        yield
    except RecordError as error:
        result.errors.append(str(error))
    except Exception as error:
        result.errors.append(f"{what or 'no result.json'} ({named(error)})")


def interrupt_result(result: RunResult, why: str) -> None:
    """Say in a result that a signal came after the task had ended; a record that is closed keeps how the task ended.

    A device fault and an error stay what they are.
    """
    if result.status in ("SUCCESS", "FAILURE"):
        ended = f"{why} came after the task had ended with {result.status}"
        result.status, result.reason = "INTERRUPTED", f"{ended}: {result.reason}" if result.reason else ended
