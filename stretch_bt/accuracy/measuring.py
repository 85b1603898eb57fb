"""Measuring domains: rows as they come, each domain warm before its first."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from itertools import accumulate

from stretch_bt.accuracy.budget import Budget
from stretch_bt.accuracy.job import Domain, Job
from stretch_bt.accuracy.made import Made, made_here
from stretch_bt.accuracy.points import ANSWERED, REFUSED, SKIPPED, Answer, Row, rounded
from stretch_bt.accuracy.registry import domains
from stretch_bt.accuracy.yardstick import yardstick
from stretch_bt.errors import NoAnswer

__all__ = ["LEAST", "TIMES", "measure"]

LEAST = 0.05  # CPU s; shorter times are too noisy to compare
TIMES = 3  # runs of a job whose time is compared
_LONG = 2.0  # CPU s; a longer job is run once, unless its time is in doubt

Doubt = Callable[[Row], bool]


def _never(row: Row) -> bool:
    return False


def measure(
    names: Iterable[str] = (),
    *,
    quick: bool = False,
    part: tuple[int, int] = (1, 1),
    commit: str | None = None,
    doubt: Doubt | None = None,
) -> Iterator[Row]:
    """Return the rows of the named domains, or of all, each as soon as it is measured.

    `quick` takes the jobs that fit into 6 CPU s a domain. `part` is which of how many parts, about equally long, of each domain.
    A time of 50 ms and more is taken three times where that takes little or where `doubt` of the row is true, unless its job
    is to run `once`; the least counts. `commit` is the code that made the rows, where git does not know.
    """
    chosen = domains(names)
    made = made_here(commit)
    return (row for name, domain in chosen.items() for row in _rows(name, domain, quick, part, made, doubt or _never))


def _rows(name: str, domain: Domain, quick: bool, part: tuple[int, int], made: Made, doubt: Doubt) -> Iterator[Row]:
    budget = Budget(quick)
    domain.warm()
    yardstick()
    begun: dict[str, bool] = {}  # groups, and whether the first job in them has an answer
    for job in _part([*domain.jobs(quick)], *part):
        row = partial(_row, name, domain, job, made)
        if not budget.takes(job):
            yield row(Answer(job.error_kind, None, None, status=SKIPPED, reason="quick"), None)
            continue
        if not begun.get(job.group, True):
            continue
        began = time.process_time()
        found = _timed(job, row, quick, doubt)
        budget.spend(job, time.process_time() - began)
        if job.group:
            begun.setdefault(job.group, any(r.status in ANSWERED for r in found))
        yield from found


def _part(jobs: Sequence[Job], number: int, count: int) -> list[Job]:
    """Return one of several parts of jobs, one after the other, that should take equally long; a group stays whole."""
    if count == 1:
        return [*jobs]
    middles: dict[str, float] = {}
    ends = accumulate(job.seconds for job in jobs)
    found = []
    for job, end in zip(jobs, ends, strict=True):
        middle = end - job.seconds / 2
        found.append((job, middles.setdefault(job.group, middle) if job.group else middle))
    whole = sum(job.seconds for job in jobs) or 1.0
    return [job for job, middle in found if min(math.floor(count * middle / whole), count - 1) == number - 1]


def _timed(job: Job, row: Callable[[Answer, float | None], Row], quick: bool, doubt: Doubt) -> list[Row]:
    """Return the rows of a job, with the least of their times relative to the yardstick beside them."""
    found: list[Row] = []
    for time_ in range(TIMES):
        began = time.process_time()
        answers = _answers(job)
        spent = time.process_time() - began
        compared = not job.once and any((a.cpu_seconds or 0.0) >= LEAST for a in answers)
        beside = yardstick() if compared else None
        again = [row(answer, beside) for answer in answers]
        found = [_quicker(*pair) for pair in zip(found or again, again, strict=True)]
        if beside is None or (time_ == 0 and not (spent < _LONG and not quick) and not any(map(doubt, found))):
            break
    return found


def _quicker(first: Row, second: Row) -> Row:
    def pace(row: Row) -> float:
        return (row.cpu_seconds or 0.0) / (row.kernel_seconds or 1.0)

    return first if pace(first) <= pace(second) else second


def _answers(job: Job) -> list[Answer]:
    began = time.process_time()
    try:
        return [*job.run()]
    except NoAnswer as none:
        reason = f"{type(none).__name__}: {none.reason}"
        return [Answer(job.error_kind, None, time.process_time() - began, status=REFUSED, reason=reason)]


def _row(name: str, domain: Domain, job: Job, made: Made, answer: Answer, beside: float | None) -> Row:
    cost = answer.cost
    return Row(
        domain=name,
        case=job.case,
        setting=job.setting,
        default=job.default,
        seed=job.seed,
        error=rounded(answer.error),
        error_kind=answer.error_kind,
        unit=domain.kinds[answer.error_kind].si,
        reference_error=rounded(answer.reference_error),
        cpu_seconds=rounded(answer.cpu_seconds),
        robot_seconds=rounded(answer.robot_seconds),
        cost=None if cost is None else cost._replace(value=rounded(cost.value) or 0.0),
        status=answer.status,
        reason=answer.reason,
        cpu=made.cpu,
        commit=made.commit,
        versions=made.versions,
        kernel_seconds=rounded(beside) if (answer.cpu_seconds or 0.0) >= LEAST else None,
    )
