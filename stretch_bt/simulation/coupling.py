"""Membrane and object in series: the hand's travel is shared between the two until their forces agree."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

from stretch_bt.errors import InvalidInput, NoEquilibrium
from stretch_bt.simulation.objects.response import Law

__all__ = ["Equilibrium", "couple"]

BUDGET = 60
_CLOSE = 1e-10  # tolerance of the logarithm of the ratio of forces, and of the bracket of drops
_HALVINGS = 20
_LEVEL = 1e-14  # relative width at which a bracket of logits is closed
_FAR = 200.0  # largest logit of the share that the object takes
_LONG = 0.2  # part of the depth from which a step is long
_SHRINK = 0.5  # a step that leaves more than this of the residual is followed by one that splits the bracket


class Equilibrium(NamedTuple):
    """Depth of the membrane and drop of the object, m, their common force, N, and the evaluations it took.

    `jumped` says that the object snapped through: its drop went past one at which its force falls.
    """

    depth: float
    drop: float
    force: float
    iterations: int
    jumped: bool = False


def couple(
    membrane: Law,
    thing: Law,
    travel: float,
    *,
    rest: float = 0.0,
    start: float | None = None,
    kinks: Sequence[float] = (),
    close: float = _CLOSE,
    near: float | None = None,
) -> Equilibrium:
    """Return the equilibrium of the membrane and an object pressed together by `travel`.

    The unknown is the share of the travel that the object takes. As a function of its logit the logarithm of the ratio of both
    forces is nearly a straight line, whatever power laws they follow and whatever the ratio of their stiffnesses, so Newton's
    method takes a few steps; a bracket guards it. A staggered iteration would fail over half of the range of stiffness ratios.

    Parameters
    ----------
    membrane
        Returns force, N, and its derivative, N/m, at a depth, m; 0 at a depth of 0, and rising.
    thing
        The same for the object, by the drop of its top, m.
    travel
        How far the hand is past first contact with the object at no drop, m.
    rest
        Drop up to which the object stays down by itself, m: where its force begins.
    start
        Drop before, m, where the object's force is not monotone: the equilibrium that is reached from there as the drop grows,
        or shrinks, without passing another one. `rest` when None.
    kinks
        Drops at which the slope of the object's force jumps, m; between them the force is smooth and monotone.
    close
        How well forces and drops need to agree, as a part of each.
    near
        A drop to begin at, m, where one is known to be close.

    Raises
    ------
    InvalidInput
        A travel or a rest that is not a finite length of at least 0 m.
    NoEquilibrium
        No convergence within the budget.
    """
    if not (math.isfinite(travel) and travel >= 0 and math.isfinite(rest) and rest >= 0):
        raise InvalidInput(f"travel and rest must be lengths of at least 0 m, not {travel} m and {rest} m")
    if travel <= rest:
        return Equilibrium(0.0, travel, 0.0, 0)
    solve = _Series(membrane, thing, travel, close, near)
    inside = [kink for kink in sorted(kinks) if rest < kink < travel]
    if not inside:
        return solve.between(rest, travel)
    return solve.reached([rest, *inside, travel], min(max(start or rest, rest), travel))


class _Series:
    """Both laws at one travel, and how often they were asked."""

    def __init__(self, membrane: Law, thing: Law, travel: float, close: float, near: float | None) -> None:
        self.membrane, self.thing, self.travel, self.close = membrane, thing, travel, close
        self.near = near
        self.spent = 0

    def pull(self, drop: float) -> float:
        """Return the membrane's force less the object's at a drop, N.

        0 where both agree but for `close`: rounding does not decide from which side a kink is reached.
        """
        self.spent += 1
        pressed, held = self.membrane(self.travel - drop)[0], self.thing(drop)[0]
        return 0.0 if abs(pressed - held) <= self.close * pressed else pressed - held

    def reached(self, ends: Sequence[float], start: float) -> Equilibrium:
        """Return the first equilibrium on the way from `start`, by the pieces between ends."""
        pull = self.pull(start) if start > ends[0] else math.inf
        if pull == 0:
            return self._at(start)
        grows = pull > 0
        pieces = [(a, b) for a, b in pairwise(ends) if (b > start if grows else a < start)]
        jumped = False
        for piece in pieces if grows else reversed(pieces):
            low, high = (max(piece[0], start), piece[1]) if grows else (piece[0], min(piece[1], start))
            end = high if grows else low
            # at the last end the membrane is free, at the first one the object
            pull = -math.inf if grows and end == ends[-1] else math.inf if end == ends[0] else self.pull(end)
            if pull == 0:
                return self._at(end)._replace(jumped=jumped)
            if grows == (pull < 0):
                return self.between(low, high)._replace(jumped=jumped)
            falls = self.thing((low + high) / 2)[1] < 0
            dip = self._dip(low, high) if falls and grows else None
            if dip is not None:
                return self.between(low, dip)._replace(jumped=jumped)
            jumped = jumped or falls
        raise NoEquilibrium("membrane and object in series: no equilibrium within the travel")

    def _at(self, drop: float) -> Equilibrium:
        """Return the equilibrium at a drop at which both forces agree."""
        depth = self.travel - drop
        return Equilibrium(depth, drop, self.membrane(depth)[0], self.spent)

    def _dip(self, low: float, high: float) -> float | None:
        """Return a drop on a falling piece at which the object holds for a while, though at neither end, None without one.

        The pull is convex there: its rate is brought to nothing by bisection, until the pull is below 0 or cannot be.
        """
        for _ in range(_HALVINGS):
            drop = (low + high) / 2
            (pressed, steep), (held, stiff) = self.membrane(self.travel - drop), self.thing(drop)
            self.spent += 1
            pull, rate = pressed - held, -steep - stiff
            if pull <= 0:
                return drop
            least = pull - abs(rate) * (high - low) / 2
            if least > 0:
                return None
            low, high = (drop, high) if rate < 0 else (low, drop)
        return None

    def between(self, low: float, high: float) -> Equilibrium:
        """Return the equilibrium between two drops, at which the membrane presses harder and less hard."""
        if self.thing(low)[0] > 0:
            return self._within(low, high)
        width, left, right = high - low, -_FAR, _FAR
        near = self.near
        known = near is not None and low < near < high
        logit = math.log((near - low) / (high - near)) if near is not None and known else self._guess(low, high)
        before = math.inf
        while self.spent < BUDGET:
            drop = low + width * _share(logit)
            depth = (self.travel - high) + width * _share(-logit)  # without cancellation
            (pressed, steep), (held, stiff) = self.membrane(depth), self.thing(drop)
            self.spent += 1
            residual = _ratio(pressed, held)
            left, right = (logit, right) if residual > 0 else (left, logit)
            lever = width * _share(logit) * _share(-logit)
            slope = -lever * (steep / pressed + stiff / held) if pressed > 0 and held > 0 else 0.0
            step = -residual / slope if slope < 0 and math.isfinite(residual) else math.inf
            settled = abs(residual) < self.close or abs(step) * lever <= self.close * min(depth, drop)
            narrow = (right - left) * lever <= self.close * min(depth, drop)  # as where a solver's force is not smooth
            if settled or narrow or right - left < _LEVEL * max(abs(left), 1.0):  # or where the object's force jumps
                return Equilibrium(depth, drop, pressed, self.spent)
            logit = self._next(logit, step, left, right, slow=abs(residual) > _SHRINK * before)
            before = abs(residual)
        raise NoEquilibrium(f"membrane and object in series: no convergence within {BUDGET} evaluations")

    def _within(self, low: float, high: float) -> Equilibrium:
        """Return the equilibrium on a piece that begins with a force, by Newton's method from its begin, held in the bracket.

        A long step goes by the logarithms of depth and forces, in which a soft object is a straight line.
        """
        drop, least = low, self.close * (high - low)
        while self.spent < BUDGET:
            depth = self.travel - drop
            (pressed, steep), (held, stiff) = self.membrane(depth), self.thing(drop)
            self.spent += 1
            low, high = (drop, high) if pressed > held else (low, drop)
            step = (pressed - held) / (steep + stiff) if steep + stiff > 0 else math.inf
            # the bracket closes where a solver's force jumps, and at once where the object holds harder than it is pressed
            if abs(step) <= least or high - low <= least:
                return Equilibrium(depth, drop, pressed, self.spent)
            if abs(step) > _LONG * depth and pressed > 0 and held > 0:
                power = (steep / pressed + stiff / held) * depth
                step = -depth * math.expm1(-math.log(pressed / held) / power) if power > 0 else math.inf
            following = drop + step
            drop = following if low <= following <= high else (low + high) / 2
        raise NoEquilibrium(f"membrane and object in series: no convergence within {BUDGET} evaluations")

    def _next(self, logit: float, step: float, left: float, right: float, *, slow: bool) -> float:
        following = logit + step
        return following if left < following < right and not slow else (left + right) / 2

    def _guess(self, low: float, high: float) -> float:
        """Return the logit that power laws through both ends and through the middle would have."""
        depth, drop = self.travel - low, high
        (pressed, steep), (held, stiff) = self.membrane(depth), self.thing(drop)
        self.spent += 1
        if pressed <= 0 or held <= 0 or steep <= 0 or stiff <= 0:
            return 0.0
        p, q = steep * depth / pressed, stiff * (high - low) / held
        ratio = math.log(pressed / held)
        return min(max(ratio / (q if ratio < 0 else p), -_FAR), _FAR)


def _share(logit: float) -> float:
    """Return 1 / (1 + exp(-logit))."""
    return 1 / (1 + math.exp(-logit)) if logit >= 0 else math.exp(logit) / (1 + math.exp(logit))


def _ratio(pressed: float, held: float) -> float:
    """Return the logarithm of the ratio of two forces of at least 0; infinite where one of them is 0."""
    if pressed <= 0 and held <= 0:
        return 0.0
    if held <= 0:
        return math.inf
    return -math.inf if pressed <= 0 else math.log(pressed / held)
