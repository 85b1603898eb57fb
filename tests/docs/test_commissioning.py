"""The page of commissioning is followed on stand-ins, command by command; and its table of peak forces is what the code computes."""

import io
import os
import re
import runpy
import sys
from pathlib import Path

import pytest

from stretch_bt import check
from stretch_bt.cli.app import main
from stretch_bt.hardware.cell_file import load_cell
from stretch_bt.hardware.emulators.serve import serving_elsewhere
from stretch_bt.hardware.peak_force import peak_force
from stretch_bt.hardware.realsense.library import library

DOCS = runpy.run_path(str(Path(__file__).with_name("test_docs.py")))
ROOT = DOCS["ROOT"]
PAGE = ROOT / "docs" / "commissioning.md"
HOST = f"127.7.{os.getpid() // 250 % 250}.{1 + os.getpid() % 250}"
#: how each command of the page ends on the stand-ins, and the words that stand in what it prints
FOLLOWED = {
    "stretch-bt check lab.yaml": (0, "no errors"),
    "stretch-bt status lab.yaml --device arm": (0, "hand at 0.0, 0.0, 200.0 mm"),
    "stretch-bt doctor lab.yaml": (3, "no  gripper: ready: it is not activated"),
    "stretch-bt move lab.yaml --up 10mm --speed 5mm/s": (0, "ok  arm: the hand stands at a height of 210.0 mm"),
    "stretch-bt move lab.yaml --down 10mm --speed 5mm/s": (0, "ok  arm: the hand stands at a height of 200.0 mm"),
    "stretch-bt stop lab.yaml": (0, "ok  arm: no program runs on the controller, and the arm stands"),
    "stretch-bt activate lab.yaml": (0, "gripper: activated"),
    "stretch-bt run rest.yaml --cell lab.yaml --out rest": (0, "SUCCESS"),
    "stretch-bt check air.yaml --cell lab.yaml": (0, "no errors"),
    "stretch-bt run air.yaml --cell lab.yaml --out air": (0, "SUCCESS"),
    "stretch-bt check touch.yaml --cell lab.yaml": (0, "no errors"),
}
#: deadlines after these lines of the cell file: a machine that is busy is no fault
PATIENT = {
    "    model: ur5\n": "    watchdog: 1 Hz\n    lost_after: 2 s\n    heartbeat: 5 s\n",
    "    use: realsense\n": "    lost_after: 5 s\n",
    "    model: 2f140\n": "    timeout: 500 ms\n",
}
#: commands not followed here: the robot's stand-ins; and two with camera and membrane simulated too, which the tests of wired runs follow
APART = (
    "stretch-bt emulate ur robotiq ati realsense --scene water_balloon --control 29998",
    "stretch-bt calibrate-hand lab.yaml --out hand.yaml",
    "stretch-bt run touch.yaml --cell lab.yaml --out touch",
)


def commands():
    """Return the commands of the page, in its order."""
    blocks = [block for block in DOCS["blocks"](PAGE) if block.language == "console"]
    return [line for block in blocks for line in block.text.splitlines() if line.startswith("stretch-bt")]


@pytest.fixture
def folder(tmp_path):
    """The files of the page, with the addresses of stand-ins written as the page asks."""
    for block in DOCS["blocks"](PAGE):
        if "file" in block.marks:
            text = re.sub(r"\b(host: [\d.]+|serial: \S+)", f"host: {HOST}", block.text)
            for line, deadlines in PATIENT.items():
                text = text.replace(line, line + deadlines)
            (tmp_path / block.marks["file"]).write_text(text)
    return tmp_path


def test_every_command_of_the_page_is_followed_or_named_apart():
    assert sorted({*commands()}) == sorted({*FOLLOWED, *APART})


@pytest.fixture
def followed(folder, monkeypatch, capfd):
    """Carry out a command in the folder of the page, with a yes to what it asks: (exit code, standard output, standard error)."""
    monkeypatch.chdir(folder)

    def follow(command):
        monkeypatch.setattr(sys, "argv", command.split())
        monkeypatch.setattr(sys, "stdin", io.StringIO("y\n"))
        with pytest.raises(SystemExit) as exited:
            main()
        return exited.value.code or 0, *capfd.readouterr()

    return follow


def test_the_page_can_be_followed_on_the_stand_ins(followed):
    try:
        library()
    except ImportError as error:
        pytest.skip(str(error))
    with serving_elsewhere(["ur", "robotiq", "ati", "realsense"], host=HOST):
        for command in (line for line in commands() if line in FOLLOWED):
            ended, out, err = followed(command)
            code, said = FOLLOWED[command]
            assert (ended, said in out) == (code, True), f"{command}\n{out}\n{err}"


CELL = """\
format: stretch-cell/1
devices:
  arm: {type: Arm, use: ur, host: 192.168.1.10, model: MODEL, base: {x: -500 mm}, hand: {z: 300 mm}, source: an example}
limits: {force: 20 N, stiffness: STIFFNESS N/mm}
"""
TREE = """\
format: stretch-tree/1
devices: {arm: Arm}
keys: {touch: Touch}
trees: {main: {sequence: [set: {touch: none}, roll: {speed: SPEED mm/s}]}}
"""


def table_of(model, page):
    """Yield (speed, mm/s; stiffness, N/mm; measured and computed force, N; whether it has a star) from the table of a model."""
    text = page.partition(f"\n{model}:\n\n")[2].partition("\n\n")[0].splitlines()
    stiffnesses = re.findall(r"(\d+) N/mm", text[0])
    for line in text[2:]:
        speed, *cells = re.findall(r"(\d+) mm/s|(\d+) / (\d+)( \*)?", line)
        for stiffness, (_, measured, computed, star) in zip(stiffnesses, cells, strict=True):
            yield int(speed[0]), int(stiffness), int(measured), int(computed), bool(star)


@pytest.mark.parametrize("model", ["UR5", "UR5e"])
def test_the_table_of_peak_forces_is_what_is_computed_and_what_check_says(tmp_path, model):
    rows = list(table_of(model, (ROOT / "docs" / "devices.md").read_text("utf-8")))
    assert len(rows) == 24
    for speed, stiffness, measured, computed, star in rows:
        tree, cell = tmp_path / "tree.yaml", tmp_path / "cell.yaml"
        tree.write_text(TREE.replace("SPEED", str(speed)))
        cell.write_text(CELL.replace("MODEL", model.lower()).replace("STIFFNESS", str(stiffness)))
        spec = load_cell(cell)
        stopping = spec.devices["arm"].options.stopping(spec.limits)
        assert computed == round(peak_force(speed / 1e3, stiffness * 1e3, 20.0, stopping).stopped)
        assert star is any(finding.code == "cell-force" for finding in check(tree, cell=cell))
        assert 0.4 * computed <= measured <= 1.05 * computed
