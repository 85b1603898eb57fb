"""A press of the sheet from start to checked result."""

from __future__ import annotations

import time
from contextlib import suppress
from dataclasses import replace

import numpy as np

from stretch_bt.errors import Impossible, InvalidInput, NoEquilibrium
from stretch_bt.simulation.membrane.indenters import distance_kernel  # noqa: F401  compiled before the clock starts
from stretch_bt.simulation.membrane.indenters.sphere import goes_on_as
from stretch_bt.simulation.membrane.sheet.assemble import assemble, flat_problem
from stretch_bt.simulation.membrane.sheet.check import check, check_reach, measure
from stretch_bt.simulation.membrane.sheet.clamps import check_clamps
from stretch_bt.simulation.membrane.sheet.geometry import Sheet
from stretch_bt.simulation.membrane.sheet.increments import between, increments
from stretch_bt.simulation.membrane.sheet.layout import Layout
from stretch_bt.simulation.membrane.sheet.newton import Done, Minimum, Newton
from stretch_bt.simulation.membrane.sheet.predict import predict
from stretch_bt.simulation.membrane.sheet.problem import Problem
from stretch_bt.simulation.membrane.sheet.reach import BudgetSpent, reach
from stretch_bt.simulation.membrane.sheet.result import Load, Memory, SheetPress
from stretch_bt.simulation.membrane.sheet.rigid import RigidForce, rigid_force
from stretch_bt.simulation.membrane.sheet.settings import Settings
from stretch_bt.simulation.membrane.sheet.settled import StepTest
from stretch_bt.threads import one_thread

__all__ = ["solve"]

_NONE = RigidForce(np.zeros(3), np.zeros(3))
_PASSES = 8
_UNSETTLED = 1e-2  # change of an offset over the depth after the last pass
_COARSE = 2.5
_FINE = 0.75  # length of elements over the default, from which on a coarser mesh is tried where this one fails
_ATTEMPT, _SLACK_ATTEMPT = 0.1, 0.3  # parts of the budget
_FEWEST = 100  # iterations of an attempt, if so many are left
_HALVINGS = 4  # halvings of an increment that is too far


def solve(sheet: Sheet, load: Load, settings: Settings, start: SheetPress | None = None) -> SheetPress:
    """Return the equilibrium of a sheet under a load, from flat or from an earlier press, which stays as it is.

    Raises
    ------
    InvalidInput
        The load or the settings make no sense.
    NoEquilibrium
        There is none, or none was found within the budget; the reason says which.
    """
    if start is not None and start.sheet != sheet:
        raise InvalidInput("a press can start from one of the same sheet only, its material and effects included")
    with one_thread():
        return (_with_friction if sheet.effects.friction else _solve)(sheet, load, settings, start)


def _solve(sheet: Sheet, load: Load, settings: Settings, start: SheetPress | None) -> SheetPress:
    work = _Work(sheet, load, settings, start)
    check_clamps(sheet, work.layout.bodies, work.layout.span)
    return work.account(_attempts(work, start))


def _attempts(work: _Work, start: SheetPress | None) -> SheetPress:
    """Solve warm if there is a start, then cold, then from a coarser mesh where this one is fine, then step by step."""
    try:
        return work.warm(start) if start is not None else work.cold()
    except Impossible:
        raise
    except NoEquilibrium as failure:
        if start is not None:
            return _attempts(work, None)
        if work.layout.scale < _FINE:
            with suppress(NoEquilibrium):  # none is provably there: that was raised above
                return work.from_coarser()
        return reach(work.part, failure)


def _with_friction(sheet: Sheet, load: Load, settings: Settings, start: SheetPress | None) -> SheetPress:
    """Return the end of a path of presses, which friction remembers; each of them has the whole budget.

    From a press that has let go, or none, the path begins at first contact.
    """
    from stretch_bt.simulation.membrane.sheet import friction_state  # noqa: F401  compiled before the clock starts

    here = start if start is not None and start.memory.frictions else None
    if here is not None and not goes_on_as(here.load.indenter, load.indenter):
        raise InvalidInput(
            "friction goes on from a press by the same indenter, or by a ball of another size; start from its 'let_go()'"
        )
    path = _Path(sheet, settings, start)
    for target in increments(here.load if here else None, load, sheet.unit):
        try:
            here = path.to(target, here)
        except NoEquilibrium:
            if here is not None or target is load:  # else the sheet is not reached yet, or hardly so
                raise
    assert here is not None
    return path.account(here)


class _Account:
    """The cost of a solve and all it tries: iterations, factors, and CPU time since its start."""

    def __init__(self) -> None:
        self.began = time.process_time()
        self.spent = self.factors = 0

    def account(self, solved: SheetPress) -> SheetPress:
        """Return a result with the cost of all that led to it."""
        seconds = time.process_time() - self.began
        return replace(solved, iterations=self.spent, factors=self.factors, seconds=seconds)


class _Path(_Account):
    """A press on its way; `past` is the press that softening remembers at its begin."""

    def __init__(self, sheet: Sheet, settings: Settings, past: SheetPress | None) -> None:
        super().__init__()
        self.sheet, self.settings, self.past = sheet, settings, past

    def to(self, load: Load, here: SheetPress | None, halvings: int = _HALVINGS) -> SheetPress:
        """Return the press at a load after one before it, by way of their middle where that is too far."""
        work = _Work(self.sheet, load, self.settings, here or self.past)
        check_clamps(self.sheet, work.layout.bodies, work.layout.span)
        try:
            return work.warm(here) if here is not None else work.cold()
        except NoEquilibrium:
            if here is None or halvings == 0:
                raise
        finally:
            self.spent, self.factors = self.spent + work.spent, self.factors + work.factors
        return self.to(load, self.to(between(here.load, load), here, halvings - 1), halvings - 1)


class _Work(_Account):
    """One solve under way; `past` is the press that softening and friction remember."""

    def __init__(self, sheet: Sheet, load: Load, settings: Settings, past: SheetPress | None) -> None:
        super().__init__()
        self.sheet, self.load, self.settings, self.past = sheet, load, settings, past
        self.layout = Layout(sheet, load, settings)
        self.limit = settings.budget

    def warm(self, start: SheetPress) -> SheetPress:
        """Solve from an earlier press."""
        self._allow()
        mesh, control, offsets, memory = predict(self.layout, start)
        return self._finish(Newton(assemble(self.layout, mesh, offsets, self.past), control), memory)

    def cold(self) -> SheetPress:
        """Solve from the flat sheet; a slack one, which takes many iterations, on a coarse mesh first."""
        if not self.layout.slack or self.layout.scale > _COARSE / 2:
            return self._from_flat()
        return self._by_way_of(_COARSE)

    def from_coarser(self) -> SheetPress:
        """Solve from the press on a mesh twice as coarse, to which Newton finds the way where it folds a fine one over."""
        return self._by_way_of(max(2 * self.layout.scale, 1.0))

    def _by_way_of(self, coarsen: float) -> SheetPress:
        """Solve from the press on a coarser mesh, which is solved cold."""
        coarse = replace(self.settings, mesh=None, coarsen=coarsen, exact=False, corrected=False)
        return self.warm(self._on(self.load, coarse, None))

    def part(self, share: float, start: SheetPress | None) -> SheetPress:
        """Solve at a share of the depth from a shallower press, or cold, with the rest of the budget."""
        if self.spent >= self.settings.budget:
            raise BudgetSpent(f"the budget of {self.settings.budget} iterations is spent")
        settings = replace(self.settings, exact=self.settings.exact and share == 1.0)
        return self._on(self.load.part(share), settings, start)

    def _on(self, load: Load, settings: Settings, start: SheetPress | None) -> SheetPress:
        """Solve another press at the cost of this one."""
        other = _Work(self.sheet, load, settings, self.past)
        other.spent = self.spent
        try:
            return other.warm(start) if start is not None else other.cold()
        finally:
            self.spent, self.factors = other.spent, self.factors + other.factors

    def _allow(self) -> None:
        """Let the next attempt have a share of the budget, as far as it is not spent."""
        whole = self.settings.budget
        share = _SLACK_ATTEMPT if self.layout.slack else _ATTEMPT
        self.limit = min(self.spent + max(int(share * whole), _FEWEST), whole)

    def _from_flat(self) -> SheetPress:
        """Solve from the flat sheet, by way of a tent."""
        self._allow()
        layout, outline = self.layout, self.sheet.outline
        mesh = layout.mesh()
        flat = Newton(flat_problem(layout, mesh), outline.flat(mesh, layout.span))
        level = self._run(flat, lambda step: step.size < 1e-2)
        if not self.sheet.effects.sag:
            check_reach(mesh, layout.bodies, level.control, layout.unit)
        tent = outline.tent(level.control, layout.bodies, layout.span, layout.unit)
        newton = Newton(assemble(layout, mesh, (), self.past), tent)
        _update(newton.problem, self._run(newton, lambda step: step.size < 3e-2))
        return self._finish(newton, Memory(()))

    def _run(self, newton: Newton, done: Done) -> Minimum:
        iterations, factors = newton.iterations, newton.factors
        try:
            return newton.run(done, self.limit - self.spent)
        finally:
            self.spent += newton.iterations - iterations
            self.factors += newton.factors - factors

    def _finish(self, newton: Newton, memory: Memory) -> SheetPress:
        """Solve, set the offsets and the limits of friction anew and solve again until they settle; measure and check."""
        problem, has_friction = newton.problem, self.sheet.effects.friction > 0
        if has_friction:
            from stretch_bt.simulation.membrane.sheet import friction_state
        settings = self.settings
        settled = StepTest(
            self.layout.depth,
            self.layout.scale,
            exact=settings.exact,
            corrected=settings.corrected and not has_friction,
        )
        renewed = [c.friction for c in problem.contacts]
        for _ in range(_PASSES):
            used, limit_change = [c.offset for c in problem.contacts], 0.0
            for contact, friction in zip(problem.contacts, renewed, strict=True):
                contact.friction = friction
            outcome = self._run(newton, settled)
            if has_friction:
                renewed, limit_change = friction_state.settle(problem, outcome.control)
            change = _update(problem, outcome)
            settles = settled.passes(change, limit_change)
            if settles:
                break
        if change > _UNSETTLED * self.layout.depth:
            raise NoEquilibrium("the contact does not settle: its penetration changes from solve to solve")
        memory = replace(memory, offsets=tuple(c.offset for c in problem.contacts))
        for contact, offset in zip(problem.contacts, used, strict=True):
            contact.offset = offset
        outcome, more = self._polish(newton, outcome, settled)
        if self.sheet.effects.mullins is not None:
            memory = replace(memory, peak=problem.raised_peak(outcome.control))
        if has_friction:
            memory = replace(memory, frictions=friction_state.frictions(problem, outcome.control))
        result = measure(self.layout, newton, outcome, more, memory, settles=settles)
        check(result, problem, outcome)
        return friction_state.without_friction(result, problem) if has_friction else result

    def _polish(self, newton: Newton, outcome: Minimum, settled: StepTest) -> tuple[Minimum, RigidForce]:
        """Return an outcome as exact as a fresh Hessian makes it, and the change of its force by rigid bodies (3,).

        The correction is for frictionless contact, also where there is friction, and belongs to the points that the
        Hessian knows in contact.
        """
        if not (self.settings.exact or self.settings.corrected):
            return outcome, _NONE
        contacts = newton.problem.contacts
        frictions = [c.friction for c in contacts]
        for contact in contacts:
            contact.friction = None
        newton.refresh()
        self.factors += 1
        more = rigid_force(newton, outcome) if self.settings.corrected else _NONE
        for contact, friction in zip(contacts, frictions, strict=True):
            contact.friction = friction
        done = self.settings.exact or self.sheet.effects.friction > 0
        return (outcome if done else self._run(newton, settled)), more


def _update(problem: Problem, outcome: Minimum) -> float:
    """Set each offset to the mean penetration; return the largest change."""
    changes = [0.0]
    for contact, totals in zip(problem.contacts, outcome.evaluation.totals, strict=True):
        new = totals[3] / totals[4] / contact.stiffness if totals[4] > 0 else 0.0
        changes.append(abs(new - contact.offset))
        contact.offset = new
    return max(changes)
