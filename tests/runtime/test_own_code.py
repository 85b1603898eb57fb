"""The place where own code breaks is reported: its last own line, and every frame in the result, the record's report and, if asked, the terminal."""

import json
import re
import sys
from pathlib import Path
from typing import Any

import pytest

from stretch_bt.cli.app import main
from stretch_bt.errors import LONGEST_TEXT

MODULE = '''
import json
from stretch_bt import Behavior, In, Out, Status, node; from stretch_bt.errors import *
from stretch_bt.units import Length

def read(text):
    return json.loads(text)
%s
@node
class BreaksOnce(Behavior):
    """Breaks."""
    y: Out[Length]
%s
'''
#: code of a node, its line in `own`, and a part of the message
BREAKS = {
    "    def update(self): return read('{')": ("7 in read", "JSONDecodeError: Expecting"),
    "    def update(self): raise ValueError('boom')": ("13 in update", "ValueError: boom"),
    "    def update(self): raise SystemExit(3)": ("13 in update", "SystemExit: 3"),
    "    def update(self): raise ValueError(chr(0xD800))": ("13 in update", r"ValueError: \ud800"),
    "    def update(self): self.reason = 5": ("13 in update", "its reason is 5; a reason is one sentence, a str"),
    "    def update(self): raise IllConditioned(None)": (
        "13 in update",
        "IllConditioned takes its reason as text, one sentence, not a NoneType",
    ),
    "    def update(self): self.y = 'two'": ("13 in update", "wrote 'y' wrongly: it takes a Length"),
    "    def initialise(self): return 1 / 0\n    def update(self): return Status.SUCCESS": (
        "13 in initialise",
        "ZeroDivisionError",
    ),
    "    def update(self): return Status.FAILURE\n    def terminate(self, new): raise ValueError('end')": (
        "14 in terminate",
        "terminate() broke (ValueError: end)",
    ),
}
TREE = """
format: stretch-tree/1
imports: {{own: {module}}}
keys: {{y: Length}}
trees:
  main:
    sequence: [breaks_once: {{y: $y}}]
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, own_nodes: None, request: pytest.FixtureRequest) -> Any:
    monkeypatch.chdir(tmp_path)
    module = "own_" + re.sub(r"\W+", "_", request.node.name)[-60:]

    def write(body: str, head: str = "") -> str:
        (tmp_path / f"{module}.py").write_text(MODULE % (head, body))
        (tmp_path / "tree.yaml").write_text(TREE.format(module=module))
        return f"{module}.py"

    yield write
    sys.modules.pop(module, None)


@pytest.fixture
def command(monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> Any:
    def call(*arguments: str) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["stretch-bt", *arguments])
        with pytest.raises(SystemExit) as exited:
            main()
        return int(exited.value.code or 0), *capfd.readouterr()

    return call


@pytest.mark.parametrize("body", BREAKS)
def test_the_last_own_line_is_told_and_every_frame_is_kept(
    body: str, folder: Any, command: Any, tmp_path: Path
) -> None:
    name = folder(body)
    place, told = BREAKS[body]
    code, printed, _ = command("run", "tree.yaml", "-q", "--out", "record")
    assert code == 1
    assert f"at {name}:{place}" in printed
    assert told in " ".join(printed.split())
    assert "Traceback" not in printed
    [broken] = json.loads((tmp_path / "record/result.json").read_text())["broken"]
    assert broken["at"] == f"{name}:{place}"
    assert broken["traceback"].startswith("Traceback")
    report = (tmp_path / "record/report.html").read_text()
    assert f"{name}:{place}" in report
    assert "Traceback" in report
    assert str(tmp_path) not in (tmp_path / "record/events.jsonl").read_text()


def test_every_frame_is_printed_when_asked(folder: Any, command: Any) -> None:
    folder("    def update(self): return read('{')")
    _, printed, _ = command("run", "tree.yaml", "-q", "--traceback")
    printed = printed[printed.index("Traceback") :]
    assert printed.index("in update") < printed.index("in read") < printed.index("raw_decode")


LONG = ["ValueError(%s)", "InvalidInput(%s)", "NoAnswer(%s)", "DeviceFault('arm', %s)"]


@pytest.mark.parametrize("error", LONG)
@pytest.mark.parametrize("where", ["update", "prepare"])
def test_a_very_long_text_is_cut_off_and_its_length_stated(
    error: str, where: str, folder: Any, command: Any, tmp_path: Path
) -> None:
    raised = error % "'long' * 500_000"
    folder(f"    def update(self): return Status.FAILURE\n    def {where}(self): raise {raised}")
    _, *shown = command("run", "tree.yaml", "-q", "--json", "--traceback", "--out", "record")
    kept = [path.read_text() for path in (tmp_path / "record").glob("*.*[ln]")]
    assert len(kept) == 4 or where == "prepare"
    assert max(len(text) for text in (*shown, *kept)) < 20 * LONGEST_TEXT
    assert re.search(r"long[long]*\.\.\. \(cut off; it has 2000\d\d\d characters\)", shown[0])


#: what breaks before the first tick
EARLY = {
    "    def prepare(self): raise ValueError('boom')\n    def update(self): return Status.SUCCESS": "prepare() broke (ValueError: boom) at",
    "    def __init__(self, path=''): raise SystemExit(3)\n    def update(self): return Status.SUCCESS": "BreaksOnce() broke (SystemExit: 3) at",
}


@pytest.mark.parametrize("body", EARLY)
def test_what_breaks_before_the_first_tick_names_node_and_line(body: str, folder: Any, command: Any) -> None:
    name = folder(body)
    code, *printed = command("run", "tree.yaml", "-q")
    code_of, told = (2, printed[1]) if "__init__" in body else (1, printed[0])
    assert code == code_of
    assert told.startswith("tree.yaml:7:16 error[import]: " if code == 2 else "ERROR ")
    told = " ".join(told.split())
    assert f"main/breaks_once: {EARLY[body]} {name}:13" in told
    assert ("0 ticks" in told) == (code == 1)
    assert "Traceback" not in told
    assert "Traceback" in "".join(command("run", "tree.yaml", "-q", "--traceback")[1:])


#: what a node says in `prepare`, how the command ends, and what is said of it
REFUSED = {
    "InvalidInput('too wide; give less')": (2, "main/breaks_once: too wide; give less"),
    "NoAnswer('too wide')": (1, "too wide"),
    "DeviceFault('arm', 'too wide')": (3, "arm: too wide"),
}


@pytest.mark.parametrize("raised", REFUSED)
def test_a_refusal_before_the_first_tick_has_the_end_of_any_run(raised: str, folder: Any, command: Any) -> None:
    folder(f"    def prepare(self): raise {raised}\n    def update(self): return Status.SUCCESS")
    code, said = REFUSED[raised]
    ended, *printed = command("run", "tree.yaml", "-q")
    assert ended == code
    kind = {1: "ERROR ", 2: "error: ", 3: "FAULT "}[code]
    assert printed[code == 2].startswith(kind + said)
    assert json.loads(command("run", "tree.yaml", "-q", "--json")[1])["reason"] == said


def test_a_module_that_breaks_names_its_line_and_one_that_prints_leaves_the_json_alone(
    folder: Any, command: Any
) -> None:
    name = folder("    def update(self): return Status.FAILURE", head="print('hello')\nread('{')")
    code, printed, told = command("check", "tree.yaml", "--json")
    found = json.loads(printed)[0]
    assert code == 2
    assert f"({name}:7 in read)" in found["message"]
    assert "hello" in told


#: mistakes of a motion's author, and a part of the message
MOTIONS = {
    "    def start(self): return {}['x']": "in start",
    "    def start(self): return Still()\n    def watch(self): raise ValueError('w')": "in watch",
    "    def start(self): return Still(1)\n    def arrived(self): raise ValueError('a')": "in arrived",
    "    def start(self): return None": "Moves.start() returned None; return the motion that the device gives",
}
STILL = """
from stretch_bt.behaviors import MotionBehavior
from stretch_bt.hardware.interfaces import MotionState
class Still:
    def __init__(self, done=0): self.done = done
    def poll(self): return MotionState.DONE if self.done else MotionState.MOVING
    def stop(self): pass
@node
class Moves(MotionBehavior):
    '''Moves.'''
"""


@pytest.mark.parametrize("body", MOTIONS)
def test_a_mistake_in_a_motion_is_told_at_its_own_line(body: str, folder: Any, command: Any, tmp_path: Path) -> None:
    name = folder("    def update(self): return Status.FAILURE", head=STILL + body)
    (tmp_path / "tree.yaml").write_text(TREE.format(module=name[:-3]).replace("breaks_once: {y: $y}", "moves: {}"))
    code, printed, _ = command("run", "tree.yaml", "-q", "--json", "--out", "record")
    assert code == 1
    result = json.loads(printed)
    if "None" in body:
        assert MOTIONS[body] in result["reason"]
    else:
        [broken] = result["broken"]
        assert broken["at"].startswith(f"{name}:")
        assert broken["at"].endswith(MOTIONS[body])


#: classes that make no node, and a part of the message
UNMADE = {
    "    def __init__(self, path=''): pass": "begin its __init__ with super().__init__(path)",
    "    def __new__(cls, *a, **k): return None": "BreaksOnce() gave None; its __new__ must return the node",
    "    def __init__(self, path=''): raise ValueError('boom')": "BreaksOnce() broke (ValueError: boom) at",
}


@pytest.mark.parametrize("verb", ["check", "run"])
@pytest.mark.parametrize("body", UNMADE)
def test_a_class_that_makes_no_node_is_told_before_anything_runs(
    body: str, verb: str, folder: Any, command: Any
) -> None:
    folder(f"{body}\n    def update(self): return Status.FAILURE")
    code, printed, told = command(verb, "tree.yaml", "--json")
    assert code in (1, 2)
    assert UNMADE[body] in printed
    assert "Traceback" not in told
