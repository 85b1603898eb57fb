"""Ticks of one task that goes on for days of virtual time, on the twin, without a record."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import stretch_bt
from drifts.course import Course, Finding
from stretch_bt.runtime.onlooker import Onlooker
from stretch_bt.runtime.runner import Runner

_DONE = "the end of its course"
_LONGEST = 1e9  # s
SCENE = """\
format: stretch-scene/1
doc: A ball on a post, under the membrane of a calibrated law, which answers at once.
object: {type: sphere, diameter: 20 mm, base: 40 mm, rigid: true}
fidelity: hertz
tolerance: {force: 3 %, height: 0.3 mm}
effects: {force_sensor_noise: on, white_noise: on}
"""
#: a lap presses, looks once, waits, takes both ways of a selector, and logs; it never ends by itself
TREE = """\
format: stretch-tree/1
devices: {arm: Arm, gripper: Gripper, camera: DepthCamera}
trees:
  main:
    out: {laps: {default: 0}, touches: {default: 0}}
    guard: {that: arm.force < 20 N, name: force_limit}
    sequence:
      - set_stretch: {stretch: 20 mm}
      - approach
      - until:
          that: laps < 0
          max: 1000000
          do:
            - press: {depth: 6 mm}
            - capture: {frame}
            - detect_contact: {frame, in_contact}
            - set: {laps: laps + 1}
            - selector:
                - sequence: [check: {that: in_contact, name: touching}, set: {touches: touches + 1}]
                - set: {touches: touches}
            - parallel: [{name: a, wait: {duration: 2 s}}, {name: b, wait: {duration: 3 s}}]
            - for_each: {items: [0.5 s, 1 s], as: $pause, collect: {pauses: $pause}, do: {wait: {duration: $pause}}}
            - {retract: {clearance: 2 mm}, log: "lap $laps, $touches touches"}
    finally: [retract: {clearance: 20 mm}]
"""


class _Counted(Onlooker):
    """Reports each tick of a run to a course, which begins with the first lap, and ends the run with it."""

    def __init__(self, count: int) -> None:
        self.count, self.tick, self.first = count, 0, 0
        self.course: Course | None = None

    def watch(self, runner: Runner) -> None:
        self.runner = runner
        runner.watchers.append(self)

    def write(self, key: str, value: object, sd: float | None, path: str) -> None:
        if self.course is None and key.endswith("laps") and value:
            self.course, self.first = Course(self.count), self.tick

    def begin_tick(self, tick: int, time: float) -> None:
        self.tick = tick
        if self.course is not None and tick - self.first <= self.count:
            self.course.done(tick - self.first)
            if tick - self.first == self.count:
                self.runner.interrupt(_DONE)


def ticks(count: int, seed: int = 0, tree: str = TREE) -> list[Finding]:
    """Tick a tree `count` times from its first lap on, and return what that took."""
    counted = _Counted(count)
    with TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "tree.yaml").write_text(tree, encoding="utf-8")
        (folder / "scene.yaml").write_text(SCENE, encoding="utf-8")
        result = stretch_bt.run(
            folder / "tree.yaml",
            scene=folder / "scene.yaml",
            seed=seed,
            record="none",
            longest=_LONGEST,
            watch=counted.watch,
        )
    if _DONE not in result.reason or counted.course is None:
        raise SystemExit(f"the task ended with {result.status} after {result.ticks} ticks: {result.reason}")
    return [
        Finding("ticks in all", result.ticks),
        Finding("laps", result.outputs["laps"]["value"]),
        *counted.course.findings(),
    ]
