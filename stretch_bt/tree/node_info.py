"""What is known of a registered node: its names, ports and types."""

from __future__ import annotations

import re
from dataclasses import dataclass

from stretch_bt.tree.behavior import Behavior
from stretch_bt.tree.port import Port, Role
from stretch_bt.tree.port_check import PortCheck
from stretch_bt.tree.types import Type

__all__ = ["NodeInfo", "first_paragraph", "snake_case"]


@dataclass(frozen=True)
class NodeInfo:
    """A registered node: its YAML name, its class and its ports with their types."""

    name: str
    cls: type[Behavior]
    ports: dict[str, Port]
    types: dict[str, Type]

    @property
    def doc(self) -> str:
        """The first paragraph of the class docstring."""
        return first_paragraph(self.cls.__doc__)

    @property
    def instant(self) -> bool:
        """Whether the node always ends in the tick it starts."""
        return bool(self.cls.instant)

    def of(self, role: Role) -> list[Port]:
        """Return the ports of one role, in the order of the class."""
        return [p for p in self.ports.values() if p.role is role]

    @property
    def inouts(self) -> dict[str, Type]:
        """Types of the ports that are read and written."""
        return {declared.name: self.types[declared.name] for declared in self.of(Role.INOUT)}

    @property
    def outputs(self) -> dict[str, Type]:
        """Types of the output ports; each quantity also writes `<name>_sd`."""
        found: dict[str, Type] = {}
        for declared in self.of(Role.OUTPUT):
            found[declared.name] = self.types[declared.name]
            if self.types[declared.name].is_number and f"{declared.name}_sd" not in self.ports:
                found[f"{declared.name}_sd"] = self.types[declared.name]
        return found

    def written(self) -> dict[str, PortCheck]:
        """Return what each value that the node writes must be, deviations of its outputs included."""
        ports = {name: port.check(self.ports) for name, port in self.ports.items() if port.written}
        return {name: PortCheck(float, 0.0, None) for name in self.outputs} | ports


def snake_case(name: str) -> str:
    """Return the YAML name of a class name."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", name).lower()


def first_paragraph(text: str | None) -> str:
    """Return the first paragraph of a docstring on one line, nothing without one."""
    return " ".join((text or "").strip().split("\n\n")[0].split())
