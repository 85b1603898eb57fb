"""Runs a program of URScript in a controller, a piece in each cycle.

Assumed, because no page says it: variables that the program itself sets, and not one of its functions, are seen by all of them; a
program may go through so many lines in a cycle before it counts as an endless loop.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass, field
from typing import Any

from stretch_bt.errors import IllConditioned
from stretch_bt.hardware.emulators.ur.controller import Controller, Program
from stretch_bt.hardware.emulators.ur.urscript import syntax
from stretch_bt.hardware.emulators.ur.urscript.tokens import ScriptFault
from stretch_bt.hardware.emulators.ur.urscript.values import SIGNS, Pose, Value, checked, place_of

__all__ = ["Interpreter"]

_LINES, _DEEPEST, _THREADS = 2000, 20, 50
_WRONG = (TypeError, ValueError, ArithmeticError, LookupError, RecursionError)

Function = Callable[..., Any]
Evaluation = Generator[None, None, Value]


class _Left(Exception):
    """A loop or function is left: by `break`, `continue` or `return`."""

    def __init__(self, kind: str, value: Value = None) -> None:
        super().__init__(kind)
        self.kind, self.value = kind, value


@dataclass
class _Frame:
    """The variables of one call, and how deep it is."""

    names: dict[str, Value] = field(default_factory=dict)
    depth: int = 0


class Interpreter:
    """One program.

    Parameters
    ----------
    controller
        Controller that runs it.
    program
        The program as it was read.
    functions
        Functions by name: a function returns its value, or a generator of the cycles that it takes.
    """

    def __init__(self, controller: Controller, program: syntax.Define, functions: Mapping[str, Function]) -> None:
        self._controller, self._program, self._functions = controller, program, functions
        self._globals = _Frame()
        self._defined: dict[str, syntax.Define] = {}
        self._threads: dict[int, Program] = {}
        self._started = self._lines = 0
        self._node: syntax.Node = program
        self._does: dict[type, Callable[[Any, _Frame], Program]] = {
            syntax.ScriptDo: self._do,
            syntax.Assign: self._assign,
            syntax.If: self._if,
            syntax.While: self._while,
            syntax.Return: self._return,
            syntax.Jump: self._jump,
            syntax.Join: self._join,
            syntax.Kill: self._kill,
            syntax.Define: self._define,
        }
        self._values: dict[type, Callable[[Any, _Frame], Evaluation]] = {
            syntax.ScriptConstant: self._constant,
            syntax.ScriptName: self._variable,
            syntax.Listing: self._listing,
            syntax.Index: self._index,
            syntax.ScriptUnary: self._unary,
            syntax.ScriptBinary: self._binary,
            syntax.ScriptCall: self._call,
            syntax.Run: self._run,
        }

    def run(self) -> Program:
        """Go through the program and its threads; raises ScriptFault where it cannot go on."""
        main = self._guarded(self._body(self._program.body, self._globals))
        try:
            while True:
                self._lines = 0
                next(main)
                for number in list(self._threads):
                    self._advance(number)
                yield
        except StopIteration:
            return
        except _Left:  # halt
            return
        finally:
            self._controller.script_line = 0

    def _advance(self, number: int) -> None:
        """Take a thread one cycle further."""
        self._lines = 0
        thread = self._threads.get(number)
        if thread is not None and next(thread, self) is self:
            self._threads.pop(number, None)

    def _guarded(self, steps: Program) -> Program:
        """Say of what goes wrong where it does."""
        try:
            yield from steps
        except ScriptFault:
            raise
        except (IllConditioned, *_WRONG) as error:
            raise ScriptFault(f"runtime_error: {error}", self._node.line, self._node.column) from error

    # --- statements

    def _body(self, body: tuple[syntax.Node, ...], frame: _Frame) -> Program:
        try:
            yield from self._block(body, frame)
        except _Left as left:
            if left.kind == "halt":
                raise
            if left.kind != "return":
                raise ValueError(f"{left.kind} outside of a loop") from None

    def _block(self, body: tuple[syntax.Node, ...], frame: _Frame) -> Program:
        for node in body:
            self._spend(node)
            self._controller.script_line = node.line
            yield from self._does[type(node)](node, frame)

    def _spend(self, node: syntax.Node) -> None:
        """Count a line of this cycle."""
        self._node = node
        self._lines += 1
        if self._lines > _LINES:
            raise ScriptFault("runtime_error: infinite loop", node.line, node.column)

    def _define(self, node: syntax.Define, frame: _Frame) -> Program:
        self._defined[node.name] = node
        yield from ()

    def _do(self, node: syntax.ScriptDo, frame: _Frame) -> Program:
        yield from self._value(node.expression, frame)

    def _assign(self, node: syntax.Assign, frame: _Frame) -> Program:
        value = yield from self._value(node.value, frame)
        own = node.scope == "local" or (node.scope == "" and node.name in frame.names)
        seen = node.scope == "global" or (node.scope == "" and node.name in self._globals.names)
        names = self._globals.names if seen and not own else frame.names
        if node.at is None:
            names[node.name] = _copy(value)
        else:
            at = yield from self._value(node.at, frame)
            names[node.name][place_of(at)] = value

    def _if(self, node: syntax.If, frame: _Frame) -> Program:
        for condition, body in node.branches:
            if condition is None or (yield from self._truth(condition, frame)):
                yield from self._block(body, frame)
                return

    def _while(self, node: syntax.While, frame: _Frame) -> Program:
        while (yield from self._truth(node.condition, frame)):
            self._spend(node)
            try:
                yield from self._block(node.body, frame)
            except _Left as left:
                if left.kind == "break":
                    return
                if left.kind != "continue":
                    raise

    def _return(self, node: syntax.Return, frame: _Frame) -> Program:
        value = None if node.value is None else (yield from self._value(node.value, frame))
        raise _Left("return", value)

    def _jump(self, node: syntax.Jump, frame: _Frame) -> Program:
        yield from ()
        raise _Left(node.kind)

    def _join(self, node: syntax.Join, frame: _Frame) -> Program:
        number = yield from self._value(node.thread, frame)
        while number in self._threads:
            yield

    def _kill(self, node: syntax.Kill, frame: _Frame) -> Program:
        number = yield from self._value(node.thread, frame)
        self._threads.pop(number, None)

    # --- values

    def _value(self, node: syntax.ScriptExpression, frame: _Frame) -> Evaluation:
        return checked((yield from self._values[type(node)](node, frame)))

    def _truth(self, node: syntax.ScriptExpression, frame: _Frame) -> Generator[None, None, bool]:
        value = yield from self._value(node, frame)
        if not isinstance(value, bool):
            raise TypeError("a condition must be True or False")
        return value

    def _constant(self, node: syntax.ScriptConstant, frame: _Frame) -> Evaluation:
        yield from ()
        return node.value

    def _variable(self, node: syntax.ScriptName, frame: _Frame) -> Evaluation:
        yield from ()
        for names in (frame.names, self._globals.names):
            if node.name in names:
                return names[node.name]
        raise LookupError(f"{node.name} has no value")

    def _listing(self, node: syntax.Listing, frame: _Frame) -> Evaluation:
        items = []
        for item in node.items:
            items.append((yield from self._value(item, frame)))
        if node.pose and len(items) != 6:
            raise TypeError("a pose has six numbers")
        return Pose(items) if node.pose else items

    def _index(self, node: syntax.Index, frame: _Frame) -> Evaluation:
        of = yield from self._value(node.of, frame)
        at = yield from self._value(node.at, frame)
        return of[place_of(at)]

    def _unary(self, node: syntax.ScriptUnary, frame: _Frame) -> Evaluation:
        value = yield from self._value(node.of, frame)
        return SIGNS["-"](0, value) if node.sign == "-" else not SIGNS["or"](value, False)

    def _binary(self, node: syntax.ScriptBinary, frame: _Frame) -> Evaluation:
        left = yield from self._value(node.left, frame)
        if (node.sign, left) in (("and", False), ("or", True)) and isinstance(left, bool):
            return left
        right = yield from self._value(node.right, frame)
        return SIGNS[node.sign](left, right)

    def _call(self, node: syntax.ScriptCall, frame: _Frame) -> Evaluation:
        given, named = [], {}
        for argument in node.arguments:
            given.append((yield from self._value(argument, frame)))
        for name, argument in node.named:
            named[name] = yield from self._value(argument, frame)
        self._node = node
        if node.name in self._defined:
            return (yield from self._own(self._defined[node.name], given, named, frame.depth + 1))
        made = _called(node.name, self._functions[node.name], given, named)
        if isinstance(made, Generator):
            return (yield from made)
        return made

    def _own(self, define: syntax.Define, given: list[Value], named: dict[str, Value], depth: int) -> Evaluation:
        """Call a function of the program."""
        if depth > _DEEPEST:
            raise RecursionError("calls are too deep")
        frame = _Frame(depth=depth)
        if len(given) > len(define.parameters):
            raise TypeError(f"{define.name} takes {len(define.parameters)} arguments")
        for k, (name, default) in enumerate(define.parameters):
            if k < len(given) or name in named:
                frame.names[name] = _copy(given[k] if k < len(given) else named[name])
            elif default is not None:
                frame.names[name] = yield from self._value(default, frame)
            else:
                raise TypeError(f"{define.name} needs {name}")
        try:
            yield from self._block(define.body, frame)
        except _Left as left:
            if left.kind == "halt":
                raise
            if left.kind != "return":
                raise ValueError(f"{left.kind} outside of a loop") from None
            return left.value

    def _run(self, node: syntax.Run, frame: _Frame) -> Evaluation:
        yield from ()
        if len(self._threads) >= _THREADS:
            raise ValueError("there are too many threads")
        self._started += 1
        self._threads[self._started] = self._guarded(self._body(self._defined[node.name].body, _Frame(depth=1)))
        return self._started


def _called(name: str, function: Function, given: list[Value], named: dict[str, Value]) -> Any:
    """Call a function of the controller; raises TypeError, in words of the program, for arguments that it does not take."""
    try:
        return function(*given, **named)
    except TypeError:
        try:
            inspect.signature(function).bind(*given, **named)
        except TypeError as error:
            raise TypeError(f"{name}: {error}") from None
        except ValueError:  # its signature is not known
            pass
        raise


def _copy(value: Value) -> Value:
    """Return a value that is not changed with another variable's."""
    return type(value)(value) if isinstance(value, list) else value
