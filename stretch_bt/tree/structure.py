"""What the shape of a task must keep to: no recursion, bounded depth and size, one long action in a reactive composite.

Every tree is looked at once, after those that it calls, however often it is called.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from stretch_bt.errors import Diagnostic
from stretch_bt.source import Mark
from stretch_bt.tree.document import Signature
from stretch_bt.tree.flow import Call, Part
from stretch_bt.tree.flow.groups import Group
from stretch_bt.tree.flow.guard import Guard
from stretch_bt.tree.flow.parallel import Parallel
from stretch_bt.tree.flow.timeout import Timeout
from stretch_bt.tree.tree_body import TreeBody

__all__ = ["MAX_DEPTH", "MAX_NODES", "check_structure"]

MAX_DEPTH = 100
MAX_NODES = 10_000


def check_structure(bodies: Mapping[int, TreeBody], main: Signature | None) -> list[Diagnostic]:
    """Return what is wrong with the shape of these trees, which are given by the id of their signatures."""
    checker = _Structure(bodies)
    for body in bodies.values():
        checker.measure(body)
    if checker.found:  # what follows walks from call to call
        return checker.found
    for body in bodies.values():
        checker.check_reactive(body)
        checker.check_interruption(body, body.part, "")
    if main is not None and id(main) in bodies:
        checker.check_reach(main)
    return checker.found


@dataclass(slots=True)
class _Measure:
    """How deep a tree is and how many nodes it has, its calls included; at which place it is deepest."""

    depth: int = 0
    nodes: int = 0
    long: bool = False
    deepest: Mark | None = None


class _Structure:
    def __init__(self, bodies: Mapping[int, TreeBody]) -> None:
        self.bodies = bodies
        self.found: list[Diagnostic] = []
        self.measures: dict[int, _Measure] = {}
        self.under_way: list[TreeBody] = []
        self.level = 0  # of the place that is measured, counted from where measuring began
        self.interrupted: set[int] = set()

    def measure(self, body: TreeBody) -> _Measure:
        """Measure a tree after those that it calls; note recursion, depth and size."""
        if id(body) in self.measures:
            return self.measures[id(body)]
        made = self.measures[id(body)] = _Measure()
        self.under_way.append(body)
        for root in filter(None, (body.part, body.finish)):
            self.measure_part(root, 1, made)
            made.long = made.long or root.is_long()
        self.under_way.pop()
        if made.depth > MAX_DEPTH and made.deepest is not None:
            self.too_deep(made.deepest)
        if made.nodes > MAX_NODES:
            message = f"tree {body.signature.name!r} has more than {MAX_NODES} nodes, the nodes of its calls included"
            self.once(body.signature.mark.error("size", message, "call fewer trees, or use a loop"))
        return made

    def measure_part(self, part: Part, depth: int, made: _Measure) -> None:
        self.level += 1
        inner = self.measure_call(part) if isinstance(part, Call) else _Measure()
        made.nodes += 1 + inner.nodes
        if depth + inner.depth > made.depth:
            made.depth, made.deepest = depth + inner.depth, part.mark
        for child in part.children():
            self.measure_part(child, depth + 1, made)
        self.level -= 1

    def measure_call(self, call: Call) -> _Measure:
        target = self.bodies.get(id(call.target))
        if target is None:
            return _Measure()
        if target in self.under_way:
            message = f"{call.target.name!r} calls itself, through {self.under_way[-1].signature.name!r}"
            self.error(call.mark, "recursion", message, "use 'until' or 'repeat' with a bound")
            return _Measure()
        if self.level > MAX_DEPTH:
            self.too_deep(call.mark)
            return _Measure()
        inner = self.measure(target)
        call.long = inner.long
        return inner

    def too_deep(self, mark: Mark) -> None:
        message = f"the tree is deeper than {MAX_DEPTH} here"
        self.once(mark.error("depth", message, "flatten nested composites"))

    def once(self, finding: Diagnostic) -> None:
        """Note what is true of every tree that calls a wrong one, at the innermost place only."""
        if all(other.code != finding.code for other in self.found):
            self.found.append(finding)

    def check_reactive(self, body: TreeBody) -> None:
        """A reactive composite asks its conditions again on every tick, and can do so around one long action."""
        for group in body.parts():
            if not isinstance(group, Group) or not group.reactive:
                continue
            long = [part.label for part in group.children() if part.is_long()]
            if len(long) > 1:
                message = f"{group.keyword!r} may hold one long action, found {len(long)} ({', '.join(long)})"
                inner = group.keyword.removeprefix("reactive_")
                self.error(group.mark, "reactive-action", message, f"wrap them in {inner!r}, which goes on where it is")

    def check_interruption(self, body: TreeBody, part: Part, why: str, outermost: bool = True) -> None:
        """A called tree's `finally` needs ticks, so nothing but the end of the run may interrupt the call."""
        if isinstance(part, Call) and why:
            self.check_interrupted_call(part, why)
        reactive = isinstance(part, Group) and part.reactive
        ends_run = isinstance(part, Guard) and outermost and body.signature.name == "main"
        interrupts = reactive or (isinstance(part, Parallel | Timeout | Guard) and not ends_run)
        why = f"{part.keyword!r} (line {part.mark.line})" if interrupts else why
        for child in part.children():
            self.check_interruption(body, child, why, ends_run)

    def check_interrupted_call(self, call: Call, why: str) -> None:
        target = self.bodies.get(id(call.target))
        if target is None:
            return
        if target.finish is not None:
            message = f"{call.label!r} has a 'finally', but {why} may interrupt it here"
            self.error(call.mark, "finally", message, "move the 'finally' to 'main'")
        elif id(target) not in self.interrupted:
            self.interrupted.add(id(target))
            self.check_interruption(target, target.part, why)

    def check_reach(self, main: Signature) -> None:
        """Every tree of the file must be called, by however many others."""
        reached: set[int] = set()
        ahead = [main]
        while ahead:
            signature = ahead.pop()
            body = self.bodies.get(id(signature))
            if id(signature) not in reached and body is not None:
                ahead += [call.target for call in body.calls()]
            reached.add(id(signature))
        for signature in main.document.trees.values():
            if id(signature) not in reached:
                message = f"tree {signature.name!r} is never called from 'main'"
                self.error(signature.mark, "unreachable", message, "call it, or remove it")

    def error(self, mark: Mark, code: str, message: str, hint: str) -> None:
        self.found.append(mark.error(code, message, hint))
