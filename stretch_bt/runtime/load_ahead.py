"""Loading, before a robot moves, what nodes load when they need it first.

Modules of kernels are compiled as they are loaded, which takes half a minute the first time on a machine, and importing a library may take half
a second: a hand that moves meanwhile is looked at by no tick.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Iterable, Iterator
from contextlib import suppress

__all__ = ["load_ahead", "load_first"]

#: packages whose modules are all loaded
_OWN = ("stretch_bt.model", "stretch_bt.behaviors", "stretch_bt.runtime")
#: such a package for what a camera sees, most of whose modules are of kernels
_SEEING = "stretch_bt.perception"
#: modules of libraries that a record imports as it is written
_RECORD = (
    "foxglove_schemas_protobuf.CameraCalibration_pb2",
    "foxglove_schemas_protobuf.Log_pb2",
    "foxglove_schemas_protobuf.PointCloud_pb2",
    "foxglove_schemas_protobuf.RawImage_pb2",
    "mcap_protobuf.schema",
)
#: modules of libraries that functions of those import
_OTHERS = (
    "scipy.interpolate",
    "scipy.linalg.interpolative",
    "scipy.optimize",
    "scipy.sparse.linalg",
    "scipy.spatial",
    "scipy.special",
)
_OTHERS_SEEING = ("cv2", "scipy.fft", "scipy.ndimage")
#: modules of the solver that a twin imports when something is read from it first
_SHEET = (
    "scipy.interpolate",
    "stretch_bt.simulation.membrane.sheet.hanging",
    "stretch_bt.simulation.membrane.sheet.solver",
)


def load_ahead(kinds: Iterable[str]) -> None:
    """Import every module that a node may import later, given the kinds of the devices that are opened: images come from a DepthCamera alone.

    A module that cannot be imported is left to the node that needs it.
    """
    for name in _names(seeing="DepthCamera" in kinds):
        with suppress(Exception):
            importlib.import_module(name)


def load_first(*, sheet: bool) -> None:
    """Import what the first ticks of any run would import, with `sheet` also what a twin solves its membrane with.

    No signal is heard while a tick imports.
    """
    for name in (*_RECORD, *(_SHEET if sheet else ())):
        importlib.import_module(name)


def _names(*, seeing: bool) -> Iterator[str]:
    for package in map(importlib.import_module, (*_OWN, *([_SEEING] if seeing else []))):
        yield from (
            module.name
            for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}.", onerror=lambda _: None)
        )
    yield from (*_OTHERS, *(_OTHERS_SEEING if seeing else ()), *_RECORD)
