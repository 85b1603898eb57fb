"""What becomes of a hand that moves as connections to its controller are lost: an arm alone, on loopback, with the deadlines that it has by itself.

Run with `python benchmarks/arm_losses.py [rounds] [ur|ur5e] [word ...]`; words choose among the names of the losses. The stand-in is in a
process of its own. In each round a run retracts the hand at 20 or 250 mm/s until one loss comes. All times and the way are by the
stand-in's clock: `stood`, from the loss until the hand stood; `way`, how far it went; `over`, from the loss until the run was over, its
record and report written. Asked: the hand stands within 0.3 s at 20 mm/s and 0.45 s at 250 mm/s and does not move again, the run ends as
FAULT within 1 s, and no program runs after it. Each breach is printed, and counted under `bad`.
"""

from __future__ import annotations

import statistics
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from wired_cell import own_host

from stretch_bt import run
from stretch_bt.errors import DeviceFault
from stretch_bt.hardware.emulators.control import control
from stretch_bt.hardware.emulators.serve import serving_elsewhere

HOST = own_host()
CELL = """\
format: stretch-cell/1
devices:
  arm:
    type: Arm
    use: ur
    host: HOST
    model: MODEL
    base: {x: -500 mm}
    hand: {z: 300 mm, rx: 180 deg}
    source: the stand-in's own
    tare: false
    joint_speed: 120 deg/s  # 250 mm/s take more than the default
limits: {height: {min: 0 mm, max: 400 mm}, speed: 1000 mm/s}  # a busy stand-in's clock is slow, and its hand quick by it
"""
TREE = """\
format: stretch-tree/1
devices: {arm: Arm}
trees: {main: {retract: {clearance: 150 mm, speed: SPEED mm/s}}}
"""
#: speeds, m/s, and how long the hand may go on at each, s; how long the run may take to end
SPEEDS = {0.02: 0.3, 0.25: 0.45}
END = 1.0
#: how long a hand that stands is watched, s
_STANDS = 0.5
CONNECTIONS = ("receive", "control", "rtde")
WAYS = {"reset": ("reset", {}), "FIN": ("close", {}), "half-close out": ("close", {"direction": "out"}),
        "half-close in": ("close", {"direction": "in"}), "silent out": ("freeze", {"direction": "out"}),
        "silent in": ("freeze", {"direction": "in"}), "silent": ("freeze", {})}  # fmt: skip


@dataclass
class Rounds:
    """What came of one loss at one speed."""

    stood: list[float] = field(default_factory=list)
    way: list[float] = field(default_factory=list)
    over: list[float] = field(default_factory=list)
    bad: list[str] = field(default_factory=list)
    reason: str = ""


def losses() -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Yield name, fault and parameters of each loss."""
    for name, (fault, parameters) in WAYS.items():
        for connection in (*CONNECTIONS, "all"):
            yield f"{name}, {connection}", fault, {**parameters, "connection": connection}


class Losing:
    """Runs on one stand-in, each ended by a loss."""

    def __init__(self, address: tuple[str, int], model: str, folder: Path) -> None:
        self._address, self._model, self._folder = address, model, folder
        self._count = 0
        (folder / "cell.yaml").write_text(
            CELL.replace("HOST", HOST).replace("MODEL", "ur5" if model == "ur" else model)
        )

    def tell(self, fault: str, **parameters: Any) -> None:
        """Have the stand-in show a fault."""
        control(self._address, {"do": "inject", "device": self._model, "fault": fault, **parameters})

    def state(self) -> dict[str, Any]:
        """Return how the stand-in stands."""
        found: dict[str, Any] = control(self._address, {"do": "list"})["devices"][self._model]["state"]
        return found

    def once(self, speed: float, fault: str, parameters: dict[str, Any], rounds: Rounds) -> bool:
        """Do a run that a loss ends, note what came of it, and return whether the loss came in time, which it may not on a busy machine."""
        self._count += 1
        tree, record = self._folder / "tree.yaml", self._folder / f"record{self._count}"
        tree.write_text(TREE.replace("SPEED", f"{1e3 * speed:g}"))
        self.tell("home")
        begun = self.state()["time"]
        over = threading.Event()
        harm = threading.Thread(target=self._harm, args=(speed, fault, parameters, over))
        harm.start()
        try:
            result = run(tree, cell=self._folder / "cell.yaml", out=record)
            ended, reason = self.state(), "; ".join([result.reason, *result.errors])
        except DeviceFault as error:
            rounds.bad.append(f"it did not open: {error}")
            return True
        finally:
            over.set()
            harm.join()
            control(self._address, {"do": "clear"})
        time.sleep(_STANDS)
        later = self.state()
        if later["injected"] <= begun:
            return False
        rounds.reason = reason
        rounds.stood.append(max(later["moved"] - later["injected"], 0.0))
        rounds.way.append(later["way"])
        rounds.over.append(ended["time"] - ended["injected"])
        rounds.bad += [f"{what}: {reason}" for what in wrong(result.status, speed, rounds, later)]
        return True

    def _harm(self, speed: float, fault: str, parameters: dict[str, Any], over: threading.Event) -> None:
        """Do harm once the hand has its speed."""
        while not over.is_set():
            if self.state()["speed"] > 0.9 * speed:
                self.tell(fault, **parameters)
                return
            time.sleep(0.005)


def wrong(status: str, speed: float, rounds: Rounds, later: dict[str, Any]) -> Iterator[str]:
    """Yield each requirement that the latest round broke; `later` is the state of the stand-in a while after it."""
    if status != "FAULT":
        yield f"it ended as {status}"
    if rounds.stood[-1] > SPEEDS[speed]:
        yield f"the hand stood after {rounds.stood[-1]:.3f} s"
    if rounds.over[-1] > END:
        yield f"the run was over after {rounds.over[-1]:.3f} s"
    if later["running"]:
        yield "a program runs"


def main(count: int, model: str, words: list[str]) -> None:
    """Print a line for each loss and speed."""
    bad = 0
    with (
        tempfile.TemporaryDirectory() as folder,
        serving_elsewhere([model], host=HOST, control=0) as servers,
    ):
        address = servers.served.control
        assert address is not None
        losing = Losing(address, model, Path(folder))
        print(
            f"{'loss':28s}{'mm/s':>5s}{'rounds':>7s}{'stood, s':>16s}{'way, mm':>9s}{'over, s':>16s}{'bad':>5s}  said at last"
        )
        for name, fault, parameters in losses():
            for speed in SPEEDS:
                if not all(word in name for word in words):
                    continue
                rounds = Rounds()
                for _ in range(count):
                    while not losing.once(speed, fault, parameters, rounds):
                        pass
                bad += len(rounds.bad)
                told(name, speed, rounds)
    print(f"{bad} bad")


def told(name: str, speed: float, rounds: Rounds) -> None:
    """Print what came of one loss at one speed: medians and greatest."""
    stood, over = (f"{statistics.median(v):.3f} {max(v):.3f}" if v else "-" for v in (rounds.stood, rounds.over))
    way = f"{1e3 * max(rounds.way):.1f}" if rounds.way else "-"
    print(
        f"{name:28s}{1e3 * speed:5g}{len(rounds.stood):7d}{stood:>16s}{way:>9s}{over:>16s}{len(rounds.bad):5d}  {rounds.reason[:230]}",
        flush=True,
    )
    for bad in rounds.bad:
        print(f"    {bad}", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 3, sys.argv[2] if len(sys.argv) > 2 else "ur", sys.argv[3:])
