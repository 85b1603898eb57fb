"""Reading the body of a tree: nodes, constructs and calls, with every port wired and typed."""

from __future__ import annotations

import re

from stretch_bt.source import Map, Mark, Scalar, Seq, Value, closest, did_you_mean, is_nothing, unknown_key
from stretch_bt.tree import registry
from stretch_bt.tree.document import Signature
from stretch_bt.tree.flow import CONSTRUCTS, Broken, Part
from stretch_bt.tree.flow.groups import Sequence
from stretch_bt.tree.flow.guard import Guard, SkipIf
from stretch_bt.tree.flow.log import Log
from stretch_bt.tree.flow.repeat import Retry
from stretch_bt.tree.flow.timeout import Timeout
from stretch_bt.tree.node_info import NodeInfo, snake_case
from stretch_bt.tree.node_wiring import NodeWiring
from stretch_bt.tree.registry import RESERVED, RETIRED
from stretch_bt.tree.renamed import new_node
from stretch_bt.tree.values import written

__all__ = ["Reader"]

#: words of a node that stand beside it, with where they are and what they are given
Words = dict[str, tuple[Scalar, Value]]

#: constructs in which a reserved word belongs to the thing inside: a key to be set, a node whose result is changed
_OWN_WORDS = ("set", "invert", "force_success", "force_failure")
#: constructs in whose braces a name may stand
_CONDITIONS = ("check", "guard")
#: modifiers, from the innermost to the outermost
_AROUND = (
    ("timeout", Timeout.around),
    ("retry", Retry.around),
    ("guard", Guard.around),
    ("skip_if", SkipIf.around),
    ("log", Log.around),
)


class Reader(NodeWiring):
    """Reads the bodies of one tree; mistakes are noted and reading goes on."""

    # --- bodies

    def __init__(self, signature: Signature) -> None:
        super().__init__(signature)
        self._bodies: dict[int, tuple[Value, Part | None]] = {}

    def body(self, value: Value) -> Part | None:
        """Read one place of a tree: `{press: {...}}`, a bare name, or a list run as a sequence; each is read once."""
        if id(value) not in self._bodies:
            self._bodies[id(value)] = value, self.read_body(value)
        return self._bodies[id(value)][1]

    def read_body(self, value: Value) -> Part | None:
        """Read one place of a tree."""
        if isinstance(value, Seq):
            return Sequence(value.mark, self.children(value, value.mark, "sequence"))
        if isinstance(value, Scalar):
            if value.value is None:
                hint = "write '- press: {depth: 10 mm}', or remove the dash"
                self.error(value.mark, "body-missing", "there is no node here", hint)
                return None
            return self.place(value, Map((), value.mark), {})
        value = self.spelt(value)
        words = {key.text: (key, v) for key, v in value if key.text in RESERVED}
        kinds: list[tuple[Scalar, Value]] = [(key, v) for key, v in value if key.text not in RESERVED]
        if "run" in value and "with" in value and isinstance(value.get("run"), Scalar):
            pairs = (
                (Scalar("tree", False, value.key("run").mark), value.get("run")),
                (value.key("with"), value.get("with")),
            )
            call = Map(tuple((k, v) for k, v in pairs if v is not None), value.mark)
            kinds = [(value.key("run"), call), *((k, v) for k, v in kinds if k.text not in ("run", "with"))]
        if not kinds:  # a reserved word that is a construct too, as in `timeout: {after: 1 s, do: ...}`
            forms = ((k, v) for k, v in words.values() if k.text in CONSTRUCTS and isinstance(v, Map) and "do" in v)
            kinds += list(forms)[:1]
        known = [(key, v) for key, v in kinds if self.is_known(key.text)]
        if len(known) == 1 and len(kinds) > 1:
            self.strange_words([pair for pair in kinds if pair not in known], [*words])
            kinds = known
        if len(kinds) != 1:
            names = ", ".join(repr(k.text) for k, _ in kinds) or "nothing"
            at = kinds[1][0].mark if kinds else value.mark
            alone = "" if kinds or not words else next(iter(words))
            hint = (
                f"'{alone}' stands beside a node: {{set: {{...}}, {alone}: ...}}"
                if alone
                else "begin each node with its own '- '"
            )
            self.error(at, "body", f"a place in a tree names one node, here {names}", hint)
            return None
        key, given = kinds[0]
        words.pop(key.text, None)
        return self.place(key, given, words)

    def spelt(self, value: Map) -> Map:
        """Put right the words of older files, and note them."""
        if not any(word in value for word in RETIRED):
            return value
        pairs = []
        for key, given in value:
            if (word := RETIRED.get(key.text)) is not None:
                self.error(key.mark, "retired", f"{key.text!r} is no longer a word of the language", f"write {word!r}")
                key = Scalar(word, False, key.mark)
            pairs.append((key, given))
        return Map(tuple(pairs), value.mark)

    def strange_words(self, pairs: list[tuple[Scalar, Value]], taken: list[str]) -> None:
        """Note words beside a node that are neither reserved words nor nodes."""
        for key, value in pairs:
            guess = closest(key.text, [word for word in RESERVED if word not in taken])
            hint = f"did you mean {guess!r}?" if guess else "indent it further if it is a port; else begin it with '- '"
            if guess is None and unknown_key(key, value, ()):
                hint = unknown_key(key, value, ())
            self.error(key.mark, "key-unknown", f"{key.text!r} is neither a node nor a word beside one", hint)

    def children(self, value: Value, mark: Mark, what: str) -> list[Part]:
        """Read a list of at least one place."""
        if not isinstance(value, Seq):
            self.error(value.mark, "type-mismatch", f"{what!r} takes a list of nodes", "begin each with '- '")
            return []
        if not value.items:
            self.error(mark, "empty", f"{what!r} has no children", "add a node, or remove it")
        return [part for item in value.items if (part := self.body(item)) is not None]

    def place(self, key: Scalar, given: Value, beside: Words) -> Part | None:
        """Read a node, construct or call with the reserved words inside and beside it."""
        words = dict(beside)
        if isinstance(given, Map) and key.text not in _OWN_WORDS:
            given, info = self.spelt(given), self.node(key.text)
            reserved = [word for word in RESERVED if info is None or word not in info.ports]
            for inner, value in given:
                if inner.text in reserved:
                    self.word_inside(key, inner, value, words)
            given = Map(tuple((k, v) for k, v in given if k.text not in reserved), given.mark)
        part = self.kind(key, given)
        part.name = self.name(words["name"][1]) if "name" in words else None
        if "finally" in words:
            message, hint = "'finally' belongs to a tree, not to a node", "move it under the tree's name"
            self.error(words["finally"][0].mark, "finally", message, hint)
        if "doc" in words and not isinstance(words["doc"][1], Scalar):
            self.error(words["doc"][1].mark, "type-mismatch", "'doc' takes text", "write one sentence")
        for word, around in _AROUND:
            if word in words:
                part = around(self, part, words[word][1])
        return part

    def word_inside(self, key: Scalar, inner: Scalar, value: Value, words: Words) -> None:
        """Take a word that stands among the ports: the name of a condition; any other belongs beside the node."""
        if inner.text in words:
            message = f"{inner.text!r} is given inside and beside the node"
            self.error(inner.mark, "key-duplicate", message, "keep one")
            return
        words[inner.text] = (inner, value)
        if not (inner.text == "name" and key.text in _CONDITIONS):
            message = f"{inner.text!r} stands among the ports of {key.text!r}"
            hint = f"put it beside the node: '{{{key.text}: ..., {inner.text}: {written(value)}}}'"
            self.error(inner.mark, "retired", message, hint)

    def is_known(self, name: str) -> bool:
        """Whether a name is the name of a construct, a tree or a node."""
        return name in CONSTRUCTS or name == "run" or bool(self.document.tree(name) or self.node(name))

    def kind(self, key: Scalar, given: Value) -> Part:
        """Find out the kind of a name, and read it."""
        return self.known_kind(key, given) or self.broken(key, given)

    def known_kind(self, key: Scalar, given: Value) -> Part | None:
        """Read a name of a known kind; None, with an error, when it cannot be read."""
        construct = CONSTRUCTS.get(key.text)
        if construct is not None:
            return construct.read(self, key.mark, given)  # type: ignore[attr-defined, no-any-return]
        if key.text == "run":
            return self.explicit_call(key, given)
        target = self.document.tree(key.text)
        if target is not None:
            return self.call(target, key.mark, given)
        info = self.node(key.text)
        if info is not None:
            return self.leaf(info, key.mark, given)
        if key.text.partition(".")[0] in self.document.doubtful:
            return None
        if (refused := self.document.refused.get(key.text)) is not None:
            self.error(key.mark, "node-unknown", str(refused), refused.hint)
            return None
        known = [*registry.load_all(), *self.document.node_names(), *self.document.tree_names(), *CONSTRUCTS, "run"]
        guess = None if new_node(key.text) else closest(snake_case(key.text), known)
        if (before := key.text.partition(":{")[0]) != key.text:
            hint = f"put a space after the colon: '{before}: {{...}}'"
            self.error(key.mark, "node-unknown", f"there is no node or tree {key.text!r}", hint)
            return None
        hint = f"did you mean {guess!r}?" if guess else new_node(key.text) or did_you_mean(key.text, known)
        hint = hint or "`stretch-bt nodes` lists all nodes"
        self.error(key.mark, "node-unknown", f"there is no node or tree {key.text!r}", hint)
        return None

    def broken(self, key: Scalar, given: Value) -> Broken:
        """Keep what can be read of a place with a mistake, so that the rest of the tree is judged as if it were there."""
        found = Broken(key.mark, key.text)
        places = list(given.items) if isinstance(given, Seq) else []
        pairs = list(given.pairs) if isinstance(given, Map) else []
        for name, value in pairs:
            if isinstance(value, Scalar) and value.text.startswith("$"):
                found.keys[value.text[1:]] = value.mark
            elif key.text == "set" or is_nothing(value):
                found.keys[name.text.removeprefix("$")] = name.mark
            elif name.text == "do":
                places.append(value)
            elif name.text == "children" and isinstance(value, Seq):
                places += value.items
            elif name.text == "with" and isinstance(value, Map):
                pairs += value.pairs
        found.parts = [part for value in places if (part := self.body(value)) is not None]
        return found

    def node(self, name: str) -> NodeInfo | None:
        """Find a node by what the file calls it."""
        return self.document.node(name)

    def name(self, value: Value | None) -> str | None:
        """Read the name given to a place."""
        if value is None:
            return None
        if isinstance(value, Scalar) and re.fullmatch(r"[A-Za-z_][\w-]*", value.text) and value.text != "finally":
            return value.text
        word = re.sub(r"\W+", "_", value.text).strip("_") if isinstance(value, Scalar) else ""
        if word == "finally":
            self.error(value.mark, "name", "'finally' is reserved for the end of a tree", "write 'name: at_the_end'")
            return None
        hint = f"write '{word}'" if re.match(r"[A-Za-z_]", word) else "write 'name: force_limit'"
        self.error(value.mark, "name", "a name is one word of letters, digits, _ and -", hint)
        return None

    def explicit_call(self, key: Scalar, value: Value) -> Part | None:
        """Read `{run: tree, with: {...}}`."""
        given = value if isinstance(value, Map) else Map(((Scalar("tree", False, value.mark), value),), value.mark)
        fields = self.fields(given, key.mark, "run", required=("tree",), optional=("with",))
        tree = fields["tree"] if fields else None
        if fields is None or not isinstance(tree, Scalar):
            return None
        target = self.document.tree(tree.text)
        if target is None:
            hint = did_you_mean(tree.text, self.document.tree_names())
            self.error(tree.mark, "node-unknown", f"there is no tree {tree.text!r}", hint)
            return None
        return self.call(target, tree.mark, fields.get("with", Map((), key.mark)))
