"""No module of the current folder is executed by a process that is begun for a device."""

import subprocess
import sys
from pathlib import Path

import pytest

from stretch_bt.hardware import isolated

#: names that a process of a driver imports
NAMES = ("rtde_receive", "rtde_control", "numpy", "stretch_bt")
OPEN = """
import sys, time
from stretch_bt.hardware.cell import open_cell
from stretch_bt.hardware.cell_file import load_cell
open_cell(load_cell(sys.argv[1]), now=time.monotonic).close()
"""
COMMAND = Path(sys.executable).with_name("stretch-bt")


@pytest.fixture
def hostile(tmp_path):
    """Return a folder whose modules leave a file when they are executed."""
    folder = tmp_path / "hostile"
    folder.mkdir()
    for name in NAMES:
        (folder / f"{name}.py").write_text("open(__file__ + '.ran', 'w').close()\n")
    return folder


def executed(folder):
    return sorted(path.name for path in folder.glob("*.ran"))


def run(folder, *command):
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=90, check=False)


def test_opening_a_cell_executes_nothing_of_the_current_folder(stand_in, live_cell, hostile):
    behind, _ = stand_in("ur")
    path = live_cell("ur", "rtde", behind.host)
    done = run(hostile, sys.executable, "-P", "-c", OPEN, str(path))
    assert executed(hostile) == []
    assert done.returncode == 0, done.stderr


def test_checking_a_tree_executes_nothing_of_the_current_folder(hostile):
    done = run(hostile, str(COMMAND), "check", "palpate_stiffness", "--cell", "lab_ur5")
    assert executed(hostile) == []
    assert "Traceback" not in done.stderr


def test_the_current_folder_is_left_out_however_it_is_written(hostile, monkeypatch):
    monkeypatch.chdir(hostile)
    monkeypatch.setattr(sys, "path", ["", ".", str(hostile), *sys.path])
    assert str(hostile.resolve()) not in isolated.environment()["PYTHONPATH"].split(":")


def test_the_folder_of_the_package_stays(monkeypatch):
    home = Path(isolated.__file__).resolve().parents[2]
    monkeypatch.chdir(home)
    monkeypatch.setattr(sys, "path", [str(home), *sys.path])
    assert str(home) in isolated.environment()["PYTHONPATH"].split(":")
