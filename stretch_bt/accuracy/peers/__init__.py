"""Other simulators on one press: a sphere of 20 mm, 10 mm deep, stretch 30 mm, shear modulus 40 kPa, 0.61 N.

A peer is a module of this package, named in `PEERS`, with its `NAME`, the `PACKAGES` that it needs, and `press()`. Each
models a membrane with its own law, as it comes; the error of law, elements and contact is one figure.
"""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from importlib.util import find_spec
from types import ModuleType
from typing import NamedTuple

from stretch_bt.accuracy.points import Point
from stretch_bt.errors import NoEquilibrium

__all__ = ["DEPTH", "DIAMETER", "PEERS", "SHEAR_MODULUS", "STRETCH", "Pressed", "points"]

PEERS = ("mujoco_flex", "newton_vbd")
DIAMETER, STRETCH, DEPTH = 0.020, 0.030, 0.010  # m
SHEAR_MODULUS = 40e3  # Pa
DENSITY = 1070.0  # kg/m^3, which a dynamic simulator needs to come to rest


class Pressed(NamedTuple):
    """What a peer gives: the force, N, once the sheet rests; CPU seconds from the flat stretched sheet; how, in words."""

    force: float
    seconds: float
    setting: str


def points() -> Iterator[Point]:
    """Yield the force of each peer against that of the sheet on fine elements; one that is not installed says so."""
    from stretch_bt.simulation.membrane.press import press
    from stretch_bt.simulation.membrane.sheet.settings import Settings

    case = f"sphere 20 mm, stretch 30 mm, depth 10 mm, shear modulus {SHEAR_MODULUS / 1e3:g} kPa"
    modules = [import_module(f"{__name__}.{name}") for name in PEERS]
    right = None
    for peer in modules:
        if not _installed(peer):
            yield Point(case, peer.NAME, "force", None, None, "skipped: install stretch-bt[peers]")
            continue
        if right is None:
            fine = Settings(mesh=0.5e-3, growth=1.2)
            right = press(f"sphere:{DIAMETER}m", STRETCH, DEPTH, shear_modulus=SHEAR_MODULUS, settings=fine).force
        yield _measured(case, peer, right)


def _installed(peer: ModuleType) -> bool:
    try:
        return all(find_spec(package) is not None for package in peer.PACKAGES)
    except ValueError:  # a package that was taken out of sight
        return False


def _measured(case: str, peer: ModuleType, right: float) -> Point:
    try:
        found = peer.press()
    except NoEquilibrium as none:
        return Point(case, peer.NAME, "force", None, None, f"no_equilibrium: {none.reason}")
    except Exception as error:  # of another version, say; it must not cost the rows before it
        return Point(case, peer.NAME, "force", None, None, f"failed: {type(error).__name__}: {error}")
    return Point(case, f"{peer.NAME}: {found.setting}", "force", abs(found.force / right - 1), found.seconds)
