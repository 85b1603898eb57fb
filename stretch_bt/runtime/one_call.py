"""One node or library subtree called from Python: its ports, and the tree of one call that the runner ticks."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

import yaml

from stretch_bt.errors import InvalidInput, shown
from stretch_bt.plain_numbers import is_number, plain_number
from stretch_bt.source import Mark, Scalar, did_you_mean
from stretch_bt.tree import registry
from stretch_bt.tree.document import Document, Signature
from stretch_bt.tree.headings import FORMAT
from stretch_bt.tree.node_info import NodeInfo
from stretch_bt.tree.node_wiring import givers
from stretch_bt.tree.port import Role
from stretch_bt.tree.program import Program, load_program
from stretch_bt.tree.shared import SHARED, shipped
from stretch_bt.tree.types import Family, Type
from stretch_bt.tree.values import ValueRefused, example, literal
from stretch_bt.units import Estimate, parse_time

__all__ = ["MODIFIERS", "Called", "OneCall", "called", "names"]

#: words beside the ports, as in a tree file
MODIFIERS = ("timeout", "guard")
#: the tree that holds the call, and what its paths begin with
ENTRY = "do"


@dataclass(frozen=True, slots=True)
class Called:
    """What can be called: its ports by name, with their types."""

    name: str
    doc: str
    ins: dict[str, Type]
    inouts: dict[str, Type]
    outs: dict[str, Type]
    #: kind of each device port, and whether one is needed
    devices: dict[str, tuple[str, bool]] = field(default_factory=dict)
    required: frozenset[str] = frozenset()
    imports: dict[str, str] = field(default_factory=dict)

    @property
    def ports(self) -> dict[str, Type]:
        """The ports that a caller may give."""
        return self.ins | self.inouts

    def signature(self) -> inspect.Signature:
        """Return what a caller may give, by keyword; records may be left out, as records of earlier calls stand in for them."""
        must = {name for name in self.required if not self.ports[name].is_record}
        words = {
            **self.ports,
            **{name: kind for name, (kind, _) in self.devices.items()},
            **dict.fromkeys(MODIFIERS, str),
        }
        return inspect.Signature(
            [
                inspect.Parameter(
                    word,
                    inspect.Parameter.KEYWORD_ONLY,
                    default=inspect.Parameter.empty if word in must else ...,
                    annotation=kind if isinstance(kind, type) else str(kind),
                )
                for word, kind in words.items()
            ]
        )

    def help(self) -> str:
        """Return what it does, and its ports with their types, for `help()`."""
        parts = {"Takes": self.ports, "Gives": self.outs | self.inouts}
        lists = (
            f"{title}\n" + "\n".join(f"    {name}: {type_}" for name, type_ in ports.items())
            for title, ports in parts.items()
            if ports
        )
        return "\n\n".join((self.doc, *lists))

    def check(self, given: Mapping[str, Any]) -> None:
        """Raise InvalidInput for a name that is no port."""
        known = (*self.ports, *self.devices, *MODIFIERS)
        for name in given:
            if name in self.outs and name not in known:
                raise InvalidInput(f"{self.name} gives {name!r}: read it from what the call returns")
            if name not in known:
                hint = did_you_mean(name, known) or f"it has {', '.join(known)}"
                raise InvalidInput(f"{self.name} has no port {name!r}; {hint}")

    def check_devices(self, kinds: set[str]) -> None:
        """Raise InvalidInput for a kind of device that is needed and not there."""
        missing = sorted({kind for kind, needed in self.devices.values() if needed and kind not in kinds})
        if missing:
            raise InvalidInput(f"{self.name} needs a device of kind {', '.join(missing)}, and this cell has none open")


def names() -> list[str]:
    """Return what can be called by its name alone: nodes, and the subtrees that need no import."""
    return sorted({*registry.load_all(), *SHARED})


def called(name: str) -> Called:
    """Return a node, a subtree that needs no import, or `lib/file.tree`, a subtree of a file.

    Raises
    ------
    InvalidInput
        There is none of this name.
    TreeError
        The file of the subtree is wrong.
    """
    if name in SHARED:
        return _subtree(name, _library(SHARED[name]), name)
    file, dot, tree = name.rpartition(".")
    if dot and ("/" in file or file.endswith((".yaml", ".yml"))):
        path = file if file.endswith((".yaml", ".yml")) else f"{file}.yaml"
        return _subtree(tree, _library(path), f"lib.{tree}", {"lib": path})
    info = registry.lookup(name)
    if info is None:
        hint = did_you_mean(name, names()) or "see stretch-bt nodes; a subtree of a file is 'lib/file.tree'"
        raise InvalidInput(f"there is no node and no subtree {name!r}; {hint}")
    return _node(info)


def _node(info: NodeInfo) -> Called:
    outs = {n: t for n, t in info.outputs.items() if n in info.ports}
    ins = {p.name: info.types[p.name] for p in info.of(Role.INPUT)}
    devices = {p.name: (info.types[p.name].name, not p.optional) for p in info.of(Role.DEVICE)}
    required = frozenset(name for name in (*ins, *info.inouts) if info.ports[name].required)
    return Called(info.name, info.doc, ins, info.inouts, outs, devices, required)


def _subtree(tree: str, document: Document, name: str, imports: dict[str, str] | None = None) -> Called:
    signature: Signature | None = document.trees.get(tree)
    if signature is None:
        raise InvalidInput(f"{document.file} has no tree {tree!r}; {did_you_mean(tree, document.trees)}".rstrip("; "))
    ins, inouts, outs = (
        {n: d.type for n, d in table.items()} for table in (signature.ins, signature.inouts, signature.outs)
    )
    required = frozenset(n for n, d in (signature.ins | signature.inouts).items() if not d.has_default)
    return Called(name, signature.doc, ins, inouts, outs, required=required, imports=imports or {})


def _library(name: str) -> Document:
    """Return a file of subtrees: beside the current folder, else a shipped one."""
    path = Path(name) if Path(name).exists() else shipped(name)
    if not path.exists():
        raise InvalidInput(f"there is no file {name!r} here, nor among the shipped trees")
    return load_program(path).require().document


class OneCall:
    """The tree of one call.

    Parameters
    ----------
    target
        What is called.
    given
        Values of ports: SI numbers, text with a unit, records; and the modifiers of a tree file.
    held
        Records of earlier calls, by name, for ports that are left out.
    devices
        Kind of each device of the cell, by name.
    """

    def __init__(
        self, target: Called, given: Mapping[str, Any], held: Mapping[str, Any], devices: Mapping[str, str]
    ) -> None:
        target.check(given)
        target.check_devices(set(devices.values()))
        self.target = target
        self.values: dict[str, Any] = {}
        self.written: dict[str, Any] = {}
        for name, value in given.items():
            self._take(name, value)
        for name, type_ in target.ports.items():
            if type_.is_record and name not in given and name in held and _fits(held[name], type_):
                self.values[name] = held[name]
        self._check_needed()
        # files of one's own may have changed since
        read = _program.__wrapped__ if target.imports else _program
        self.program = read(self._text(devices), Path.cwd())

    def _check_needed(self) -> None:
        """Raise InvalidInput for ports that nothing gives."""
        missing = [n for n in self.target.ports if n in self.target.required and n not in {*self.values, *self.written}]
        if missing:
            told = "; ".join(f"{name} ({self._how(name)})" for name in missing)
            raise InvalidInput(f"{self.target.name} needs {told}")

    def _how(self, name: str) -> str:
        """Return how to give a port that is needed."""
        type_ = self.target.ports[name]
        if not type_.is_record:
            return f"{name}={example(type_).removeprefix('write ')}" if type_.kind else str(type_)
        by = givers(type_)[:3]
        return f"a {type_}: call {' or '.join(by)} before, or give {name}=..." if by else str(type_)

    def _take(self, name: str, value: Any) -> None:
        type_ = self.target.ports.get(name)
        if value is None:
            return
        if type_ is None:  # a device, or a modifier
            seconds = parse_time(f"{self.target.name}: timeout", value) if name == "timeout" else 0.0
            self.written[name] = f"{seconds!r} s" if name == "timeout" else str(value)
        elif type_.is_record:
            self.values[name] = self._record(name, value, type_)
        elif name in self.target.inouts:
            self.values[name] = self._si(name, value, type_)
        else:
            self.written[name] = self._literal(name, value, type_)
            beside = f"{name}_sd"
            if isinstance(value, Estimate) and beside in self.target.ports:
                self.written.setdefault(beside, self._literal(beside, value.sd, type_))

    def _record(self, name: str, value: Any, type_: Type) -> Any:
        if not _fits(value, type_):
            raise InvalidInput(f"{self.target.name}: {name} takes {type_}, not {shown(value)[:80]}")
        return list(value) if isinstance(value, tuple) else value

    def _literal(self, name: str, value: Any, type_: Type) -> Any:
        """Return a value as a tree file has it."""
        value = plain_number(value)
        if isinstance(value, str):
            return value
        if type_.family is Family.LIST and type_.item is not None and hasattr(value, "__iter__"):
            return [self._literal(name, item, type_.item) for item in value]
        if isinstance(value, bool) or type_.kind is None:
            return value if isinstance(value, bool | int | float) else self._wrong(name, value, type_)
        return f"{float(value)!r} {type_.kind.si_unit}" if is_number(value) else self._wrong(name, value, type_)

    def _si(self, name: str, value: Any, type_: Type) -> Any:
        """Return a value as a key holds it."""
        if isinstance(value, Estimate):
            return value
        value = self._literal(name, value, type_)
        if isinstance(value, list) and type_.item is not None:
            return [self._si(name, item, type_.item) for item in value]
        if not isinstance(value, str):
            return value
        try:
            return literal(Scalar(value, type_.kind is None, Mark(self.target.name, 1, 1)), type_, name)
        except ValueRefused as refused:
            raise InvalidInput(f"{self.target.name}: {refused.diagnostic.message}") from None

    def _wrong(self, name: str, value: Any, type_: Type) -> str:
        unit = f", a number in {type_.kind.si_unit} or text with a unit" if type_.kind else ""
        raise InvalidInput(f"{self.target.name}: {name} takes {type_}{unit}, not {shown(value)[:80]}")

    def _text(self, devices: Mapping[str, str]) -> str:
        ports = {n: v for n, v in self.written.items() if n not in MODIFIERS}
        ports |= {name: f"${name}" for name in (*self.values, *self.target.outs, *self.target.inouts)}
        body = {self.target.name: ports or None} | {n: self.written[n] for n in MODIFIERS if n in self.written}
        absent = [name for name in self.target.inouts if name not in self.values]
        tree = {
            "in": [name for name in self.values if name not in self.target.inouts],
            "inout": [name for name in self.target.inouts if name in self.values],
            "out": [*self.target.outs, *absent],
            "sequence": [body],
        }
        file = {"format": FORMAT, "imports": self.target.imports, "devices": dict(devices), "trees": {ENTRY: tree}}
        return yaml.dump(_without_nothing(file), Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=10_000)


class _Dumper(yaml.SafeDumper):
    """Writes nothing after the name of a node that has no ports, where null would be an error."""


_Dumper.add_representer(type(None), lambda dumper, _: dumper.represent_scalar("tag:yaml.org,2002:null", ""))


def _without_nothing(value: Any) -> Any:
    """Return a mapping without its entries that are empty, at any depth."""
    if not isinstance(value, dict):
        return value
    inner = {key: _without_nothing(item) for key, item in value.items()}
    return {key: item for key, item in inner.items() if item not in ([], {})}


def _fits(value: Any, type_: Type) -> bool:
    if type_.family is Family.LIST:
        return isinstance(value, list | tuple) and all(_fits(item, type_.item) for item in value if type_.item)
    return type_.cls is not None and isinstance(value, type_.cls)


@lru_cache(maxsize=256)
def _program(text: str, folder: Path) -> Program:
    """Return a checked program; the same call is checked once. Raises InvalidInput."""
    program = load_program(folder / "do.yaml", text=text)
    program.entry = ENTRY
    if program.errors:
        raise InvalidInput(_said(program, text))
    return program


def _said(program: Program, text: str) -> str:
    """Return what is wrong with a call, without places in a text that nobody wrote."""
    return "; ".join(dict.fromkeys(f"{d.message}{d.hint and '; ' + d.hint}" for d in program.errors))
