"""What a program of URScript is made of."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = [
    "Assign",
    "Binary",
    "Call",
    "Constant",
    "Define",
    "Do",
    "Expression",
    "If",
    "Index",
    "Join",
    "Jump",
    "Kill",
    "Listing",
    "Name",
    "Node",
    "Return",
    "Run",
    "Unary",
    "While",
]


@dataclass(frozen=True)
class Node:
    """A piece of a program, and where it is: line and column from 1."""

    line: int
    column: int


class Expression(Node):
    """What has a value."""


@dataclass(frozen=True)
class Constant(Expression):
    """A number, a string or a truth value."""

    value: float | int | bool | str


@dataclass(frozen=True)
class Name(Expression):
    """A variable."""

    name: str


@dataclass(frozen=True)
class Listing(Expression):
    """A list, or the six numbers of a pose."""

    items: tuple[Expression, ...]
    pose: bool


@dataclass(frozen=True)
class Index(Expression):
    """One of a list's values."""

    of: Expression
    at: Expression


@dataclass(frozen=True)
class Unary(Expression):
    """`-` or `not` of a value."""

    sign: str
    of: Expression


@dataclass(frozen=True)
class Binary(Expression):
    """Two values and what is between them."""

    sign: str
    left: Expression
    right: Expression


@dataclass(frozen=True)
class Call(Expression):
    """A function with its arguments by place and by name."""

    name: str
    arguments: tuple[Expression, ...]
    named: tuple[tuple[str, Expression], ...]


@dataclass(frozen=True)
class Run(Expression):
    """A thread that begins; its value is its number."""

    name: str


@dataclass(frozen=True)
class Do(Node):
    """An expression whose value nobody takes."""

    expression: Expression


@dataclass(frozen=True)
class Assign(Node):
    """A variable that gets a value, or one place of a list in it; `scope` is "global", "local" or nothing."""

    scope: str
    name: str
    at: Expression | None
    value: Expression


@dataclass(frozen=True)
class If(Node):
    """Conditions with what is done for the first that holds; the last may be None, which always does."""

    branches: tuple[tuple[Expression | None, tuple[Node, ...]], ...]


@dataclass(frozen=True)
class While(Node):
    """What is done as long as a condition holds."""

    condition: Expression
    body: tuple[Node, ...]


@dataclass(frozen=True)
class Return(Node):
    """The end of a function, with its value."""

    value: Expression | None


@dataclass(frozen=True)
class Jump(Node):
    """`break`, `continue`, or `halt`, which ends the program."""

    kind: str


@dataclass(frozen=True)
class Join(Node):
    """Wait for a thread to end."""

    thread: Expression


@dataclass(frozen=True)
class Kill(Node):
    """End a thread."""

    thread: Expression


@dataclass(frozen=True)
class Define(Node):
    """A function, a thread or a program: `kind` is "def", "thread" or "sec"."""

    kind: str
    name: str
    parameters: tuple[tuple[str, Expression | None], ...]
    body: tuple[Node, ...]
