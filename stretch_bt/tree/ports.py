"""What the author of a node imports: the base of nodes and the words for its ports.

A node is one class with a docstring and typed ports. A port is an annotation: `In[T]` reads, `Out[T]` writes,
`InOut[T]` reads and writes over, `Uses[D]` names a device interface. Building a tree binds each port to a slot, so that a
tick costs one attribute access a port.
"""

from py_trees.common import Status

from stretch_bt.tree.behavior import Behavior
from stretch_bt.tree.cell import MISSING, Cell
from stretch_bt.tree.declared_ports import PortError, RegistryError
from stretch_bt.tree.port import In, InOut, Out, Port, Role, Uses, port

__all__ = [
    "MISSING",
    "Behavior",
    "Cell",
    "In",
    "InOut",
    "Out",
    "Port",
    "PortError",
    "RegistryError",
    "Role",
    "Status",
    "Uses",
    "port",
]
