"""The borders of the trees of a file: their inputs, outputs and keys, before any body is read."""

from __future__ import annotations

from stretch_bt.source import Map, Scalar, Seq, Value, is_nothing
from stretch_bt.tree.declarations import Declarations
from stretch_bt.tree.document import Declared, Document, Signature
from stretch_bt.tree.heading_reader import HeadingReader
from stretch_bt.tree.values import written

__all__ = ["FRAME", "Borders"]

FRAME = ("in", "inout", "out", "keys", "doc", "guard", "finally")
#: words that people write for the words of FRAME
FRAME_WORDS = {
    **dict.fromkeys(("ins", "input", "inputs"), "in"),
    **dict.fromkeys(("outs", "output", "outputs"), "out"),
    **dict.fromkeys(("key", "local", "locals"), "keys"),
}


class Borders(HeadingReader):
    """Reads the borders of trees; `declarations` reads the declaration of a name."""

    def __init__(self, doc: Document, declarations: Declarations) -> None:
        super().__init__(doc)
        self._declarations = declarations

    def read(self, value: Value | None) -> None:
        """Read the heading `trees`."""
        entries = self.entries(value, "trees")
        if not entries and (value is None or isinstance(value, Map) or value.plain() is None):
            mark = value.mark if value is not None else self.doc.root.mark
            self.error(mark, "trees-missing", "the file has no trees", "add 'trees: {main: ...}'")
        for key, body in entries:
            if self.good_name(key, "tree"):
                self.doc.trees[key.text] = self._signature(key, _as_body(body))

    def main_keys(self, value: Value | None) -> None:
        """Read the heading `keys`, which are those of `main`."""
        main = self.doc.trees.get("main")
        entries = self.entries(value, "keys")
        if main is None:
            if entries:
                message = "keys at the top belong to 'main', which is not here"
                self.error(entries[0][0].mark, "key-unused", message, "move them to a tree")
            return
        for name, spec in entries:
            self._add_key(main, main.keys, name, spec)

    def _signature(self, key: Scalar, body: Map) -> Signature:
        body = self._frame(body)
        inner = Map(
            tuple((k, v) for k, v in body.pairs if k.text not in ("in", "inout", "out", "keys", "doc")), body.mark
        )
        found = Signature(key.text, key.mark, self.doc, inner, doc=self._declarations.text(body.get("doc")))
        tables = {"in": found.ins, "inout": found.inouts, "out": found.outs, "keys": found.keys}
        for field, table in tables.items():
            for name, spec in self._border(body.get(field), field):
                self._add_key(found, table, name, spec)
        for word in ("in", "inout") if found.name == "main" and not self.doc.prefix else ():
            if word in body:
                at, hint = body.key(word).mark, "make it a param, under 'params:', or a key"
                self.error(at, "key-unknown", f"'main' is called by nobody, so it has no {word!r}", hint)
        return found

    def _frame(self, body: Map) -> Map:
        """Put right what stands for `in`, `out` and `keys` in other languages, and note it."""
        pairs = []
        for key, value in body:
            word = FRAME_WORDS.get(key.text, "")
            if word and word not in body and isinstance(value, Map):
                self.error(key.mark, "key-unknown", f"a tree has no {key.text!r}", f"did you mean {word!r}?")
                key = Scalar(word, False, key.mark)
            pairs.append((key, value))
        return Map(tuple(pairs), body.mark)

    def _border(self, value: Value | None, what: str) -> list[tuple[Scalar, Value]]:
        """Return names with their declarations, which a list of names leaves empty."""
        if not isinstance(value, Seq) or what == "keys":
            return self.entries(value, what)
        found: list[tuple[Scalar, Value]] = []
        for item in value.items:
            if isinstance(item, Scalar):
                found.append((item, Scalar("", False, item.mark)))
            else:
                hint = f"write '{what}: [depth, stretch]'"
                self.error(item.mark, "type-mismatch", f"{what} takes a list of names", hint)
        return found

    def _add_key(self, tree: Signature, table: dict[str, Declared], name: Scalar, spec: Value) -> None:
        if not self.good_name(name, "key"):
            return
        first = tree.declared(name.text)
        if table is tree.keys:
            tree.own[name.text] = written(spec)
        if table is tree.keys and first is not None and first.listed and first is tree.outs.get(name.text):
            tree.outs[name.text] = self._declarations.read(name, spec, "key")
        elif first is not None:
            message = f"${name.text} is declared twice (first on line {first.mark.line})"
            self.error(name.mark, "key-duplicate", message, "keep one")
        elif name.text in self.doc.devices:
            self.error(name.mark, "key-duplicate", f"${name.text} has the name of a device", "rename one of them")
        else:
            more = ("scene",) if table is tree.outs and tree.name == "main" else ()
            declared = self._declarations.read(name, spec, "key", more)
            declared.listed = table is not tree.keys and is_nothing(spec)
            table[name.text] = declared


def _as_body(value: Value) -> Map:
    """Return a tree's body as a mapping; a list is a sequence, and a bare name a node, as everywhere."""
    if isinstance(value, Map):
        return value
    if isinstance(value, Seq):
        return Map(((Scalar("sequence", False, value.mark), value),), value.mark)
    if value.value is None:
        return Map((), value.mark)
    return Map(((value, Scalar("", False, value.mark)),), value.mark)
