"""What a program of URScript is made of."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = [
    "Assign",
    "Define",
    "If",
    "Index",
    "Join",
    "Jump",
    "Kill",
    "Listing",
    "Node",
    "Return",
    "Run",
    "ScriptBinary",
    "ScriptCall",
    "ScriptConstant",
    "ScriptDo",
    "ScriptExpression",
    "ScriptName",
    "ScriptUnary",
    "While",
]


@dataclass(frozen=True)
class Node:
    """A piece of a program, and where it is: line and column from 1."""

    line: int
    column: int


class ScriptExpression(Node):
    """What has a value."""


@dataclass(frozen=True)
class ScriptConstant(ScriptExpression):
    """A number, a string or a truth value."""

    value: float | int | bool | str


@dataclass(frozen=True)
class ScriptName(ScriptExpression):
    """A variable."""

    name: str


@dataclass(frozen=True)
class Listing(ScriptExpression):
    """A list, or the six numbers of a pose."""

    items: tuple[ScriptExpression, ...]
    pose: bool


@dataclass(frozen=True)
class Index(ScriptExpression):
    """One of a list's values."""

    of: ScriptExpression
    at: ScriptExpression


@dataclass(frozen=True)
class ScriptUnary(ScriptExpression):
    """`-` or `not` of a value."""

    sign: str
    of: ScriptExpression


@dataclass(frozen=True)
class ScriptBinary(ScriptExpression):
    """Two values and what is between them."""

    sign: str
    left: ScriptExpression
    right: ScriptExpression


@dataclass(frozen=True)
class ScriptCall(ScriptExpression):
    """A function with its arguments by place and by name."""

    name: str
    arguments: tuple[ScriptExpression, ...]
    named: tuple[tuple[str, ScriptExpression], ...]


@dataclass(frozen=True)
class Run(ScriptExpression):
    """A thread that begins; its value is its number."""

    name: str


@dataclass(frozen=True)
class ScriptDo(Node):
    """An expression whose value nobody takes."""

    expression: ScriptExpression


@dataclass(frozen=True)
class Assign(Node):
    """A variable that gets a value, or one place of a list in it; `scope` is "global", "local" or nothing."""

    scope: str
    name: str
    at: ScriptExpression | None
    value: ScriptExpression


@dataclass(frozen=True)
class If(Node):
    """Conditions with what is done for the first that holds; the last may be None, which always does."""

    branches: tuple[tuple[ScriptExpression | None, tuple[Node, ...]], ...]


@dataclass(frozen=True)
class While(Node):
    """What is done as long as a condition holds."""

    condition: ScriptExpression
    body: tuple[Node, ...]


@dataclass(frozen=True)
class Return(Node):
    """The end of a function, with its value."""

    value: ScriptExpression | None


@dataclass(frozen=True)
class Jump(Node):
    """`break`, `continue`, or `halt`, which ends the program."""

    kind: str


@dataclass(frozen=True)
class Join(Node):
    """Wait for a thread to end."""

    thread: ScriptExpression


@dataclass(frozen=True)
class Kill(Node):
    """End a thread."""

    thread: ScriptExpression


@dataclass(frozen=True)
class Define(Node):
    """A function, a thread or a program: `kind` is "def", "thread" or "sec"."""

    kind: str
    name: str
    parameters: tuple[tuple[str, ScriptExpression | None], ...]
    body: tuple[Node, ...]
