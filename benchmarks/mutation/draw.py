"""Drawing mutants: one place of one function is changed, by one of eight kinds of change."""

from __future__ import annotations

import ast
import random
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from mutation.sources import PACKAGE, files

__all__ = ["KINDS", "Mutant", "draw", "mutants_of"]

_NEGATED: dict[type[ast.cmpop], ast.cmpop] = {
    ast.Lt: ast.GtE(),
    ast.LtE: ast.Gt(),
    ast.Gt: ast.LtE(),
    ast.GtE: ast.Lt(),
    ast.Eq: ast.NotEq(),
    ast.NotEq: ast.Eq(),
    ast.Is: ast.IsNot(),
    ast.IsNot: ast.Is(),
    ast.In: ast.NotIn(),
    ast.NotIn: ast.In(),
}
_SUMS: dict[type[ast.operator], ast.operator] = {ast.Add: ast.Sub(), ast.Sub: ast.Add()}
_PRODUCTS: dict[type[ast.operator], ast.operator] = {ast.Mult: ast.Div(), ast.Div: ast.Mult()}
_PAIRS = (("min", "max"), ("minimum", "maximum"), ("any", "all"), ("floor", "ceil"), ("sin", "cos"))
_OTHERS = {a: b for pair in _PAIRS for a, b in (pair, pair[::-1])}
#: of text, not of numbers
_TOLD = ("__repr__", "__str__", "to_json")


@dataclass(frozen=True, slots=True)
class Mutant:
    """A change of a file: the bytes `first` to `last` become `new`."""

    domain: str
    path: Path
    line: int
    kind: str
    old: str
    new: str
    first: int
    last: int

    def __str__(self) -> str:
        return f"{self.domain}: {self.path.relative_to(PACKAGE)}:{self.line}: {self.kind}: {self.old} -> {self.new}"

    def source(self) -> str:
        """Return the text of the file with the change."""
        text = self.path.read_bytes()
        return (text[: self.first] + self.new.encode() + text[self.last :]).decode()


def _flip(node: ast.AST) -> ast.expr | None:
    if isinstance(node, ast.Compare) and len(node.ops) == 1:
        return ast.Compare(node.left, [_NEGATED[type(node.ops[0])]], node.comparators)
    return None


def _change(node: ast.AST) -> ast.expr | None:
    value = node.value if isinstance(node, ast.Constant) else None
    if isinstance(value, int | float) and not isinstance(value, bool):
        return ast.Constant(value + 1 if isinstance(value, int) else 2 * value if value else 1.0)
    return None


def _guard(node: ast.AST) -> ast.expr | None:
    return None  # of statements: see _guards


def _sign(node: ast.AST) -> ast.expr | None:
    return node.operand if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub) else None


def _sum(node: ast.AST) -> ast.expr | None:
    known = isinstance(node, ast.BinOp) and type(node.op) in _SUMS
    return ast.BinOp(node.left, _SUMS[type(node.op)], node.right) if known and isinstance(node, ast.BinOp) else None


def _product(node: ast.AST) -> ast.expr | None:
    known = isinstance(node, ast.BinOp) and type(node.op) in _PRODUCTS
    return ast.BinOp(node.left, _PRODUCTS[type(node.op)], node.right) if known and isinstance(node, ast.BinOp) else None


def _other(node: ast.AST) -> ast.expr | None:
    if isinstance(node, ast.Name) and node.id in _OTHERS:
        return ast.Name(_OTHERS[node.id])
    if isinstance(node, ast.Attribute) and node.attr in _OTHERS:
        return ast.Attribute(node.value, _OTHERS[node.attr])
    return None


def _logic(node: ast.AST) -> ast.expr | None:
    if isinstance(node, ast.BoolOp):
        return ast.BoolOp(ast.Or() if isinstance(node.op, ast.And) else ast.And(), node.values)
    return None


#: the change of a node, or None where the node is of another kind
KINDS: dict[str, Callable[[ast.AST], ast.expr | None]] = {
    "comparison flipped": _flip,
    "constant changed": _change,
    "guard removed": _guard,
    "sign changed": _sign,
    "sum for difference": _sum,
    "product for quotient": _product,
    "function for another": _other,
    "and for or": _logic,
}


def mutants_of(domain: str) -> dict[str, list[Mutant]]:
    """Return every mutant of a domain, by kind."""
    found: dict[str, list[Mutant]] = {kind: [] for kind in KINDS}
    for path in files(domain):
        text = path.read_bytes()
        starts = [0]
        for line in text.splitlines(keepends=True):
            starts.append(starts[-1] + len(line))
        for kind, node, new in _changes(ast.parse(text)):
            assert node.end_lineno is not None
            assert node.end_col_offset is not None
            first = starts[node.lineno - 1] + node.col_offset
            last = starts[node.end_lineno - 1] + node.end_col_offset
            old = " ".join(text[first:last].decode().split())
            found[kind].append(Mutant(domain, path, node.lineno, kind, old, f"({ast.unparse(new)})", first, last))
    return found


def draw(domain: str, count: int, seed: int) -> list[Mutant]:
    """Draw mutants of a domain: each of another kind, as far as there are kinds, and each place of a kind as likely."""
    rng = random.Random(f"{seed} {domain}")
    by_kind = {kind: found for kind, found in mutants_of(domain).items() if found}
    kinds = list(by_kind)
    rng.shuffle(kinds)
    return [rng.choice(by_kind[kinds[k % len(kinds)]]) for k in range(count)]


def _changes(tree: ast.Module) -> Iterator[tuple[str, ast.expr, ast.expr]]:
    """Yield each kind of change of each expression within functions, and what it becomes."""
    for function in _functions(tree):
        body = function.body[1:] if ast.get_docstring(function) else function.body
        for node in (inner for statement in body for inner in _nodes(statement)):
            if (
                isinstance(node, ast.If)
                and not node.orelse
                and isinstance(node.body[-1], ast.Raise | ast.Return | ast.Continue)
            ):
                yield "guard removed", node.test, ast.Constant(False)
            for kind, change in KINDS.items():
                if isinstance(node, ast.expr) and (new := change(node)) is not None:
                    yield kind, node, new


def _functions(tree: ast.AST) -> Iterator[ast.FunctionDef]:
    """Yield outermost functions and methods, but not the ones that only make text."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.FunctionDef):
            if node.name not in _TOLD:
                yield node
        elif isinstance(node, ast.ClassDef):
            yield from _functions(node)


def _nodes(node: ast.AST) -> Iterator[ast.AST]:
    """Yield a node and what is in it, but for texts, errors, annotations and indices of nothing but a number."""
    if isinstance(node, ast.JoinedStr | ast.Raise | ast.Assert | ast.Import | ast.ImportFrom):
        return
    yield node
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST):
                yield from _nodes(child)
