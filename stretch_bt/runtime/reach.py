"""What a tree can ask of a cell, held against the limits of that cell before anything moves."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

from stretch_bt.errors import CellError, Diagnostic, StretchError
from stretch_bt.hardware.cell_file import CellSpec
from stretch_bt.quantity_text import format_apart, format_quantity
from stretch_bt.runtime.contact_force import hard_contact
from stretch_bt.runtime.context import RunContext
from stretch_bt.runtime.held_force import HELD, unheld_force
from stretch_bt.source import Mark
from stretch_bt.tree.build import Builder, build
from stretch_bt.tree.cell import MISSING
from stretch_bt.tree.document import Param
from stretch_bt.tree.flow import Call, Leaf, Part, Wire
from stretch_bt.tree.port import Port, Role
from stretch_bt.tree.program import Program, load_program
from stretch_bt.units import KINDS

__all__ = ["beyond_cell", "check_devices"]

_ROUNDING = 1e-9
_NAME = re.compile(r"[^\W\d]\w*")


def beyond_cell(program: Program, spec: CellSpec, load: str | Path) -> list[Diagnostic]:
    """Return where a tree without errors asks for what a cell does not have or does not allow.

    A value that is known at load gives an error. A value known only in the run gives a warning where the port takes more than the
    cell allows; so does a param at an end of its range, for which the file `load` is read again.

    Heights, and places that follow from where the hand is, are known in the run alone: of them only lengths that do not fit
    into the box anywhere are found.
    """
    asked = _Asked(spec)
    built = build(program, RunContext(), asked)
    try:
        check_devices(program, spec, built.needed())
    except CellError as error:
        asked.found += error.diagnostics
    asked.found += _slow_ticks(program, asked)
    known = {(d.line, d.column, d.file) for d in asked.found}
    reaching = _reaching(program)
    for name, param in program.document.params.items():
        if name not in reaching:
            continue  # each end is a reading of the whole file
        ends = dict.fromkeys(end for end in (param.min, param.max) if end is not None and end != param.value)
        for end in ends:
            asked.found += _at_end(load, spec, name, param, end, known)
    return sorted(asked.found, key=lambda d: (d.file, d.line, d.column))


def _reaching(program: Program) -> set[str]:
    """Return the names that may give a value to a node with a limit: those in its inputs, and in what calls hand to these names."""
    if any(body.signature.document.variants for body in program.bodies.values()):
        return set(program.document.params)  # what `with:` gives a file is read with it, and no wire shows it
    parts = [part for body in program.bodies.values() for part in body.parts()]
    limited = [part for part in parts if isinstance(part, Leaf) and any(p.limit for p in part.info.of(Role.INPUT))]
    calls = [part for part in parts if isinstance(part, Call)]
    names = {name for leaf in limited for wire in leaf.inputs.values() for name in _NAME.findall(wire.text)}
    known = 0
    while len(names) > known:
        known = len(names)
        handed = [wire for call in calls for name, wire in call.inputs.items() if name in names]
        names |= {name for wire in handed for name in _NAME.findall(wire.text)}
    return names


def check_devices(program: Program, spec: CellSpec, needed: Iterable[str]) -> None:
    """Raise CellError, at their declarations, for devices that a tree needs and a cell does not have."""
    declared = program.document.devices
    findings = []
    for name in sorted(needed):
        interface = declared[name].interface.__name__
        present = spec.devices.get(name)
        if present is None or present.type != interface:
            what = f"the tree needs {name!r}, a device of kind {interface}"
            hint = f"add 'devices: {{{name}: {{type: {interface}, use: ...}}}}', or run another cell"
            findings.append(declared[name].mark.error("device-missing", f"{what}, and {spec.path.name} has none", hint))
    if findings:
        raise CellError(findings)


def _slow_ticks(program: Program, asked: _Asked) -> Iterator[Diagnostic]:
    """Yield that ticks are too far apart for motions, which have to be looked at; a simulated cell does not mind."""
    tick, period = program.document.root.get("tick"), program.document.tick_period
    spec, most = asked.spec, asked.spec.limits.unwatched
    real = any(d.type in ("Arm", "Gripper") and not d.implementation.cls.simulated for d in spec.devices.values())
    if tick is not None and asked.moves and real and period >= most:
        kind = KINDS["Time"]
        message = (
            f"there is a tick every {format_quantity(period, kind)}; {spec.path.name} stops a motion that no tick looks at "
            f"for {format_quantity(most, kind)}"
        )
        yield tick.mark.warning("cell-limit", message, "tick more often, or widen 'limits: {unwatched: ...}'")


def _at_end(
    load: str | Path, spec: CellSpec, name: str, param: Param, end: float, known: set[tuple[int, int, str]]
) -> Iterator[Diagnostic]:
    """Yield the first thing that is past the limits, and was not before, with a param at an end of its range."""
    try:
        program = load_program(load, {name: end})
        if program.errors:
            return
        asked = _Asked(spec)
        build(program, RunContext(), asked)
    except StretchError:
        return  # there is no such run
    wrong = [d for d in asked.found if d.severity == "error" or d.code == "cell-force"]
    fresh = [d for d in wrong if (d.line, d.column, d.file) not in known]
    if fresh:
        kind = param.type.kind
        given = format_quantity(end, kind) if kind else f"{end:g}"
        message = f"at the end of its range, {name} = {given}, {fresh[0].message} (line {fresh[0].line})"
        yield param.mark.warning(fresh[0].code, message, "narrow the range of the param, or mind it with --set")


class _Asked:
    """Follows the building of a tree, and notes what its ports ask for beyond the limits of a cell."""

    def __init__(self, spec: CellSpec) -> None:
        self.spec = spec
        self.found: list[Diagnostic] = []
        self.moves = False
        #: the calls of trees by their paths, each with the path of the call around it
        self.calls: dict[str, tuple[Call, str]] = {}

    def node(self, path: str, part: Part, builder: Builder) -> None:
        """Look at a node; builds nothing in its place."""
        if isinstance(part, Call):
            self.calls[path] = part, builder.frame.path
        if not isinstance(part, Leaf):
            return
        self.moves = self.moves or part.info.cls.kind == "actuation"
        devices = [builder.frame.devices.get(name, name) for name in part.devices.values()]
        for declared in part.info.of(Role.INPUT):
            if declared.limit is not None:
                wire = part.inputs.get(declared.name)
                value = declared.default if wire is None else _constant(wire, builder)
                mark = part.mark if wire is None else self._written(wire, builder.frame.path)
                self._hold(path, declared, declared.limit, value, mark)
                if declared.limit in HELD and isinstance(value, int | float):
                    self.found += unheld_force(self.spec, devices, f"{path}: {declared.name}", value, mark)
                if declared.limit in _SPEEDS:
                    self._meet(path, devices, declared, value, mark)

    def _written(self, wire: Wire, frame: str) -> Mark:
        """Return the place where the value of a wire is written: the place in the outermost call that hands it down."""
        while frame in self.calls:
            call, frame = self.calls[frame]
            outer = call.inputs.get(wire.single_key() or "")
            if outer is None:
                break
            wire = outer
        return wire.mark

    def condition(self, path: str, builder: Builder) -> Callable[[], bool] | None:
        """Leave every condition as it is."""
        return None

    def _meet(self, path: str, devices: Sequence[str], declared: Port, value: Any, mark: Mark) -> None:
        """Note how hard the motion may meet something at the highest speed that it can have in a run."""
        assert declared.limit is not None
        allowed = self.spec.span(declared.limit)[1]
        most = declared.max if value is MISSING else value
        if value is MISSING:
            most = allowed if most is None else min(most, allowed)
        if most is not None and most <= allowed + _ROUNDING:  # a faster one is an error already
            self.found += hard_contact(self.spec, devices, f"{path}: {declared.name}", declared.limit, most, mark)

    def _hold(self, path: str, declared: Port, limit: str, value: Any, mark: Mark) -> None:
        if value is None or (value is MISSING and limit in _FITTING):
            return
        low, high = self.spec.span(limit)
        least, most = (declared.min, declared.max) if value is MISSING else (value, value)
        if (least is None or least >= low - _ROUNDING) and most is not None and most <= high + _ROUNDING:
            return
        kind = _KINDS.get(limit, KINDS["Length"])
        given, *ends = format_apart(kind, math.inf if most is None else most, low, high)
        allowed = " to ".join(text for text, end in zip(ends, (low, high), strict=True) if end > -1e300)
        where = f"{path}: {declared.name}"
        field, note = self._place(limit)
        bound = f"{self.spec.path.name} allows {'' if ' to ' in allowed else 'at most '}{allowed}{note}"
        if value is MISSING:
            able = "anything" if most is None else f"up to {given}"
            message = f"{where} is known in the run alone and takes {able}; {bound}"
            self.found.append(
                mark.warning("cell-limit", message, "the node fails where it is more; bound it before this node")
            )
        else:
            message = f"{where} is {given}; {bound}"
            hint = f"write what the cell allows, or widen its limits ('limits: {{{field}: ...}}')"
            self.found.append(mark.error("cell-limit", message, hint))

    def _place(self, limit: str) -> tuple[str, str]:
        """Return the field of a cell's limits that says a limit, and where it holds if that is not everywhere."""
        contact, speed = self.spec.limits.contact, self.spec.limits.speed
        if limit != "contact_speed":
            return _FIELDS.get(limit, limit), ""
        return (
            ("speed", "")
            if contact is None or contact.speed >= speed
            else ("contact", " where the hand may meet something")
        )


#: the kinds of limits that are no lengths, and the fields from which lengths follow that only have to fit
_SPEEDS = {"speed": KINDS["Speed"], "contact_speed": KINDS["Speed"]}
_KINDS = {**_SPEEDS, "gripper_speed": KINDS["Speed"], "force": KINDS["Force"], "held_force": KINDS["Force"]}
_FITTING = {"travel": "height", "radius": "x"}
_FIELDS = {**_FITTING, "held_force": "force"}


def _constant(wire: Wire, builder: Builder) -> Any:
    """Return the value of a wire that is the same in every run: written, or given so to the tree that it is in; else MISSING."""
    if wire.is_constant:
        return wire.value
    key = wire.single_key()
    if key is None:
        return MISSING
    cell = builder.cell(key)
    return MISSING if cell in builder.cells else cell.value
