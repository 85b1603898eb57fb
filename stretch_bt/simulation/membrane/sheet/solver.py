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
from stretch_bt.simulation.membrane.sheet.error_law import relative_error
from stretch_bt.simulation.membrane.sheet.geometry import Sheet
from stretch_bt.simulation.membrane.sheet.mesh import Mesh
from stretch_bt.simulation.membrane.sheet.newton import Done, Outcome, Step, minimise
from stretch_bt.simulation.membrane.sheet.problem import Contact, Problem
from stretch_bt.simulation.membrane.sheet.result import Load, Memory, SheetPress
from stretch_bt.simulation.membrane.sheet.settings import Settings
from stretch_bt.simulation.membrane.sheet.spline import Array
from stretch_bt.simulation.membrane.sheet.threads import one_thread

__all__ = ["solve"]

_SHALLOW = 2.0  # sheet units; a round tip pressed less than this touches less than the default elements resolve
_DRIFT = 1.5  # finest elements that a contact may move before the mesh follows
_PASSES = 8


def solve(sheet: Sheet, load: Load, settings: Settings, start: SheetPress | None = None) -> SheetPress:
    """Return the equilibrium of a sheet under a load, from flat or from an earlier press, which stays as it is.

    Raises
    ------
    InvalidInput
        The load or the settings make no sense.
    NoEquilibrium
        There is none, or none was found within the budget; the reason says which.
    """
    with one_thread():
        return _solve(sheet, load, settings, start)


def _solve(sheet: Sheet, load: Load, settings: Settings, start: SheetPress | None) -> SheetPress:
    began = time.process_time()
    work = _Work(sheet, load, settings, began)
    if start is not None and start.sheet == sheet:
        try:
            return work.warm(start)
        except NoEquilibrium:
            work.reset()
    return work.cold()


class _Work:
    """One solve under way."""

    def __init__(self, sheet: Sheet, load: Load, settings: Settings, began: float) -> None:
        self.sheet, self.load, self.settings, self.began = sheet, load, settings, began
        self.bodies: tuple[Placed, ...] = place(load.indenter, load.at, load.tilt, load.depth)
        self.span, self.unit = sheet.span(load.stretch), sheet.unit
        self.spent = self.factors = 0
        self.limit = settings.budget

    def reset(self) -> None:
        """Give a cold start a budget of its own after a warm one has failed."""
        self.limit = self.spent + self.settings.budget

    def cold(self) -> SheetPress:
        """Solve from the flat sheet, by way of a tent."""
        mesh = self._mesh()
        flat = self._problem(mesh, (), flat=True)
        level = self._minimise(flat, self.sheet.outline.flat(mesh, self.span), lambda step: step.size < 1e-2)
        problem = self._problem(mesh, ())
        control = self.sheet.outline.tent(level.control, self.bodies, self.span, self.unit)
        rough = self._minimise(problem, control, lambda step: step.size < 3e-2)
        self._update(problem, rough)
        return self._finish(problem, rough.control, Memory(()))

    def warm(self, start: SheetPress) -> SheetPress:
        """Solve from an earlier press."""
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
        return self._finish(problem, self.sheet.outline.clamped(mesh, control, self.span), memory)

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
        return tuple(p / self._stiffness(b) for p, b in zip(old, self.bodies, strict=True))

    def _fits(self, start: SheetPress) -> bool:
        """Whether the mesh of an earlier press still suits this contact."""
        drift = np.abs(np.subtract(self.load.at, start.load.at)).max() / self.unit + start.memory.drift
        same = start.load.indenter == self.load.indenter and start.load.tilt == self.load.tilt
        level = self._refinement(start.load.depth) == self._refinement(self.load.depth)
        return same and level and bool(drift <= _DRIFT * start.shape.mesh.finest)

    def _refinement(self, depth: float) -> int:
        """Return how often the elements are halved for a shallow press."""
        return max(0, math.ceil(math.log2(math.sqrt(_SHALLOW * self.unit / depth)) - 1e-9))

    def _zones(self, body: Placed) -> tuple[list[Zone], list[Zone]]:
        """Return zones on the unstretched sheet, sheet units; widths and sizes are kept, places are carried back."""
        finer = 0.5 ** self._refinement(self.load.depth) if body.indenter.flat == 0 else 1.0
        both, back = [], self.sheet.outline.back(self.span / 100)
        for zones, scale in zip(body.zones(self.sheet.gauge), back, strict=True):
            spans = ((scale * (z.low + z.high) / 2, (z.high - z.low) / 2, z.size) for z in zones)
            narrow = finer if body.indenter.flat == 0 else 1.0
            both.append(
                [
                    Zone((m - h * narrow) / self.unit, (m + h * narrow) / self.unit, s * finer / self.unit)
                    for m, h, s in spans
                ]
            )
        return both[0], both[1]

    def _scale(self, finest: float) -> float:
        """Return by how much the chosen elements are to be scaled."""
        return self.settings.coarsen * (1.0 if self.settings.mesh is None else self.settings.mesh / self.unit / finest)

    def _mesh(self) -> Mesh:
        pairs = [self._zones(body) for body in self.bodies]
        x, y = [z for p in pairs for z in p[0]], [z for p in pairs for z in p[1]]
        scale = self._scale(min(z.size for z in x + y))
        x, y = ([z._replace(size=z.size * scale) for z in zones] for zones in (x, y))
        return self.sheet.outline.mesh(self.sheet.width / self.unit, x, y, self.settings.growth)

    def _problem(
        self, mesh: Mesh, offsets: tuple[float, ...], past: SheetPress | None = None, *, flat: bool = False
    ) -> Problem:
        contacts = [] if flat else [Contact(b, self._stiffness(b)) for b in self.bodies]
        for contact, offset in zip(contacts, offsets, strict=False):
            contact.offset = offset
        sheet, effects = self.sheet, self.sheet.effects
        problem = Problem(mesh, sheet.law(), contacts, self.unit, flat=flat)
        problem.weight = sheet.weight
        if effects.bending:
            problem.bending = Bending.of(mesh, (sheet.thickness / self.unit) ** 2 / 3)
        if effects.mullins is not None:
            problem.peak = np.zeros((mesh.y.elements, mesh.x.elements, 2, 2)) if past is None else _peak(past, mesh)
        return problem

    def _stiffness(self, body: Placed) -> float:
        """Return the pressure per penetration: tension then settles over about one element at the contact's edge."""
        size = min(z.size for zones in self._zones(body) for z in zones)
        finest = min(z.size for b in self.bodies for zones in self._zones(b) for z in zones)
        scale = self._scale(finest)
        return 4.5 / size**2 * (scale**-2 if scale < 1 else 1 / scale)

    def _minimise(self, problem: Problem, control: Array, done: Done) -> Outcome:
        outcome = minimise(problem, control, done, self.limit - self.spent)
        self.spent += outcome.iterations
        self.factors += outcome.factors
        return outcome

    def _update(self, problem: Problem, outcome: Outcome) -> float:
        """Set each offset to the mean penetration; return the largest change."""
        changes = [0.0]
        for contact, totals in zip(problem.contacts, outcome.evaluation.totals, strict=True):
            new = totals[3] / totals[4] / contact.stiffness if totals[4] > 0 else 0.0
            changes.append(abs(new - contact.offset))
            contact.offset = new
        return max(changes)

    def _finish(self, problem: Problem, control: Array, memory: Memory) -> SheetPress:
        """Solve, and while exactness asks for it set the offsets anew and solve again."""
        depth, outcome = self.load.depth / self.unit, None
        for _ in range(_PASSES):
            used = [c.offset for c in problem.contacts]
            outcome = self._minimise(problem, control, _Settled(depth, self.settings.exact))
            control = outcome.control
            change = self._update(problem, outcome)
            if not self.settings.exact or change < 1e-4 * depth:
                break
        assert outcome is not None
        peak = problem.raised_peak(control) if self.sheet.effects.mullins is not None else None
        memory = replace(memory, offsets=tuple(c.offset for c in problem.contacts), peak=peak)
        for contact, offset in zip(problem.contacts, used, strict=True):
            contact.offset = offset
        result = measure(self.sheet, self.load, problem, outcome, memory, self._error(outcome))
        check(result, problem, outcome)
        seconds = time.process_time() - self.began
        return replace(result, iterations=self.spent, factors=self.factors + result.factors, seconds=seconds)

    def _error(self, outcome: Outcome) -> float:
        finest = min(z.size for b in self.bodies for zones in self._zones(b) for z in zones)
        nodes = int(outcome.evaluation.totals[:, 5].sum())
        flat = any(b.indenter.flat > 0 for b in self.bodies)
        return relative_error(self._scale(finest), self.span / 100 - 1, nodes, flat=flat, exact=self.settings.exact)


class _Settled:
    """Whether a step was the last: by its size, by the energy left, and where exact also by the balance of forces.

    The energy clause matters: slack corners creep for tens of iterations and change no force.
    """

    def __init__(self, depth: float, exact: bool) -> None:
        self.depth, self.exact = depth, exact
        self.small = 2e-3 * min(1.0, depth)

    def __call__(self, step: Step) -> bool:
        force, before = step.after.force[2], step.before.force[2]
        calm = abs(force - before) < 1e-3 * abs(force)
        little = -step.promise < 3e-5 * abs(force) * max(self.depth, 1.0)
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
