"""Children at the same time, with a named policy."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

import py_trees
from py_trees.common import ParallelPolicy, Status

from stretch_bt.source import Map, Mark, Scalar, Seq, Value, did_you_mean, told
from stretch_bt.tree.flow.base import Flow, Known, Part, construct
from stretch_bt.tree.fragments import Schema, form, ref

if TYPE_CHECKING:
    from stretch_bt.tree.build import Builder
    from stretch_bt.tree.dataflow import DataFlow
    from stretch_bt.tree.reader import Reader

__all__ = ["Parallel", "ParallelNode"]

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
        if fields is None or not isinstance(value, Map):
            return None
        found = cls(mark, reader.children(fields["children"], mark, "parallel"))
        policy = fields.get("policy")
        if isinstance(policy, Scalar) and policy.text in POLICIES:
            found.policy = policy.text
        elif policy is not None:
            hint = did_you_mean(policy.text if isinstance(policy, Scalar) else "", POLICIES)
            reader.error(policy.mark, "option-unknown", f"{told(policy)} is not a policy of 'parallel'", hint)
        if (found.policy == "success_on_selected") == ("selected" in value):
            found._read_selected(reader, fields.get("selected"))
        elif "selected" in value:
            message = f"'selected' has no use with the policy {found.policy!r}"
            reader.error(value.key("selected").mark, "port-missing", message, "add 'policy: success_on_selected'")
        else:
            names = ", ".join(part.label for part in found.parts)
            message = "the policy 'success_on_selected' needs 'selected'"
            reader.error(mark, "port-missing", message, f"add 'selected: [...]' with some of {names}")
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
        if value is None:
            return
        labels = [part.label for part in self.parts]
        if not isinstance(value, Seq) or not value.items:
            reader.error(
                value.mark,
                "type-mismatch",
                "'selected' takes a list of names",
                f"write '[{labels[0] if labels else 'name'}]'",
            )
            return
        for item in value.items:
            name = item.text if isinstance(item, Scalar) else ""
            if labels.count(name) == 1:
                self.selected.append(labels.index(name))
            elif name in labels:
                message = f"several children of this 'parallel' are called {name!r}"
                reader.error(item.mark, "name-unknown", message, "give them different names with 'name:'")
            else:
                message = f"no child of this 'parallel' is called {name!r}"
                reader.error(item.mark, "name-unknown", message, did_you_mean(name, labels))

    def _one_writer_each(self, reader: Reader) -> None:
        first: dict[str, Part] = {}
        for part in self.parts:
            for key, writer, mark in part.writes():
                other = first.setdefault(key, part)
                if other is not part:
                    reader.error(
                        mark,
                        "parallel-write",
                        f"{writer!r} writes ${key}, and so does another branch ({other.label!r})",
                        "use two keys",
                    )

    def flow(self, data: DataFlow, known: Known) -> Flow:
        """Branches know nothing of each other; afterwards, the outputs of the branches that the policy needs are written."""
        ends = [part.flow(data, known) for part in self.parts]
        successes = [e.success for e in ends]
        if (
            self.policy == "success_on_selected" and self.selected
        ):  # of which there are none where it was not understood
            successes = [successes[i] for i in self.selected]
        done = [s for s in successes if s is not None]
        if not done or (self.policy != "success_on_one" and len(done) < len(successes)):
            return Flow(None, known)
        if self.policy == "success_on_one":
            return Flow(frozenset.intersection(*done), known)
        return Flow(frozenset().union(*done), known)

    def build(self, builder: Builder, path: str) -> py_trees.behaviour.Behaviour:
        """Return a py_trees Parallel; a child that succeeded is not ticked again."""
        node = builder.group(ParallelNode(path, ParallelPolicy.SuccessOnOne()), self, path)
        if self.policy == "success_on_all":
            node.policy = ParallelPolicy.SuccessOnAll(synchronise=True)
        elif self.policy == "success_on_selected":
            chosen = [node.children[i] for i in self.selected]
            node.policy = ParallelPolicy.SuccessOnSelected(children=chosen, synchronise=True)
        return node


class ParallelNode(py_trees.composites.Parallel):
    """A Parallel that starts no further branch in the tick in which one failed: a motion begun then is one too many."""

    def tick(self) -> Iterator[py_trees.behaviour.Behaviour]:
        """Tick the branches in order, up to the first FAILURE."""
        if self.status is not Status.RUNNING:
            for child in self.children:
                if child.status is not Status.INVALID:
                    child.stop(Status.INVALID)
        status = Status.RUNNING
        for child in self.children:
            if self.policy.synchronise and child.status is Status.SUCCESS:
                continue
            yield from child.tick()
            if child.status is Status.FAILURE:
                status = Status.FAILURE
                break
        if status is Status.RUNNING and self._done():
            status = Status.SUCCESS
        if status is not Status.RUNNING:
            self.stop(status)
        self.status = status
        yield self

    def _done(self) -> bool:
        if isinstance(self.policy, ParallelPolicy.SuccessOnOne):
            return any(child.status is Status.SUCCESS for child in self.children)
        chosen = self.policy.children if isinstance(self.policy, ParallelPolicy.SuccessOnSelected) else self.children
        return all(child.status is Status.SUCCESS for child in chosen)
