"""Short runs whose records have some of everything: one in the twin, and one on mocks without any device."""

from __future__ import annotations

from pathlib import Path
from typing import Any

__all__ = ["MOCKS", "TWIN", "short_runs"]

#: a tree that moves, captures, averages, checks a reading and tidies up
TWIN = """\
format: stretch-tree/1
devices: {arm: Arm, gripper: Gripper, camera: DepthCamera}
scene: water_balloon
keys: {frame: DepthFrame, shallow: {type: DepthFrame}}
trees:
  main:
    sequence:
      - set_stretch: {stretch: 10 mm, speed: 100 mm/s}
      - capture: {frame: $frame}
      - average_frames: {count: 3, frame: $shallow}
      - retract: {clearance: 5 mm}
      - check: {that: arm.force < 5 N}
    finally: [set_stretch: {stretch: 0 mm, speed: 100 mm/s}]
"""
#: mocks under which palpate_stiffness succeeds
MOCKS = """\
format: stretch-mocks/1
tree: palpate_stiffness
readings: {arm.force: [1 N, 2 N]}
mocks:
  - {match: "**/approach", after: 100 ms, outputs: {touch: {height: 100 mm, height_sd: 0.01 mm}}}
  - {match: "**/average_frames", outputs: {frame: {}}}
  - {match: "**/segment_contact", outputs: {contact: {}}}
  - {match: "**/fit_sphere", outputs: {sphere: {radius: 30 mm, radius_sd: 0.2 mm}}}
  - match: main/feel_first/track_height
    outputs: {observed_top: {height: 99.1 mm, height_sd: 0.05 mm, fixed_sd: 0 mm, by_membrane: false}}
  - match: main/until/feel/track_height
    outputs: {observed_top: {height: 96.9 mm, height_sd: 0.05 mm, fixed_sd: 0 mm, by_membrane: false}}
  - {match: "**/press", after: 100 ms}
  - {match: "**/set_stretch"}
  - {match: "**/retract", after: 100 ms}
  - {match: "**/estimate_stiffness", outputs: {stiffness: {value: 1 N/mm, sd: 0.1 N/mm}}}
"""


def short_runs(folder: Path) -> dict[str, dict[str, Any]]:
    """Write the files of the runs into a folder, and return the arguments of `run` for `twin` and for `mocks`."""
    twin, mocks = folder / "twin.yaml", folder / "mocks.yaml"
    twin.write_text(TWIN, encoding="utf-8")
    mocks.write_text(MOCKS, encoding="utf-8")
    return {"twin": {"tree": twin}, "mocks": {"tree": "palpate_stiffness", "mocks": mocks}}
