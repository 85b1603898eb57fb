"""The contract of every driver, as a class of tests for pytest: each clause says what it protects, each failure says the mistake."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import wraps
from pathlib import Path
from typing import Any

import pytest

from stretch_bt.errors import InvalidInput, StretchError
from stretch_bt.source import did_you_mean
from stretch_bt.testing.contract.cut import CutClauses, CutMotionClauses
from stretch_bt.testing.contract.life import LifeClauses
from stretch_bt.testing.contract.sensing import CameraClauses, ForceClauses
from stretch_bt.testing.contract.trial import READINGS, Contract, fault
from stretch_bt.testing.contract.turning import ArmClauses

__all__ = ["device_contract"]

_OF_KIND: dict[str, tuple[type[LifeClauses], ...]] = {
    "Arm": (ArmClauses,),
    "Gripper": (CutMotionClauses,),
    "DepthCamera": (CameraClauses, CutClauses),
    "ForceSensor": (ForceClauses, CutClauses),
}
#: why the clauses that need an argument are skipped without it
_WITHOUT = {
    "moves": "`moves` was left out, so nothing moves: name two places, between which it may move",
    "cut": "`cut` was left out, so no loss is tested: name what breaks the connection",
}


def device_contract(
    cell: str | Path | Callable[[Any], str | Path],
    device: str,
    *,
    start: Callable[[], Any] | None = None,
    moves: Sequence[Any] | Callable[[Any], Sequence[Any]] | None = None,
    tolerance: float,
    latency: float,
    cut: Callable[..., Any] | None = None,
    speed: float | None = None,
    scene: str | Path | None = None,
    kind: str | None = None,
    load: Callable[..., Any] | None = None,
) -> type[Any]:
    """Return a class of tests for one device of a cell; give it a name that begins with `Test`.

    Nothing moves unless `moves` is given. Each test brings up the simulator anew, opens the device and closes it. A test that
    needs more than is given is skipped, and says what to give.

    Parameters
    ----------
    cell
        A cell file or the name of a shipped cell; or a function that returns one from what `start` gave, where a port is known only then.
    device
        Name of the device in it.
    start
        Brings up a simulator: returns a context manager, a generator that yields once, an object with `stop` or `close`, or a process
        (`Popen`), which is terminated, and killed where it does not end.
    moves
        Two places, between which a device that moves is moved: openings, m, or poses, of different rotation where that is to be tested;
        or a function that returns them from the open device.
    tolerance
        How far from its target a motion may end, m; the largest force after `zero()`, N; of no meaning for a camera.
    latency
        The greatest age that a reading may have, s.
    cut
        Breaks the connection of the simulator, which it is given where it takes an argument.
    speed
        Speed of the motions, m/s; by default 50 mm/s, or what the cell allows. Between near places some are slower, so that a stop shows.
    scene
        What is simulated, for a device of the twin.
    kind
        Kind of the device, where the cell file is known only after `start`.
    load
        Puts more than two tolerances on a force sensor: acts on the simulator, or on the open device where there is none, which it is given
        where it takes an argument.
    """
    if kind is not None and kind not in READINGS:
        hint = did_you_mean(kind, READINGS) or f"one of {', '.join(READINGS)}"
        raise InvalidInput(f"there is no contract of the kind {kind!r}; {hint}")
    kind = kind or _kind(cell, device, start)
    if moves is not None and (kind not in ("Arm", "Gripper") or not (callable(moves) or len(moves) == 2)):
        raise InvalidInput(f"moves of a {kind}: write two openings, m, of a Gripper, or two poses of an Arm")
    if load is not None and kind != "ForceSensor":
        raise InvalidInput(f"load is for a ForceSensor, and {device!r} is a {kind}; leave it out")
    contract = Contract(cell, device, start, moves, tolerance, latency, cut, speed, scene, load, kind)
    doc = f"What the {kind} {device!r} keeps to."
    made: type[Any] = type(
        f"Test{kind}Contract", _OF_KIND[kind], {"__doc__": doc, "contract": contract, "__test__": True}
    )
    lacking = {name for name, given in (("moves", moves), ("cut", cut)) if given is None}
    for name in dir(made):
        if name.startswith("test_"):
            test, clauses = (
                getattr(made, name),
                next(cls for cls in made.__mro__ if issubclass(cls, LifeClauses) and name in vars(cls)),
            )
            missing = [what for what in clauses.needs if what in lacking]
            setattr(made, name, _skipped(test, _WITHOUT[missing[0]]) if missing else _in_words(test))
    return made


def _skipped(test: Callable[[Any], None], reason: str) -> Callable[[Any], None]:
    """Return a test that is skipped, before a simulator is brought up for it."""

    @wraps(test)
    def skip(self: Any) -> None:
        pytest.skip(reason)

    marked: Callable[[Any], None] = pytest.mark.skip(reason=reason)(skip)
    return marked


def _in_words(test: Callable[[Any], None]) -> Callable[[Any], None]:
    """Return a test that fails by the words of an error of this package, instead of a traceback into the suite."""

    @wraps(test)
    def run(self: Any) -> None:
        try:
            test(self)
        except StretchError as error:
            fault(f"{type(error).__name__}: {error}")

    return run


def _kind(cell: Any, device: str, start: Callable[[], Any] | None) -> str:
    """Return the kind of a device, for which a simulator may be brought up for a moment."""
    contract = Contract(cell, device, start if callable(cell) else None, None, 0.0, 0.0, None, None, None)
    with contract.simulator() as (_, spec):
        if device not in spec.devices:
            raise InvalidInput(f"the cell has no device {device!r}, but {', '.join(spec.devices)}")
        kind = spec.devices[device].type
    if kind not in READINGS:
        raise InvalidInput(f"{device!r} is a {kind}, of which there is no contract")
    return kind
