"""Other programs on the same problem, each with the method that it has.

A peer is a module of this package with its `NAME` and the `PACKAGES` that it needs. Those of `PRESSES` have `press()`: a
sphere of 20 mm, 10 mm deep, stretch 30 mm, shear modulus 40 kPa, 0.61 N; each models a membrane with its own law, so that the
error of law, elements and contact is one figure.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import lru_cache, partial
from importlib import import_module
from importlib.util import find_spec
from typing import NamedTuple

from stretch_bt.accuracy.job import Job
from stretch_bt.accuracy.points import FAILED, SKIPPED, Answer, Setting
from stretch_bt.errors import NoAnswer

__all__ = ["DEPTH", "DIAMETER", "PRESSES", "SHEAR_MODULUS", "STRETCH", "PeerAnswer", "guarded", "names", "presses"]

PRESSES = ("mujoco_flex", "newton_vbd")
DIAMETER, STRETCH, DEPTH = 0.020, 0.030, 0.010  # m
SHEAR_MODULUS = 40e3  # Pa
DENSITY = 1070.0  # kg/m^3, which a dynamic simulator needs to come to rest
_REFERENCE = 0.004  # error of the force of the sheet on fine elements: the difference of two independent programs
_SECONDS = 3.0


class PeerAnswer(NamedTuple):
    """The answer of a peer: the force, N, once the sheet rests; CPU seconds from the flat stretched sheet."""

    force: float
    seconds: float


def guarded(peer: str, job: Job) -> Job:
    """Return a job of a peer that says so where it is not installed, or ends in an exception of its own."""
    packages: tuple[str, ...] = import_module(f"{__name__}.{peer}").PACKAGES

    def run() -> list[Answer]:
        if not _installed(packages):
            return [Answer(job.error_kind, None, None, status=SKIPPED, reason="install stretch-bt[peers]")]
        try:
            return [*job.run()]
        except NoAnswer:
            raise
        except ImportError as error:  # of a library of the system, say
            return [Answer(job.error_kind, None, None, status=SKIPPED, reason=f"it cannot be imported: {error}")]
        except Exception as error:  # of another version, say; it must not cost the rows before it
            return [Answer(job.error_kind, None, None, status=FAILED, reason=f"{type(error).__name__}: {error}")]

    return replace(job, run=run, seconds=job.seconds if _installed(packages) else 0.0)


def names(peers: Iterable[str]) -> frozenset[str]:
    """Return the names of peers."""
    return frozenset(str(import_module(f"{__name__}.{peer}").NAME) for peer in peers)


def presses() -> Iterator[Job]:
    """Yield the force of each peer against the force of the sheet on fine elements."""
    case = f"sphere 20 mm, stretch 30 mm, depth 10 mm, shear modulus {SHEAR_MODULUS / 1e3:g} kPa"
    for peer in PRESSES:
        module = import_module(f"{__name__}.{peer}")
        setting = Setting(module.NAME, module.SETTING)
        yield guarded(peer, Job(case, setting, "force", _SECONDS, partial(_pressed, peer)))


def _pressed(peer: str) -> list[Answer]:
    found: PeerAnswer = import_module(f"{__name__}.{peer}").press()
    return [Answer("force", abs(found.force / _right() - 1), found.seconds, _REFERENCE)]


@lru_cache(maxsize=1)
def _right() -> float:
    from stretch_bt.simulation.membrane.press import press
    from stretch_bt.simulation.membrane.sheet.settings import Settings

    fine = Settings(mesh=0.5e-3, growth=1.2)
    return press(f"sphere:{DIAMETER}m", STRETCH, DEPTH, shear_modulus=SHEAR_MODULUS, settings=fine).force


def _installed(packages: Iterable[str]) -> bool:
    try:
        return all(find_spec(package) is not None for package in packages)
    except ValueError:  # a package that was taken out of sight
        return False
