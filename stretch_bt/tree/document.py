"""A tree file as far as its headings: what it imports, declares and offers, before any body is read."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from stretch_bt.errors import Diagnostic
from stretch_bt.source import Map, Mark, Scalar
from stretch_bt.tree import registry
from stretch_bt.tree.foreign.of_class import class_in, classes_in, info_of
from stretch_bt.tree.foreign.refused import BehaviourRefused
from stretch_bt.tree.node_info import NodeInfo
from stretch_bt.tree.port import Port
from stretch_bt.tree.shared import SHARED
from stretch_bt.tree.types import Type

__all__ = ["TICK", "Declared", "DeviceDecl", "Document", "Param", "Signature"]

#: period of the ticks of a tree that does not say it, s
TICK = 0.05


@dataclass(slots=True)
class Declared:
    """A declared name: an input, an output or a key of a tree. `unit` is the unit in which an output is shown.

    `scene` marks an output of a task that no node writes: the scene alone knows it, and on a robot it is absent.
    """

    name: str
    type: Type
    mark: Mark
    default: Any = None
    has_default: bool = False
    unit: str | None = None
    unit_mark: Mark | None = None
    min: float | None = None
    max: float | None = None
    #: bounds that the file itself gives it, beside the bounds of the ports that an input reaches
    own_bounds: tuple[float | None, float | None] = (None, None)
    doc: str = ""
    scene: bool = False
    doubtful: bool = False  # whether what is declared is wrong, which was noted
    #: whether it is a bare name: type, bounds and default of an input follow from the ports that it reaches, of an output `keys:` may give them
    listed: bool = False
    may_be_absent: bool = False  # an input: each port that it reaches keeps its own default where no caller gives it
    inferred: bool = False  # a key that no one declared; `mark` is its first writer
    #: the ports that an input reaches, whose docs say what it is for; read where they are shown, as that needs the source
    reaches: list[Port | Declared] = field(default_factory=list)

    @property
    def bounded(self) -> bool:
        """Whether the file itself gives it a bound."""
        return self.own_bounds != (None, None)


@dataclass(slots=True)
class Param(Declared):
    """A constant of a file, given at load; `value` holds what the file, or `--set`, says."""

    value: Any = None
    used: bool = False


@dataclass(slots=True)
class DeviceDecl:
    """A device that a file needs, by name and interface."""

    name: str
    interface: type
    mark: Mark
    used: bool = False


@dataclass(slots=True)
class Signature:
    """One tree of a file: what crosses its border, and its body still unread."""

    name: str
    mark: Mark
    document: Document
    body: Map
    ins: dict[str, Declared] = field(default_factory=dict)
    inouts: dict[str, Declared] = field(default_factory=dict)
    outs: dict[str, Declared] = field(default_factory=dict)
    keys: dict[str, Declared] = field(default_factory=dict)
    own: dict[str, str] = field(
        default_factory=dict
    )  # key that `keys` of the tree declares -> its declaration, as written
    doc: str = ""
    settled: bool = False  # whether every name has its type
    read: set[str] = field(default_factory=set)  # names that something in the body may read
    left_out: set[str] = field(default_factory=set)  # records that a place gives without naming them

    def declared(self, name: str) -> Declared | None:
        """Return what crosses the border, or the key, of this name."""
        return self.ins.get(name) or self.inouts.get(name) or self.outs.get(name) or self.keys.get(name)

    @property
    def deviations(self) -> dict[str, Declared]:
        """The outputs of which a caller may also take the standard deviation, by the name `<output>_sd`."""
        numbers = (out for out in self.outs.values() if out.type.is_number and not out.scene)
        found = {f"{out.name}_sd": out for out in numbers}
        return {n: out for n, out in found.items() if self.declared(n) is None and n not in self.document.params}

    @property
    def names(self) -> list[str]:
        """Every key that the tree's body may use."""
        return [*self.ins, *self.inouts, *self.outs, *self.keys]

    @property
    def qualified(self) -> str:
        """The name with the prefix under which the file was imported."""
        return f"{self.document.prefix}{self.name}"


@dataclass(slots=True)
class Document:
    """One tree file."""

    file: str
    path: Path | None
    root: Map
    prefix: str = ""
    doc: str = ""
    scene: Scalar | None = None
    tick_period: float = TICK
    params: dict[str, Param] = field(default_factory=dict)
    devices: dict[str, DeviceDecl] = field(default_factory=dict)
    doubtful: set[str] = field(default_factory=set)  # devices and imports that are declared, but wrongly
    doubtful_devices: set[str] = field(
        default_factory=set
    )  # those of them that are devices, which other files have too
    imports: dict[str, Document] = field(default_factory=dict)
    shared: dict[str, Document] = field(default_factory=dict)  # files of shipped trees, by the tree that is called
    shared_at: dict[str, Mark] = field(default_factory=dict)  # where each of these is called first
    modules: dict[str, str] = field(default_factory=dict)  # imported Python modules, by their names in the file
    classes: dict[str, NodeInfo] = field(
        default_factory=dict
    )  # nodes of classes, by the name that the file has for them
    refused: dict[str, BehaviourRefused] = field(
        default_factory=dict
    )  # classes that give no node, by the name of the node
    trees: dict[str, Signature] = field(default_factory=dict)
    diagnostics: list[Diagnostic] = field(default_factory=list)
    files: dict[str, str] = field(default_factory=dict)  # name -> sha256 of every file read
    declares_devices: bool = False
    #: reads the file anew with other params, where it is imported; `variants` are those that calls asked for
    reread: Callable[[dict[str, Any]], Document] | None = None
    variants: dict[tuple[tuple[str, Any], ...], Document] = field(default_factory=dict)

    @property
    def inner(self) -> list[Document]:
        """The files that this one imports or calls trees of."""
        return [*self.imports.values(), *{id(found): found for found in self.shared.values()}.values()]

    @property
    def scene_path(self) -> str | None:
        """The scene that the file names: a file beside it, or the name of a shipped one."""
        if self.scene is None or self.path is None:
            return None
        beside = self.path.parent / self.scene.text
        return str(beside) if self.scene.text.endswith((".yaml", ".yml")) and beside.exists() else self.scene.text

    def tree(self, name: str) -> Signature | None:
        """Return a tree by name, `contact.sense` for one of an imported file."""
        prefix, _, rest = name.partition(".")
        if rest and prefix in self.imports:
            return self.imports[prefix].tree(rest)
        found = self.trees.get(name)
        return self.shared[name].trees[name] if found is None and name in self.shared else found

    def with_params(self, given: dict[str, Any]) -> Document:
        """Return this file with other values of its params, read once for each set of them."""
        key = tuple(sorted((name, repr(value)) for name, value in given.items()))
        if key not in self.variants:
            assert self.reread is not None
            self.variants[key] = made = self.reread(given)
            made.hand_down(self.devices, self.doubtful_devices)
        return self.variants[key]

    def hand_down(self, devices: dict[str, DeviceDecl], doubtful: set[str]) -> None:
        """Give a file that declares no devices the devices of the file that imports it, with those that it declares wrongly."""
        if not self.declares_devices:
            self.devices, self.doubtful_devices = devices, doubtful
            self.doubtful |= doubtful
        for imported in self.inner:
            imported.hand_down(self.devices, self.doubtful_devices)

    def node(self, name: str) -> NodeInfo | None:
        """Return a node by what the file calls it: registered, an imported class, or `module.Class` of an imported module."""
        found = self.classes.get(name) or registry.find(name, self.modules)
        if found is not None or "." not in name or name in self.refused:
            return found
        for prefix, module in (*self.modules.items(), *((module, module) for module in self.modules.values())):
            cls = class_in(module, name.removeprefix(f"{prefix}.")) if name.startswith(f"{prefix}.") else None
            if cls is not None:
                return self._node_of(name, cls)
        return None

    def _node_of(self, name: str, cls: type) -> NodeInfo | None:
        """Return the node of a class that is named for the first time; None, with the reason kept, for one that gives none."""
        try:
            self.classes[name] = info_of(cls)
        except BehaviourRefused as refused:
            self.refused[name] = refused
        return self.classes.get(name)

    def node_names(self) -> list[str]:
        """Return the names of imported classes, and of those in imported modules."""
        inside = [f"{prefix}.{name}" for prefix, module in self.modules.items() for name in classes_in(module)]
        return [*self.classes, *inside]

    def tree_names(self) -> list[str]:
        """Return every name that a body may call."""
        return [*self.trees, *SHARED, *(f"{p}.{n}" for p, d in self.imports.items() for n in d.tree_names())]
