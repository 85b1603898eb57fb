"""A driver of one's own is found, checked, listed and examined as a shipped one is, and its code runs by the rule for trees."""

import json
import re
import sys
from importlib.metadata import EntryPoint

import jsonschema
import pytest

from stretch_bt.errors import CellError, DeviceFault, StaleReading
from stretch_bt.hardware import implementations
from stretch_bt.hardware.cell import open_cell
from stretch_bt.hardware.cell_file import cell_schema, load_cell
from stretch_bt.hardware.examine import doctor, status
from stretch_bt.hardware.implementations import Implementations
from stretch_bt.runtime.check import check
from stretch_bt.runtime.replay import replay
from stretch_bt.runtime.task import run
from stretch_bt.source import load

DRIVER = '''
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np

from stretch_bt.devices import DepthCameraDriver, DepthFrame, Intrinsics, Reading, Within
from stretch_bt.units import Frequency


class WallCamera(DepthCameraDriver):
    """Sees a wall."""

    @dataclass(frozen=True)
    class Options:
        rate: Annotated[Frequency, Within(1, 100, "Frequency")] = 30.0  # of pictures
        shape: tuple[int, int] = (48, 64)
        dark: Path | None = None

        def mistakes(self, root):
            if self.dark is not None and not (root / self.dark).is_file():
                yield "dark", "there is no such picture", "take one"

    intrinsics = Intrinsics(60, 60, 32, 24, 64, 48)

    def frame(self):
        number = int(self.now() * self.options.rate)
        time = number / self.options.rate
        picture = np.full(self.options.shape, 2000, np.uint16)
        return Reading(DepthFrame(picture, 1e-4, self.intrinsics, time, number), time, time, number)
'''
CELL = "format: stretch-cell/1\nimports: {{own: {module}}}\ndevices:\n  camera: {{type: DepthCamera, use: wall_camera, {options}}}\n"


@pytest.fixture
def own(tmp_path, request):
    """Write a driver and a cell file beside it, and return the path of that."""
    module = f"own_{abs(hash(request.node.name)) % 10**9}"

    def write(options="rate: 20 Hz", text=DRIVER, cell=CELL):
        (tmp_path / f"{module}.py").write_text(text)
        path = tmp_path / "cell.yaml"
        path.write_text(cell.format(module=module, options=options))
        return path

    yield write
    sys.modules.pop(module, None)


@pytest.fixture
def installed(monkeypatch, tmp_path):
    """Let a package have entry points, by name and value."""

    def install(text=DRIVER, **entries):
        (tmp_path / "walls.py").write_text(text)
        monkeypatch.syspath_prepend(str(tmp_path))
        found = tuple(EntryPoint(name, value, implementations.GROUP) for name, value in entries.items())
        monkeypatch.setattr(implementations, "_entries", lambda: found)

    yield install
    implementations._loaded.cache_clear()
    sys.modules.pop("walls", None)


def packaged(tmp_path, use="wall", kind="DepthCamera"):
    path = tmp_path / "cell.yaml"
    path.write_text(f"format: stretch-cell/1\ndevices: {{camera: {{type: {kind}, use: {use}}}}}\n")
    return path


def found(path):
    return [(d.code, d.message, d.hint) for d in check(path)]


def test_a_module_beside_the_cell_file_is_used_like_a_shipped_driver(own):
    path = own()
    assert check(path) == []
    spec = load_cell(path)
    assert spec.devices["camera"].options.given().rate == 20.0
    assert [f.ok for f in status(spec)] == [True]
    assert all(f.ok for f in doctor(spec))


@pytest.mark.parametrize(
    ("options", "code", "said"),
    [
        ("rate: 500 Hz", "value", "500 Hz is out of bounds; write at least 1 Hz and at most 100 Hz"),
        ("rate: 20", "value", "20 Hz"),
        ("rat: 20 Hz", "key-unknown", "rate"),
        ("dark: none.png", "device-file", "take one"),
    ],
)
def test_its_options_are_checked_at_their_place(own, options, code, said):
    [(was, message, hint)] = found(own(options))
    assert was == code
    assert said in f"{message}; {hint}"


def test_a_path_and_a_tuple_are_written_as_yaml_has_them(own, tmp_path):
    (tmp_path / "dark.png").write_text("")
    given = load_cell(own("dark: dark.png, shape: [4, 6]")).devices["camera"].options.given()
    assert given.shape == (4, 6)
    assert given.dark.name == "dark.png"


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("use: wall_camera", "use: wall_camara", "did you mean 'wall_camera'"),
        ("type: DepthCamera", "type: Arm", "'wall_camera' is a DepthCamera"),
        ("own: {module}", "own: nowhere_at_all", "none is beside the cell file"),
        ("own: {module}", "own: json", "has no driver"),
    ],
)
def test_a_wrong_name_is_told_with_what_to_write(own, old, new, said):
    assert any(said in f"{message}; {hint}" for _, message, hint in found(own(cell=CELL.replace(old, new))))


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("    def frame", "    def frames", "lacks frame"),
        ('    """Sees a wall."""', "", "has no docstring"),
        ("@dataclass(frozen=True)", "", "is no dataclass; write @dataclass(frozen=True) above it"),
        ("shape: tuple", "type: tuple", "cannot be called 'type'"),
        ('"Frequency")] = 30.0', '"Frequency")] = 300.0', "the default of option 'rate' of WallCamera: 300 Hz is out"),
        (
            '"Frequency")] = 30.0',
            '"Frequency")] = "30 Hz"',
            "option 'rate' of WallCamera is text; write a number in Hz",
        ),
        ("Within(1, 100,", "Within(100, 1,", "nothing is within 100 and 1"),
        ('100, "Frequency")', '100, "Frequenzy")', "is called 'Frequenzy'; did you mean 'Frequency'?"),
        ("import numpy as np", "import nowhere_at_all", "No module named 'nowhere_at_all'"),
    ],
)
def test_a_broken_driver_is_an_error_of_the_cell_file(own, old, new, said):
    assert any(said in f"{message}; {hint}" for _, message, hint in found(own(text=DRIVER.replace(old, new))))


def test_a_cell_file_that_imports_passes_its_schema_and_others_are_held_to_it(own):
    validator = jsonschema.Draft202012Validator(cell_schema())
    plain = load(own()).plain()
    assert list(validator.iter_errors(plain)) == []
    del plain["imports"]
    assert list(validator.iter_errors(plain)) != []


def test_a_package_is_known_to_every_cell_file(installed, tmp_path):
    installed(wall="walls:WallCamera")
    path = packaged(tmp_path)
    assert check(path) == []
    assert "wall" in Implementations().names("DepthCamera")
    assert [f.ok for f in status(load_cell(path))] == [True]
    assert '"const": "wall"' in json.dumps(cell_schema())
    assert "of pictures" in json.dumps(cell_schema())


def test_an_entry_may_name_a_module(installed, tmp_path):
    installed(wall="walls")
    assert check(packaged(tmp_path)) == []


@pytest.mark.parametrize(
    ("text", "entries", "said"),
    [
        ("import nowhere_at_all", {"wall": "walls"}, "No module named 'nowhere_at_all'"),
        ("class Plain: pass", {"wall": "walls:Plain"}, "Plain is no driver"),
        ("", {"wall": "walls"}, "has no driver"),
    ],
)
def test_a_broken_package_spoils_only_the_cells_that_name_it(installed, tmp_path, capsys, text, entries, said):
    installed(text, **entries)
    assert any(said in message for _, message, _ in found(packaged(tmp_path)))
    assert check("simulated") == check("simulated")
    cell_schema()
    assert said in capsys.readouterr().err


UNREADABLE = """\
from typing import Callable

from stretch_bt.devices import DepthCameraDriver, Intrinsics, Options


class Broken(DepthCameraDriver):
    \"\"\"Cannot be written in a cell file.\"\"\"

    class Options{options}

    intrinsics = Intrinsics(60, 60, 32, 24, 64, 48)

    def frame(self):
        raise NotImplementedError
"""


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            "raise RuntimeError('no licence\\nfound')",
            r"RuntimeError: no licence found \(.*broken_walls\.py:1 in <module>\)",
        ),
        ("raise SystemExit(3)", r"SystemExit: 3 \(.*broken_walls\.py:1 in <module>\)"),
        (UNREADABLE.format(options=":\n        rate: int = 1"), "Options is no dataclass"),
        (UNREADABLE.format(options="(Options):\n        act: Callable[[int], int]"), "have no schema: .*plain type"),
    ],
    ids=["raises", "exits", "no dataclass", "no schema"],
)
def test_a_broken_package_is_one_warning_and_the_schema_has_the_others(installed, tmp_path, capsys, text, said):
    (tmp_path / "broken_walls.py").write_text(text)
    installed(aaa="broken_walls", broken="broken_walls", wall="walls:WallCamera")
    schema = json.dumps(cell_schema())
    [warning] = capsys.readouterr().err.splitlines()
    assert re.search(rf"^warning: .*'aaa' of the package broken_walls.*{said}", warning)
    assert '"const": "wall"' in schema
    assert '"const": "aaa"' not in schema
    sys.modules.pop("broken_walls", None)


@pytest.mark.parametrize(("use", "hint"), [("wal", "did you mean 'wall'?"), ("simulatd", "did you mean 'simulated'?")])
def test_a_misspelt_name_imports_no_package(installed, tmp_path, use, hint):
    installed("open(__file__ + '.ran', 'w').close()\n" + DRIVER, wall="walls:WallCamera", walls="walls")
    [(code, _, told)] = found(packaged(tmp_path, use=use))
    assert (code, told) == ("device-use", hint)
    assert not (tmp_path / "walls.py.ran").exists()


def test_only_the_package_that_is_named_is_imported(installed, tmp_path):
    (tmp_path / "other_walls.py").write_text("open(__file__ + '.ran', 'w').close()\n")
    installed(wall="walls:WallCamera", other="other_walls")
    assert check(packaged(tmp_path)) == []
    assert not (tmp_path / "other_walls.py.ran").exists()


BASES = {
    "one that another derives from": "class Wall(DepthCameraDriver):",
    "one that says so": "class Wall(DepthCameraDriver, ABC):",
}


@pytest.mark.parametrize("how", BASES)
def test_an_abstract_base_in_a_module_is_no_driver(own, how):
    text = DRIVER.replace(
        "\n\nclass WallCamera", f"\nfrom abc import ABC\n\n{BASES[how]}\n    pass\n\n\nclass WallCamera"
    )
    if "derives" in how:
        text = text.replace("class WallCamera(DepthCameraDriver)", "class WallCamera(Wall)")
    assert check(own(text=text)) == []


@pytest.mark.parametrize("kind", ["DepthCamera", "Arm"])
def test_an_own_driver_with_a_shipped_name_is_refused(own, kind):
    text = DRIVER.replace('    """Sees a wall."""\n', '    """Sees a wall."""\n\n    use = "replay"\n')
    path = own("rate: 20 Hz", text, CELL.replace("use: wall_camera", "use: replay").replace("DepthCamera", kind))
    messages = [f"{message}; {hint}" for _, message, hint in found(path)]
    if kind == "DepthCamera":
        assert re.fullmatch(
            r"WallCamera of own_\d+ has the name of a shipped DepthCamera, 'replay'; set another name, as in use = 'my_replay' in the class",
            messages[0],
        )
    else:  # of another kind the name is free, and this is the shipped arm
        assert not any("WallCamera" in message for message in messages)


def test_a_shipped_name_stays_the_shipped_driver(installed, tmp_path):
    installed(replay="walls:WallCamera")
    assert load_cell("simulated").devices["camera"].implementation.shipped
    assert [i.cls.__name__ for i in Implementations().all() if i.use == "replay" and i.kind == "DepthCamera"] == [
        "ReplayCamera"
    ]


def test_what_a_driver_raises_is_a_fault_that_stays(own):
    spec = load_cell(own(text=DRIVER.replace("        number = int(", "        number = {}['no'] or int(")))
    cell = open_cell(spec, now=lambda: 1.0)
    with pytest.raises(
        DeviceFault, match=r"its driver broke \(KeyError: 'no'\) at .*own_\d+\.py:\d+ in frame; mend it"
    ):
        cell.devices["camera"].frame(1.0)
    assert cell.devices["camera"].fault is not None
    assert [f.ok for f in status(spec)] == [False]


def test_a_value_that_is_no_reading_is_told(own):
    spec = load_cell(own(text=DRIVER.replace("return Reading(DepthFrame", "return (DepthFrame")))
    with pytest.raises(DeviceFault, match="returns a Reading, not a tuple"):
        open_cell(spec, now=lambda: 1.0).devices["camera"].frame(1.0)


def test_a_time_that_is_none_is_told(own):
    """It passed for fresh: NaN is older than nothing."""
    spec = load_cell(own(text=DRIVER.replace("number), time, time, number)", "number), time, float('nan'), number)")))
    with pytest.raises(DeviceFault, match="a driver's reading has the time nan"):
        open_cell(spec, now=lambda: 1.0).devices["camera"].frame(1.0)


def test_ages_are_held_around_it(own):
    camera = open_cell(
        load_cell(own(text=DRIVER.replace("time = number", "time = 0.2 * number"))), now=lambda: 10.0
    ).devices["camera"]
    with pytest.raises(StaleReading):
        camera.frame(0.5)


def test_a_record_names_its_modules_and_is_replayed_without_them(own, tmp_path):
    path = own()
    (tmp_path / "look.yaml").write_text(
        "format: stretch-tree/1\ndevices: {camera: DepthCamera}\ntrees: {main: {sequence: [capture: {frame}]}}\n"
    )
    assert run(tmp_path / "look.yaml", cell=path, out=tmp_path / "record").status == "SUCCESS"
    [(name, about)] = json.loads((tmp_path / "record" / "run.json").read_text())["driver_modules"].items()
    assert about["sha256"]
    del sys.modules[name]
    (tmp_path / f"{name}.py").write_text("raise RuntimeError('it was executed')")
    assert replay(tmp_path / "record").same
    assert name not in sys.modules


def test_nothing_in_the_current_folder_is_executed(own, tmp_path, monkeypatch):
    path = own()
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / "stray.py").write_text("open(__file__ + '.ran', 'w').close()")
    monkeypatch.chdir(tmp_path / "elsewhere")
    path.write_text(
        path.read_text().replace("own: ", "stray: stray, own: ").replace("{stray: stray, own: ", "{stray: stray, own: ")
    )
    with pytest.raises(CellError, match="in the current folder does not count"):
        load_cell(path)
    assert not (tmp_path / "elsewhere" / "stray.py.ran").exists()


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            "def mistakes(self, root):\n",
            "def mistakes(self, root):\n            1 / 0\n",
            "the options of 'wall_camera' broke: ZeroDiv",
        ),
        ('yield "dark", "there is no such picture", "take one"', "yield 1, 2", "the options of 'wall_camera' broke: "),
    ],
)
def test_options_that_break_are_told_at_their_device(own, old, new, said):
    found = check(own("rate: 20 Hz, dark: nothing.png", DRIVER.replace(old, new)))
    assert [d.code for d in found] == ["device-use"]
    assert said in found[0].message
    assert found[0].line == 4


BROKEN = {
    "init": "    def __init__(self, name, options, cell):\n        raise ValueError('no such port')\n",
    "findings": "    def findings(self):\n        raise ValueError('no such port')\n        yield\n",
}


@pytest.mark.parametrize("how", BROKEN)
def test_a_driver_that_breaks_before_it_opens_is_a_finding(own, how):
    text = DRIVER.replace("    intrinsics = Intrinsics", f"{BROKEN[how]}\n    intrinsics = Intrinsics")
    spec = load_cell(own(text=text))
    found = [finding for finding in doctor(spec) if not finding.ok]
    assert "broke" in found[0].detail
    assert "no such port" in found[0].detail
    if how == "init":
        with pytest.raises(DeviceFault, match="its driver broke as it was made"):
            open_cell(spec)
