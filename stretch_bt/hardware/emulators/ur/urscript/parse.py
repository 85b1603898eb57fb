"""From the words of URScript to a program."""

from __future__ import annotations

from collections.abc import Callable

from stretch_bt.hardware.emulators.ur.urscript.syntax import (
    Assign,
    Define,
    If,
    Index,
    Join,
    Jump,
    Kill,
    Listing,
    Node,
    Return,
    Run,
    ScriptBinary,
    ScriptCall,
    ScriptConstant,
    ScriptDo,
    ScriptExpression,
    ScriptName,
    ScriptUnary,
    While,
)
from stretch_bt.hardware.emulators.ur.urscript.tokens import (
    END_OF_LINE,
    NAME,
    NUMBER,
    STRING,
    ScriptFault,
    Token,
    tokens,
)

__all__ = ["parse"]

#: signs between two values, those that bind least first
_LEVELS = (("or", "xor"), ("and",), ("==", "!=", "<", ">", "<=", ">="), ("+", "-"), ("*", "/", "%"))
_TRUTH = {"True": True, "true": True, "False": False, "false": False}
_RESERVED = {"def", "thread", "sec", "end", "if", "elif", "else", "while", "return", "break", "continue", "global"}
_DEEPEST = 40


def parse(text: str) -> Define:
    """Return a program: the one function of a text, or its lines; raises ScriptFault for what cannot be read."""
    parser = _Parser(list(tokens(text)))
    body = parser.block(())
    if len(body) == 1 and isinstance(body[0], Define) and body[0].kind != "thread":
        return body[0]
    return Define(1, 1, "def", "unnamed", (), body)


class _Parser:
    """Reads word by word."""

    def __init__(self, words: list[Token]) -> None:
        self._words, self._at, self._depth = words, 0, 0
        self._statements: dict[str, Callable[[Token], Node]] = {
            "def": self._define,
            "thread": self._define,
            "sec": self._define,
            "if": self._if,
            "while": self._while,
            "return": self._return,
            "break": self._jump,
            "continue": self._jump,
            "halt": self._jump,
            "pass": self._pass,
            "global": self._scoped,
            "local": self._scoped,
            "join": lambda word: Join(word.line, word.column, self._expression()),
            "kill": lambda word: Kill(word.line, word.column, self._expression()),
        }

    # --- words

    @property
    def _word(self) -> Token:
        return self._words[min(self._at, len(self._words) - 1)]

    def _next(self) -> Token:
        word = self._word
        self._at += 1
        return word

    def _skip(self, *texts: str) -> bool:
        """Go past the next word if it is one of these."""
        if self._word.kind == STRING or self._word.text not in texts:
            return False
        self._at += 1
        return True

    def _expect(self, text: str) -> None:
        if not self._skip(text):
            raise self._fault()

    def _fault(self) -> ScriptFault:
        word = self._word
        shown = word.text.strip() or END_OF_LINE
        return ScriptFault(f"syntax_error_on_line:{word.line}:{shown}", word.line, word.column)

    def _name(self) -> str:
        if self._word.kind != NAME or self._word.text in _RESERVED:
            raise self._fault()
        return self._next().text

    # --- statements

    def block(self, ends: tuple[str, ...]) -> tuple[Node, ...]:
        """Return the statements up to one of the words that end them, or up to the end of the text."""
        self._depth += 1
        if self._depth > _DEEPEST:
            raise self._fault()
        made: list[Node] = []
        while True:
            while self._word.kind == END_OF_LINE and self._at < len(self._words):
                self._at += 1
            if self._at >= len(self._words):
                if ends:
                    raise self._fault()
                break
            if self._word.text in ends:
                break
            made.append(self._statement())
        self._depth -= 1
        return tuple(made)

    def _statement(self) -> Node:
        word = self._word
        read = self._statements.get(word.text) if word.kind == NAME else None
        if read is not None:
            self._at += 1
        made = read(word) if read is not None else self._plain(word, "")
        if self._next().kind != END_OF_LINE:
            self._at -= 1
            raise self._fault()
        return made

    def _plain(self, word: Token, scope: str) -> Node:
        """Return an assignment or an expression that stands alone."""
        target = self._expression()
        if not self._skip("="):
            if scope:
                raise self._fault()
            return ScriptDo(word.line, word.column, target)
        value = self._expression()
        at = target.at if isinstance(target, Index) else None
        named = target.of if isinstance(target, Index) else target
        if not isinstance(named, ScriptName):
            raise ScriptFault(f"syntax_error_on_line:{word.line}:=", word.line, word.column)
        return Assign(word.line, word.column, scope, named.name, at, value)

    def _scoped(self, word: Token) -> Node:
        return self._plain(word, word.text)

    def _define(self, word: Token) -> Node:
        name = self._name()
        self._expect("(")
        parameters: list[tuple[str, ScriptExpression | None]] = []
        while not self._skip(")"):
            parameter = self._name()
            parameters.append((parameter, self._expression() if self._skip("=") else None))
            if not self._skip(",") and self._word.text != ")":
                raise self._fault()
        self._expect(":")
        body = self.block(("end",))
        self._expect("end")
        return Define(word.line, word.column, word.text, name, tuple(parameters), body)

    def _if(self, word: Token) -> Node:
        branches: list[tuple[ScriptExpression | None, tuple[Node, ...]]] = []
        condition: ScriptExpression | None = self._expression()
        while True:
            self._expect(":")
            branches.append((condition, self.block(("elif", "elseif", "else", "end"))))
            if condition is None or not self._skip("elif", "elseif"):
                break
            condition = self._expression()
        if self._skip("else"):
            self._expect(":")
            branches.append((None, self.block(("end",))))
        self._expect("end")
        return If(word.line, word.column, tuple(branches))

    def _while(self, word: Token) -> Node:
        condition = self._expression()
        self._expect(":")
        body = self.block(("end",))
        self._expect("end")
        return While(word.line, word.column, condition, body)

    def _return(self, word: Token) -> Node:
        value = None if self._word.kind == END_OF_LINE else self._expression()
        return Return(word.line, word.column, value)

    def _jump(self, word: Token) -> Node:
        return Jump(word.line, word.column, word.text)

    def _pass(self, word: Token) -> Node:
        return ScriptDo(word.line, word.column, ScriptConstant(word.line, word.column, False))

    # --- expressions

    def _expression(self, level: int = 0) -> ScriptExpression:
        if level == 0:
            self._depth += 1
            if self._depth > _DEEPEST:
                raise self._fault()
        made = self._unary() if level == len(_LEVELS) else self._expression_of(level)
        self._depth -= level == 0
        return made

    def _expression_of(self, level: int) -> ScriptExpression:
        made = self._expression(level + 1)
        while self._word.kind != STRING and self._word.text in _LEVELS[level]:
            word = self._next()
            made = ScriptBinary(word.line, word.column, word.text, made, self._expression(level + 1))
        return made

    def _unary(self) -> ScriptExpression:
        word = self._word
        if word.kind != STRING and word.text in ("-", "not", "+"):
            self._at += 1
            of = self._expression(len(_LEVELS) if word.text != "not" else 2)
            return of if word.text == "+" else ScriptUnary(word.line, word.column, word.text, of)
        made = self._single()
        while self._skip("["):
            made = Index(word.line, word.column, made, self._expression())
            self._expect("]")
        return made

    def _single(self) -> ScriptExpression:
        word = self._next()
        if word.kind == NUMBER:
            return ScriptConstant(word.line, word.column, _number(word.text))
        if word.kind == STRING:
            return ScriptConstant(word.line, word.column, word.text[1:-1])
        if word.text == "(":
            made = self._expression()
            self._expect(")")
            return made
        if word.text == "[":
            return Listing(word.line, word.column, self._items(), False)
        if word.kind == NAME and word.text not in _RESERVED:
            return self._named(word)
        self._at -= 1
        raise self._fault()

    def _named(self, word: Token) -> ScriptExpression:
        if word.text in _TRUTH:
            return ScriptConstant(word.line, word.column, _TRUTH[word.text])
        if word.text == "p" and self._skip("["):
            return Listing(word.line, word.column, self._items(), True)
        if word.text == "run":
            name = self._name()
            self._expect("(")
            self._expect(")")
            return Run(word.line, word.column, name)
        return self._call(word) if self._skip("(") else ScriptName(word.line, word.column, word.text)

    def _items(self) -> tuple[ScriptExpression, ...]:
        items: list[ScriptExpression] = []
        while not self._skip("]"):
            items.append(self._expression())
            if not self._skip(",") and self._word.text != "]":
                raise self._fault()
        return tuple(items)

    def _call(self, word: Token) -> ScriptExpression:
        arguments: list[ScriptExpression] = []
        named: list[tuple[str, ScriptExpression]] = []
        while not self._skip(")"):
            value = self._expression()
            if isinstance(value, ScriptName) and self._skip("="):
                named.append((value.name, self._expression()))
            else:
                arguments.append(value)
            if not self._skip(",") and self._word.text != ")":
                raise self._fault()
        return ScriptCall(word.line, word.column, word.text, tuple(arguments), tuple(named))


def _number(text: str) -> float | int:
    if text[:2].lower() == "0x":
        return int(text, 16)
    return int(text) if text.isdecimal() else float(text)
