"""Children at the same time, with a named policy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

import py_trees
from py_trees.common import ParallelPolicy

from stretch_bt.source import Map, Mark, Scalar, Seq, Value, did_you_mean
from stretch_bt.tree.flow.base import Flow, Known, Part, construct
from stretch_bt.tree.fragments import Schema, form, ref

if TYPE_CHECKING:
    from stretch_bt.tree.build import Builder
    from stretch_bt.tree.dataflow import DataFlow
    from stretch_bt.tree.reader import Reader

__all__ = ["Parallel"]

POLICIES = ("success_on_all", "success_on_one", "success_on_selected")


@construct
@dataclass(slots=True)
class Parallel(Part):
    """Children at the same time; any FAILURE ends it, `policy` says when it succeeds."""

    parts: list[Part] = field(default_factory=list)
    policy: str = "success_on_all"
    selected: list[int] = field(default_factory=list)
    keyword: ClassVar[str] = "parallel"
    transparent: ClassVar[bool] = True

    def children(self) -> Sequence[Part]:
        """Return the children in order."""
        return self.parts

    @classmethod
    def read(cls, reader: Reader, mark: Mark, value: Value) -> Part | None:
        """Read `[children]` or `{policy, children, selected}`."""
        if isinstance(value, Seq):
            value = Map(((Scalar("children", False, value.mark), value),), value.mark)
        fields = reader.fields(value, mark, "parallel", required=("children",), optional=("policy", "selected"))
        if fields is None:
            return None
        found = cls(mark, reader.children(fields["children"], mark, "parallel"))
        policy = fields.get("policy")
        if isinstance(policy, Scalar) and policy.text in POLICIES:
            found.policy = policy.text
        elif policy is not None:
            text = policy.text if isinstance(policy, Scalar) else "this"
            reader.error(
                policy.mark, "option-unknown", f"{text!r} is not a policy of 'parallel'", did_you_mean(text, POLICIES)
            )
        found._read_selected(reader, fields.get("selected"))
        found._one_writer_each(reader)
        return found

    @classmethod
    def schema(cls) -> Schema:
        """Return the schema of its form."""
        return {
            "anyOf": [
                ref("children"),
                form(
                    {"children": ref("children")},
                    {"policy": {"enum": list(POLICIES)}, "selected": {"type": "array", "items": {"type": "string"}}},
                ),
            ]
        }

    def written(self) -> dict[str, str]:
        """Return the policy, and the children that it names."""
        if not self.selected:
            return {"policy": self.policy}
        return {"policy": self.policy, "selected": ", ".join(self.parts[i].label for i in self.selected)}

    def _read_selected(self, reader: Reader, value: Value | None) -> None:
        labels = [part.label for part in self.parts]
        for item in value.items if isinstance(value, Seq) else ():
            name = item.text if isinstance(item, Scalar) else ""
            if name in labels:
                self.selected.append(labels.index(name))
            else:
                reader.error(
                    item.mark,
                    "name-unknown",
                    f"no child of this 'parallel' is called {name!r}",
                    did_you_mean(name, labels),
                )
        if (self.policy == "success_on_selected") != bool(value is not None):
            reader.error(
                self.mark,
                "port-missing",
                "'selected' and the policy 'success_on_selected' go together",
                "give both or none",
            )

    def _one_writer_each(self, reader: Reader) -> None:
        first: dict[str, Part] = {}
        for part in self.parts:
            for key, writer, mark in reader.writes(part):
                other = first.setdefault(key, part)
                if other is not part:
                    reader.error(
                        mark,
                        "parallel-write",
                        f"{writer!r} writes ${key}, and so does another branch ({other.label!r})",
                        "use two keys",
                    )

    def flow(self, data: DataFlow, known: Known) -> Flow:
        """Branches know nothing of each other; afterwards, what the policy needs is written."""
        ends = [part.flow(data, known) for part in self.parts]
        successes = [e.success for e in ends]
        if self.policy == "success_on_selected":
            successes = [successes[i] for i in self.selected]
        done = [s for s in successes if s is not None]
        if not done or (self.policy != "success_on_one" and len(done) < len(successes)):
            return Flow(None, known)
        if self.policy == "success_on_one":
            return Flow(frozenset.intersection(*done), known)
        return Flow(frozenset().union(*done), known)

    def build(self, builder: Builder, path: str) -> py_trees.behaviour.Behaviour:
        """Return a py_trees Parallel; a child that succeeded is not ticked again."""
        node: py_trees.composites.Parallel = builder.group(
            py_trees.composites.Parallel(path, ParallelPolicy.SuccessOnOne()), self, path
        )
        if self.policy == "success_on_all":
            node.policy = ParallelPolicy.SuccessOnAll(synchronise=True)
        elif self.policy == "success_on_selected":
            chosen = [node.children[i] for i in self.selected]
            node.policy = ParallelPolicy.SuccessOnSelected(children=chosen, synchronise=True)
        return node
