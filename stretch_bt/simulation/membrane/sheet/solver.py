"""A press of the sheet from start to checked result."""

from __future__ import annotations

import math
import time
from dataclasses import replace

import numpy as np

from stretch_bt.errors import NoEquilibrium
from stretch_bt.simulation.membrane.indenters import distance_kernel  # noqa: F401  compiled before the clock starts
from stretch_bt.simulation.membrane.indenters.base import Zone
from stretch_bt.simulation.membrane.indenters.placed import Placed, place
from stretch_bt.simulation.membrane.sheet import start as starts
from stretch_bt.simulation.membrane.sheet.bending import Bending
from stretch_bt.simulation.membrane.sheet.check import check, measure
from stretch_bt.simulation.membrane.sheet.clamps import check_clamps
from stretch_bt.simulation.membrane.sheet.error_law import relative_error
from stretch_bt.simulation.membrane.sheet.geometry import Sheet
from stretch_bt.simulation.membrane.sheet.march import increments
from stretch_bt.simulation.membrane.sheet.mesh import Mesh, breakpoints
from stretch_bt.simulation.membrane.sheet.newton import Done, Newton, Outcome, Step
from stretch_bt.simulation.membrane.sheet.problem import Contact, Problem
from stretch_bt.simulation.membrane.sheet.reach import BudgetSpent, reach
from stretch_bt.simulation.membrane.sheet.result import Load, Memory, SheetPress
from stretch_bt.simulation.membrane.sheet.settings import Settings
from stretch_bt.simulation.membrane.sheet.spline import Array, Axis
from stretch_bt.simulation.membrane.sheet.threads import one_thread

__all__ = ["solve"]

_SHALLOW = 2.0  # sheet units; a round tip pressed less than this touches less than the default elements resolve
_DRIFT = 1.5  # finest elements that a contact may move before the mesh follows
_PASSES = 8
_SLID = {True: 1e-3, False: 5e-2}  # change of the limits of friction between passes that counts as settled, if exact
_SLACK = 0.003  # strain between the clamps
_COARSE = 2.5
_ATTEMPT, _SLACK_ATTEMPT = 0.1, 0.3  # of the budget
_SETTLED = 1e-3  # what a press that is not exact leaves over on the default mesh: of the force, of the offset per depth
_LOOSEST = 2.0


def solve(sheet: Sheet, load: Load, settings: Settings, start: SheetPress | None = None) -> SheetPress:
    """Return the equilibrium of a sheet under a load, from flat or from an earlier press, which stays as it is.

    Raises
    ------
    InvalidInput
        The load or the settings make no sense.
    NoEquilibrium
        There is none, or none was found within the budget; the reason says which.
    """
    check_clamps(sheet, place(load.indenter, load.at, load.tilt, load.depth), sheet.span(load.stretch))
    with one_thread():
        if sheet.effects.friction:
            return _march(sheet, load, settings, start)
        return _solve(sheet, load, settings, start)


def _solve(sheet: Sheet, load: Load, settings: Settings, start: SheetPress | None) -> SheetPress:
    work = _Work(sheet, load, settings)
    try:
        solved = work.warm(start) if start is not None and start.sheet == sheet else work.cold()
    except NoEquilibrium as failure:
        solved = _again(work, failure, start)
    return replace(solved, iterations=work.spent, factors=work.factors, seconds=time.process_time() - work.began)


def _march(sheet: Sheet, load: Load, settings: Settings, start: SheetPress | None) -> SheetPress:
    """Return the end of a path of presses, which friction remembers; cold or warm, each has the whole budget."""
    began, iterations, factors = time.process_time(), 0, 0
    here = start if start is not None and start.sheet == sheet and start.load.indenter == load.indenter else None
    for target in increments(here.load if here else None, load, sheet.unit):
        work = _Work(sheet, target, settings)
        here = work.cold() if here is None else work.warm(here)
        iterations, factors = iterations + work.spent, factors + work.factors
    assert here is not None
    return replace(here, iterations=iterations, factors=factors, seconds=time.process_time() - began)


def _again(work: _Work, failure: NoEquilibrium, start: SheetPress | None) -> SheetPress:
    """Solve cold what a warm start has not reached, and step by step what a cold one has not."""
    if start is not None:
        try:
            return work.cold()
        except NoEquilibrium as none:
            failure = none
    return reach(work.part, failure)


class _Work:
    """One solve under way."""

    def __init__(self, sheet: Sheet, load: Load, settings: Settings) -> None:
        self.began = time.process_time()
        self.sheet, self.load, self.settings = sheet, load, settings
        self.bodies: tuple[Placed, ...] = place(load.indenter, load.at, load.tilt, load.depth)
        self.span, self.unit = sheet.span(load.stretch), sheet.unit
        self.spent = self.factors = 0
        self.limit = settings.budget
        self.slack = self.span / 100 - 1 < _SLACK
        self.zones = [self._zones(body) for body in self.bodies]
        self.finest = min(z.size for pair in self.zones for zones in pair for z in zones)

    def _allow(self, share: float) -> None:
        """Let the next attempt have a share of the budget, as far as it is not spent."""
        whole = self.settings.budget
        self.limit = min(self.spent + max(int(share * whole), 1), whole)

    def part(self, share: float, start: SheetPress | None) -> SheetPress:
        """Solve at a share of the depth from a shallower press, or cold, with what is left of the budget."""
        left = self.settings.budget - self.spent
        if left < 1:
            raise BudgetSpent
        settings = replace(self.settings, exact=self.settings.exact and share == 1.0)
        work = _Work(self.sheet, replace(self.load, depth=share * self.load.depth), settings)
        work.spent = self.spent
        try:
            return work.warm(start) if start is not None else work.cold()
        finally:
            self.spent, self.factors = work.spent, self.factors + work.factors

    def cold(self) -> SheetPress:
        """Solve from the flat sheet; a slack one, which takes many iterations, on a coarse mesh first."""
        if not self.slack or self._scale() > _COARSE / 2:
            self._allow(_SLACK_ATTEMPT if self.slack else _ATTEMPT)
            return self._from_flat()
        settings = replace(self.settings, coarsen=self.settings.coarsen * _COARSE / self._scale(), exact=False)
        rough = _Work(self.sheet, self.load, settings)
        rough.spent = self.spent
        try:
            start = rough.cold()
        finally:
            self.spent, self.factors = rough.spent, self.factors + rough.factors
        return self.warm(start)

    def _from_flat(self) -> SheetPress:
        """Solve from the flat sheet, by way of a tent."""
        mesh = self._mesh()
        flat = Newton(self._problem(mesh, (), flat=True), starts.flat_guess(mesh, self.span))
        level = self._run(flat, lambda step: step.size < 1e-2)
        problem = self._problem(mesh, ())
        newton = Newton(problem, starts.tent(level.control, self.bodies, self.span, self.unit))
        self._update(problem, self._run(newton, lambda step: step.size < 3e-2))
        return self._finish(newton, Memory(()))

    def warm(self, start: SheetPress) -> SheetPress:
        """Solve from an earlier press."""
        self._allow(_SLACK_ATTEMPT if self.slack else _ATTEMPT)
        change = self.load.moves() - start.load.moves()
        old = start.shape.control
        if self._fits(start):
            mesh = start.shape.mesh
            drift = start.memory.drift + float(np.abs(change[2:4]).max()) / self.unit
        else:
            mesh, drift = self._mesh(), 0.0
            old = starts.carried(start.shape.mesh, old, mesh)
            start = replace(start, memory=replace(start.memory, previous=None, offsets=self._rescaled(start)))
        control, offsets = self._predict(start, old, change)
        problem = self._problem(mesh, offsets, start)
        memory = Memory((), old, start.memory.offsets, change, drift)
        return self._finish(Newton(problem, starts.clamped(mesh, control, self.span)), memory)

    def _predict(self, start: SheetPress, old: Array, change: Array) -> tuple[Array, tuple[float, ...]]:
        """Return control points and offsets on the straight line through the last two presses, else scaled ones."""
        memory = start.memory
        ratio = _ratio(change, memory.change)
        if ratio is not None and memory.previous is not None and memory.previous_offsets is not None:
            pairs = zip(memory.offsets, memory.previous_offsets, strict=True)
            offsets = tuple(max(o + ratio * (o - p), 0.0) for o, p in pairs)
            return old + ratio * (old - memory.previous), offsets
        scaled = old.copy()
        scaled[..., 1] *= self.span / self.sheet.span(start.load.stretch)
        scaled[..., 2] *= self.load.depth / start.load.depth
        return scaled, memory.offsets

    def _rescaled(self, start: SheetPress) -> tuple[float, ...]:
        """Return the offsets of an earlier press for the stiffness of the contacts on a new mesh."""
        old = [o * c.stiffness for o, c in zip(start.memory.offsets, start.contacts, strict=True)]
        if len(old) != len(self.bodies):
            return tuple(0.0 for _ in self.bodies)
        return tuple(p / k for p, k in zip(old, self._stiffnesses(), strict=True))

    def _fits(self, start: SheetPress) -> bool:
        """Whether the mesh of an earlier press still suits this contact."""
        drift = np.abs(np.subtract(self.load.at, start.load.at)).max() / self.unit + start.memory.drift
        same = (start.load.indenter, start.load.tilt) == (self.load.indenter, self.load.tilt)
        same = same and start.settings.elements == self.settings.elements
        level = self._refinement(start.load.depth) == self._refinement(self.load.depth)
        return same and level and bool(drift <= _DRIFT * start.shape.mesh.finest)

    def _refinement(self, depth: float) -> int:
        """Return how often the elements are halved for a shallow press."""
        return max(0, math.ceil(math.log2(math.sqrt(_SHALLOW * self.unit / depth)) - 1e-9))

    def _zones(self, body: Placed) -> tuple[list[Zone], list[Zone]]:
        """Return zones on the unstretched sheet, sheet units; widths and sizes are kept, places are carried back."""
        length = self.span / 100
        finer = 0.5 ** self._refinement(self.load.depth) if body.indenter.flat == 0 else 1.0
        both = []
        for zones, scale in zip(body.zones(self.sheet.gauge), (length**0.55, 1 / length), strict=True):
            spans = ((scale * (z.low + z.high) / 2, (z.high - z.low) / 2, z.size) for z in zones)
            narrow = finer if body.indenter.flat == 0 else 1.0
            both.append(
                [
                    Zone((m - h * narrow) / self.unit, (m + h * narrow) / self.unit, s * finer / self.unit)
                    for m, h, s in spans
                ]
            )
        return both[0], both[1]

    def _scale(self) -> float:
        """Return by how much the chosen elements are to be scaled."""
        mesh = self.settings.mesh
        return self.settings.coarsen * (1.0 if mesh is None else mesh / self.unit / self.finest)

    def _mesh(self) -> Mesh:
        x, y = ([z for pair in self.zones for z in pair[side]] for side in (0, 1))
        scale = self._scale()
        x, y = ([z._replace(size=z.size * scale) for z in zones] for zones in (x, y))
        growth, sheet = self.settings.growth, self.sheet
        across, along = breakpoints(sheet.width / self.unit, x, growth), breakpoints(100.0, y, growth)
        return Mesh(Axis(across), Axis(along))

    def _problem(
        self, mesh: Mesh, offsets: tuple[float, ...], past: SheetPress | None = None, *, flat: bool = False
    ) -> Problem:
        contacts = [] if flat else [Contact(b, k) for b, k in zip(self.bodies, self._stiffnesses(), strict=True)]
        for contact, offset in zip(contacts, offsets, strict=False):
            contact.offset = offset
        sheet, effects = self.sheet, self.sheet.effects
        problem = Problem(mesh, sheet.law(), contacts, self.unit, flat=flat)
        problem.weight = sheet.weight
        if effects.bending:
            problem.bending = Bending.of(mesh, (sheet.thickness / self.unit) ** 2 / 3)
        if effects.mullins is not None:
            problem.peak = np.zeros((mesh.y.elements, mesh.x.elements, 2, 2)) if past is None else _peak(past, mesh)
        if effects.friction and past is not None:
            from stretch_bt.simulation.membrane.sheet import friction_state

            friction_state.resume(problem, past, effects.friction)
        return problem

    def _stiffnesses(self) -> list[float]:
        """Return each body's pressure per penetration: tension then settles over about one element at the contact's edge."""
        scale = self._scale()
        factor = 4.5 * (scale**-2 if scale < 1 else 1 / scale)
        return [factor / min(z.size for zones in pair for z in zones) ** 2 for pair in self.zones]

    def _run(self, newton: Newton, done: Done) -> Outcome:
        iterations, factors = newton.iterations, newton.factors
        try:
            return newton.run(done, self.limit - self.spent)
        finally:
            self.spent += newton.iterations - iterations
            self.factors += newton.factors - factors

    def _update(self, problem: Problem, outcome: Outcome) -> float:
        """Set each offset to the mean penetration; return the largest change."""
        changes = [0.0]
        for contact, totals in zip(problem.contacts, outcome.evaluation.totals, strict=True):
            new = totals[3] / totals[4] / contact.stiffness if totals[4] > 0 else 0.0
            changes.append(abs(new - contact.offset))
            contact.offset = new
        return max(changes)

    def _finish(self, newton: Newton, memory: Memory) -> SheetPress:
        """Solve, and while exactness asks for it set the offsets anew and solve again."""
        if self.sheet.effects.friction:
            from stretch_bt.simulation.membrane.sheet import friction_state
        depth, outcome, problem = self.load.depth / self.unit, None, newton.problem
        loose = _SETTLED * min(_LOOSEST, self._scale() ** 2)  # in step with the mesh
        rubs, exact = [c.rub for c in problem.contacts], self.settings.exact
        for _ in range(_PASSES):
            used = [c.offset for c in problem.contacts]
            for contact, rub in zip(problem.contacts, rubs, strict=True):
                contact.rub = rub
            outcome = self._run(newton, _Settled(depth, loose, exact))
            change, slid = self._update(problem, outcome), 0.0
            if self.sheet.effects.friction:
                rubs, slid = friction_state.settle(problem, outcome.control)
            if slid < _SLID[exact] and change < (1e-4 if exact else loose) * depth:
                break
        assert outcome is not None
        peak = problem.raised_peak(outcome.control) if self.sheet.effects.mullins is not None else None
        memory = replace(memory, offsets=tuple(c.offset for c in problem.contacts), peak=peak)
        for contact, offset in zip(problem.contacts, used, strict=True):
            contact.offset = offset
        if self.sheet.effects.friction:
            memory = replace(memory, grips=friction_state.grips(problem, outcome.control))
        result = measure(self.sheet, self.load, self.settings, problem, outcome, memory, self._error(outcome))
        check(result, problem, outcome)
        return friction_state.without_friction(result, problem, slid) if self.sheet.effects.friction else result

    def _error(self, outcome: Outcome) -> float:
        nodes = int(outcome.evaluation.totals[:, 5].sum())
        flat = any(b.indenter.flat > 0 for b in self.bodies)
        exact, rubs = self.settings.exact, self.sheet.effects.friction > 0
        strain, at_edge = self.span / 100 - 1, self._at_edge()
        return relative_error(self._scale(), strain, nodes, flat=flat, at_edge=at_edge, exact=exact, rubs=rubs)

    def _at_edge(self) -> bool:
        """Whether an edge of the sheet may be within a contact, or next to it: closer than the small elements or a depth."""
        depth, halves = self.load.depth / self.unit, (self.sheet.width / self.unit / 2, 50.0)
        return any(
            max(abs(z.low), abs(z.high), abs(z.low + z.high) / 2 + depth) > half
            for pair in self.zones
            for zones, half in zip(pair, halves, strict=True)
            for z in zones
        )


class _Settled:
    """Whether a step was the last: by its size, by the energy left, and where exact also by the balance of forces.

    The energy clause matters: slack corners creep for tens of iterations and change no force.
    """

    def __init__(self, depth: float, loose: float, exact: bool) -> None:
        self.depth, self.loose, self.exact = depth, loose, exact
        self.small = 2 * loose * min(1.0, depth)

    def __call__(self, step: Step) -> bool:
        force, before = step.after.force[2], step.before.force[2]
        calm = abs(force - before) < self.loose * abs(force)
        little = -step.promise < 0.03 * self.loose * abs(force) * max(self.depth, 1.0)
        settled = step.size < self.small or (calm and (step.size < 10 * self.small or little))
        if not settled or not self.exact:
            return bool(settled)
        left = step.after.gradient[1:-1].sum(axis=(0, 1))
        return bool(np.linalg.norm(left) <= 1e-7 * np.linalg.norm(step.after.force))


def _peak(past: SheetPress, mesh: Mesh) -> Array:
    """Return the largest energy seen at each Gauss point of a mesh, from the elements of an earlier press."""
    x, y = mesh.strain
    old = past.shape.mesh
    assert past.memory.peak is not None
    if old is mesh:
        return past.memory.peak.copy()
    ex, ey = old.x.locate(x.place), old.y.locate(y.place)
    return np.ascontiguousarray(past.memory.peak.max(axis=(2, 3))[ey[:, None, :, None], ex[None, :, None, :]])


def _ratio(change: Array, before: Array | None) -> float | None:
    """Return how many times the last change this one is, None where it leads elsewhere or too far."""
    if before is None or not np.any(before):
        return None
    ratio = float(change @ before / (before @ before))
    straight = np.abs(change - ratio * before).max() <= 1e-6 * np.abs(before).max()
    return ratio if straight and abs(ratio) <= 2 else None
