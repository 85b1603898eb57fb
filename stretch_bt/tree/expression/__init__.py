"""Safe expressions: their own small grammar, names and units checked at load, no Python evaluated."""

from stretch_bt.tree.expression.bind import Environment, bind
from stretch_bt.tree.expression.parse import FUNCTIONS, Expression, ExpressionError, parse
from stretch_bt.tree.expression.typecheck import Scope, Symbol, names, typecheck

__all__ = [
    "FUNCTIONS",
    "Environment",
    "Expression",
    "ExpressionError",
    "Scope",
    "Symbol",
    "bind",
    "names",
    "parse",
    "typecheck",
]
