"""The main job in numbers: stiffness beside the truth, a recorded press, hostile files, and mocked tasks.

    python benchmarks/main_job.py [SEEDS]

CPU seconds of one core; accuracy against the scene's truth, or the recorded wrench.
"""

import json
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from stretch_bt import check, run
from stretch_bt.sweep import sweep

ROOT = Path(__file__).parents[1]
PRESS = ROOT.parent / "shared" / "data" / "membrane_press" / "punyo_press_z.npz"
MOCKS = ROOT / "tests" / "trees" / "mocks"
BALLOONS = ("air_balloon", "water_balloon", "pudding_balloon", "seeds_balloon")


def stiffness(folder: Path, seeds: int) -> None:
    print(f"palpate_stiffness, seeds 0 to {seeds - 1}")
    print(
        f"{'scene':16s} {'truth':>6s} {'mean':>7s} {'rms error':>10s} {'stated sd':>10s} {'ticks':>6s} {'task s':>7s} {'CPU s':>6s}"
    )
    file = folder / "stiffness.yaml"
    file.write_text(
        f"format: stretch-sweep/1\ntree: palpate_stiffness\nscene: [{', '.join(BALLOONS)}]\nseeds: {seeds}\n"
    )
    swept = sweep(file, out=folder / "stiffness")
    rows = [json.loads(line) for line in (swept.folder / "rows.jsonl").read_text().splitlines()]
    assert all(row["status"] == "SUCCESS" for row in rows), [row["reason"] for row in rows]
    for scene in BALLOONS:
        results = [row for row in rows if row["scene"] == scene]
        truth = np.array([row["truth"]["stiffness"]["value"] for row in results])
        found = np.array([row["outputs"]["stiffness"]["value"] for row in results])
        sd = np.mean([row["outputs"]["stiffness"]["sd"] for row in results])
        rms = float(np.sqrt(np.mean((found / truth - 1) ** 2)))
        mean = [float(np.mean([row[n] for row in results])) for n in ("ticks", "task_seconds", "cpu_seconds")]
        print(
            f"{scene:16s} {truth[0]:6.2f} {found.mean():7.3f} {100 * rms:8.2f} % {100 * sd / found.mean():8.2f} %"
            f" {mean[0]:6.0f} {mean[1]:7.1f} {mean[2]:6.2f}"
        )


def recorded_press(folder: Path) -> None:
    if not PRESS.exists():
        print("recorded press: not on this machine, passed over")
        return
    (folder / "cell.yaml").write_text(
        "format: stretch-cell/1\ndevices:\n  camera: {type: DepthCamera, use: replay, depth: z_0p1mm, time: t, unit: 0.1 mm,"
        f" intrinsics: K, roi: roi, file: {PRESS}}}\n"
    )
    result = run("watch_contact", cell=folder / "cell.yaml", out=folder / "watch")
    events = map(json.loads, (folder / "watch" / "events.jsonl").read_text().splitlines())
    heights = [e["value"] for e in events if e["type"] == "write" and e["key"] == "main/height"]
    with np.load(PRESS) as data:
        force, times = np.linalg.norm(data["wrench"][:, :3], axis=1), data["t"] - data["t"][0]
    pressed = times[force > 1.5]
    released = times[times > pressed[-1]][0]
    print(
        f"recorded press: {len(heights)} frames, correlation of height with force {np.corrcoef(heights, force)[0, 1]:.4f}"
    )
    for name, truth in (("contact_on", pressed[0]), ("contact_off", released)):
        print(f"  {name}: {result.outputs[name]['value']:.3f} s, by the wrench {truth:.3f} s")


def hostile_files(folder: Path) -> None:
    bomb = "a: &a [x,x,x,x,x,x,x,x,x,x]\n" + "".join(
        f"{chr(98 + i)}: &{chr(98 + i)} [{','.join([f'*{chr(97 + i)}'] * 10)}]\n" for i in range(20)
    )
    files = {
        "empty": b"",
        "binary": bytes(range(256)) * 100,
        "50 MB": b"a: b\n" * 10_000_000,
        "anchors": bomb.encode(),
        "deep": b"[" * 100_000,
        "long line": b"doc: " + b"x" * 900_000,
    }
    print("hostile files")
    for name, content in files.items():
        path = folder / f"{name.replace(' ', '_')}.yaml"
        path.write_bytes(content)
        report(name, path)
    report("folder", folder)


def report(name: str, path: Path) -> None:
    began = time.perf_counter()
    found = check([path])
    seconds = time.perf_counter() - began
    assert found
    print(f"  {name:10s} {1e3 * seconds:7.1f} ms  {found[0].code}: {found[0].message}")


def mocked(folder: Path) -> None:
    print("shipped trees under mocks")
    for path in sorted(MOCKS.glob("*.yaml")):
        tree = path.stem.rpartition("_")[0]
        began = time.perf_counter()
        result = run(tree, mocks=path, out=folder / path.stem)
        seconds = time.perf_counter() - began
        assert not result.unmet
        print(f"  {path.stem:28s} {result.status:8s} {result.ticks:4d} ticks {1e3 * seconds:6.0f} ms")


def main() -> None:
    seeds = int(sys.argv[1]) if len(sys.argv) > 1 else 10
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        mocked(folder)
        hostile_files(folder)
        recorded_press(folder)
        stiffness(folder, seeds)


if __name__ == "__main__":
    main()
