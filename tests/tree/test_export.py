"""Every shipped task in every format: well-formed, complete, and with text that cannot break out."""

import itertools
import re
import xml.etree.ElementTree as ET
from html.parser import HTMLParser
from pathlib import Path

import pytest

from stretch_bt.errors import InvalidInput, TreeError
from stretch_bt.runtime.context import RunContext
from stretch_bt.tree.build import build
from stretch_bt.tree.export import FORMATS, export
from stretch_bt.tree.export.layout import GAP_X, arrange
from stretch_bt.tree.export.view import NodeView, views
from stretch_bt.tree.program import Program, load_program, shipped_trees

SVG = "{http://www.w3.org/2000/svg}"

AWKWARD = r"""
format: stretch-tree/1
doc: "Text with <b>, & and \"quotes\", a backslash \\ and a bell \u0007."
imports: {lib: lib.yaml}
params: {often: {type: int, default: 3}, long: {type: Time, default: 1500 ms}}
keys: {a: {type: Length, default: 1 mm}, b: Length, n: {type: int, default: 0}}
trees:
  main:
    sequence:
      - {wait: {duration: 1 s}, timeout: $long, retry: $often, log: "<i>done</i> \"so\" \\", name: first}
      - retry: {attempts: "n + 1", do: {check: {that: "a < 2 mm and n <= 3", name: small}}}
      - repeat: {times: 2, do: {wait: {duration: 10 ms}}}
      - timeout: {after: "2 * task.time + 1 s", do: {wait: {duration: 10 ms}}}
      - parallel: {policy: success_on_one, children: [{wait: {duration: 1 ms}}, {fail: no & never}]}
      - parallel: {policy: success_on_selected, selected: [x], children: [{name: x, wait: {duration: 1 ms}}, {check: n < 3}]}
      - reactive_selector: [{invert: {check: n > 2}}, {wait: {duration: 10 ms}}]
      - lib.double: {a: $a, b: $b}
      - for_each: {items: [1 mm, 2 mm], as: $b, do: {set: {a: b}}}
      - until: {that: n > 1, max: 3, do: {force_success: {set: {n: n + 1}}}}
    finally: {wait: {duration: 1 ms}}
"""
LIBRARY = """
format: stretch-tree/1
trees:
  double:
    doc: Twice as long.
    in: {a: Length}
    out: {b: Length}
    set: {b: 2 * a}
"""
#: a tree with other params, a name for two classes, a device of another name, and a construct with fewer and more fields
TWICE = """
format: stretch-tree/1
imports: {feel: feel.yaml, other: other.yaml, node: py_trees.behaviours.Success}
devices: {arm: Arm, right: Arm}
keys: {n: {type: int, default: 0}}
trees:
  main:
    sequence:
      - feel.touch: {_by: 1 mm}
      - feel.touch: {_by: 1 mm, arm: right}
      - feel.touch: {_by: 1 mm, clear: 30 mm}
      - repeat: {times: 2, collect: {all: $n}, do: {set: {n: n + 1}}}
      - check: {that: n > 1}
      - check: {that: n > 1, else: "$n is too few of $all"}
      - {node: {}, timeout: 0.1 ms}
      - {other.fails: {}, timeout: 0 s}
      - with_finally
  with_finally: {node: {}, finally: {wait: {duration: 1 ms}}}
"""
FEEL = """
format: stretch-tree/1
params: {clear: {type: Length, default: 20 mm}}
trees:
  touch:
    in: {_by: Length}
    sequence: [lower: {by: $_by}, up]
  up: {retract: {clearance: $clear}}
"""
OTHER = """
format: stretch-tree/1
imports: {node: py_trees.behaviours.Failure}
trees: {fails: {node: {}}}
"""


@pytest.fixture(scope="module")
def programs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Program]:
    folder = tmp_path_factory.mktemp("trees")
    for name, text in {"lib": LIBRARY, "awkward": AWKWARD, "twice": TWICE, "feel": FEEL, "other": OTHER}.items():
        (folder / f"{name}.yaml").write_text(text)
    found = {name: load_program(name).require() for name in shipped_trees()}
    for name in ("awkward", "lib", "twice"):
        found[name] = load_program(folder / f"{name}.yaml").require()
    return found


NAMES = [*shipped_trees(), "awkward", "lib", "twice"]
TASKS = [name for name in NAMES if name != "lib"]


@pytest.mark.parametrize("name", TASKS)
def test_paths_are_those_of_the_built_tree(name: str, programs: dict[str, Program]) -> None:
    built = build(programs[name], RunContext())
    (main,) = views(programs[name])
    drawn = {path for view in main.walk() for path in (view.path, *(path for _, path in view.around))}
    assert drawn == {"main", *built.nodes}


def inside(text: str, view: NodeView) -> bool:
    """Whether a drawing names a node: by its whole path."""
    return re.search(rf"(?<![\w/]){re.escape(view.path)}(?![\w/\[])", text) is not None


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("form", ["text", "dot", "svg", "html"])
def test_every_node_is_there_with_its_path(form: str, name: str, programs: dict[str, Program]) -> None:
    text = export(programs[name], form)
    assert text == export(programs[name], form)
    assert "\x07" not in text
    for root in views(programs[name]):
        assert [view.path for view in root.walk() if not inside(text, view)] == []


@pytest.mark.parametrize("name", NAMES)
def test_text_shows_ports_guards_and_finally_as_written(name: str, programs: dict[str, Program]) -> None:
    text = export(programs[name], "text", wires=True)
    flat = re.sub(r"\s+", " ", re.sub(r"[│├└─]|  main\S*", " ", text))
    for root in views(programs[name]):
        for view in root.walk():
            assert view.title in flat
            assert all(value.split()[0] in flat for value in view.settings.values())
            assert all(line in flat for line, _ in view.around)
            if view.finish is not None:
                assert f"finally: {view.finish.title}" in flat
    assert max(len(line) for line in text.splitlines()) < 180


@pytest.mark.parametrize("name", NAMES)
def test_svg_is_well_formed_and_boxes_stand_apart(name: str, programs: dict[str, Program]) -> None:
    root = ET.fromstring(export(programs[name], "svg"))
    assert root.tag == f"{SVG}svg"
    roots, right, bottom = arrange(views(programs[name]), 0.0, 0.0)
    boxes = [box for one in roots for box in one.walk()]
    assert len(root.findall(f".//{SVG}g")) == len(boxes)
    for i, a in enumerate(boxes):
        assert a.x >= 0
        assert a.x + a.width <= right
        assert a.y + a.height <= bottom
        for b in boxes[i + 1 :]:
            apart = a.x + a.width <= b.x or b.x + b.width <= a.x or a.y + a.height <= b.y or b.y + b.height <= a.y
            assert apart, f"{a.view.path} overlaps {b.view.path}"


@pytest.mark.parametrize("name", NAMES)
def test_no_two_families_share_a_line(name: str, programs: dict[str, Program]) -> None:
    roots, _, _ = arrange(views(programs[name]), 0.0, 0.0)
    trunks: dict[float, list[tuple[float, float]]] = {}
    for box in (box for root in roots for box in root.walk() if box.children):
        assert min(child.x for child in box.children) >= box.x + box.width + GAP_X
        assert box.y <= box.children[0].y
        ends = [child.anchor for child in box.children]
        trunks.setdefault(box.children[0].x, []).append((min(box.anchor, *ends), max(box.anchor, *ends)))
    for spans in trunks.values():
        spans.sort()
        assert all(first[1] < second[0] for first, second in itertools.pairwise(spans))


class Page(HTMLParser):
    """Collects the tags of a page, and checks that they close in order."""

    VOID = ("meta", "path", "rect", "br")

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.seen: set[str] = set()
        self.links: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.seen.add(tag)
        self.links += [value or "" for name, value in attrs if name in ("href", "src")]
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.seen.add(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


@pytest.mark.parametrize("name", NAMES)
def test_html_is_one_page_with_what_a_run_takes_and_gives(name: str, programs: dict[str, Program]) -> None:
    program = programs[name]
    text = export(program, "html")
    page = Page(text)
    assert page.open == []
    assert page.links == []
    assert not page.seen & {"i", "script"}
    for param in program.document.params.values():
        assert f"<td>{param.name}</td>" in text
    for leaf in {v.keyword for root in views(program) for v in root.walk() if v.kind in ("actuation", "perception")}:
        assert f"<h3>{leaf}<small" in text


_DOT_LINE = re.compile(
    r'  n\d+ \[label="(?:[^"\\]|\\.)*", tooltip="(?:[^"\\]|\\.)*", fillcolor="#[0-9a-f]{6}"\];'
    r'|  n\d+ -> n\d+(?: \[style=dashed, label="finally", fontsize=10\])?;'
)


@pytest.mark.parametrize("name", NAMES)
def test_dot_has_a_node_for_each_place_and_a_line_to_each_child(name: str, programs: dict[str, Program]) -> None:
    lines = export(programs[name], "dot").splitlines()
    assert lines[0] == f'digraph "{programs[name].document.file}" {{'
    assert lines[-1] == "}"
    assert all(_DOT_LINE.fullmatch(line) for line in lines[4:-1])
    roots = views(programs[name])
    nodes = sum(1 for root in roots for _ in root.walk())
    edges = sum(1 for line in lines if "->" in line)
    assert sum(1 for line in lines if "[label=" in line and "->" not in line) == nodes
    assert edges == nodes - len(roots)


BUILT_IN = {
    "Sequence", "ReactiveSequence", "Fallback", "ReactiveFallback", "Parallel", "Inverter", "ForceSuccess",
    "ForceFailure", "RetryUntilSuccessful", "Repeat", "Timeout",
}  # fmt: skip
CATEGORIES = ("Action", "Condition", "Control", "Decorator", "SubTree")
NAME = re.compile(r"[^\s<>&\"'/\\:*?|.]+")


@pytest.mark.parametrize("name", NAMES)
def test_btcpp_defines_all_that_it_uses(name: str, programs: dict[str, Program]) -> None:
    root = ET.fromstring(export(programs[name], "btcpp"))
    assert root.attrib == {"BTCPP_format": "4"} | ({} if name == "lib" else {"main_tree_to_execute": "main"})
    trees = {tree.get("ID"): tree for tree in root.findall("BehaviorTree")}
    model = {entry.get("ID"): entry for entry in root.findall("TreeNodesModel/*")}
    assert (len(trees), len(model)) == (len(root.findall("BehaviorTree")), len(root.findall("TreeNodesModel/*")))
    assert all(len(tree) == 1 for tree in trees.values())
    for element in (e for tree in trees.values() for e in tree.iter() if e is not tree):
        children = len(element)
        if element.tag in BUILT_IN:
            assert children >= 1
            continue
        entry = model[element.get("ID")]
        assert element.tag == entry.tag
        ports = {port.get("name") for port in entry}
        assert set(element.attrib) - {"ID", "name"} <= ports
        wanted = {"Decorator": children == 1, "Control": children > 1}
        assert wanted.get(element.tag, children == 0)
        assert element.tag != "SubTree" or element.get("ID") in trees
    for entry in model.values():
        assert entry.tag in CATEGORIES
        assert NAME.fullmatch(entry.get("ID", ""))
        assert all(NAME.fullmatch(port.get("name", "")) for port in entry)


def test_btcpp_keeps_wiring_and_finds_counterparts(programs: dict[str, Program]) -> None:
    root = ET.fromstring(export(programs["awkward"], "btcpp"))
    call = next(e for e in root.iter("SubTree") if e.get("ID") == "lib-double" and e.get("a"))
    assert call.attrib == {"ID": "lib-double", "a": "{a}", "b": "{b}"}
    assert [e.get("msec") for e in root.iter("Timeout")] == ["1500"]
    assert [e.get("num_attempts") for e in root.iter("RetryUntilSuccessful")] == ["3"]
    assert [e.get("num_cycles") for e in root.iter("Repeat")] == ["2"]
    assert [e.get("success_count") for e in root.iter("Parallel")] == ["1"]
    custom = {e.get("ID") for e in root.iter() if e.tag in CATEGORIES}
    assert {
        "retry",
        "timeout",
        "parallel",
        "check",
        "for_each",
        "until",
        "set",
        "log",
        "fail",
        "with_finally",
    } <= custom


def test_btcpp_keeps_apart_what_differs_by_params_devices_classes_and_fields(programs: dict[str, Program]) -> None:
    root = ET.fromstring(export(programs["twice"], "btcpp"))
    trees = {tree.get("ID"): list(tree.iter())[1:] for tree in root.findall("BehaviorTree")}

    def found(tree: str, tag: str) -> list[dict[str, str]]:
        return [e.attrib for e in trees[tree] if e.tag == tag]

    assert found("main", "SubTree") == [
        {"ID": "feel-touch", "_by_": "1 mm"},
        {"ID": "feel-touch", "arm": "right", "_by_": "1 mm"},
        {"ID": "feel-touch-2", "_by_": "1 mm"},
        {"ID": "other-fails"},
        {"ID": "with_finally"},
    ]
    assert found("feel-touch", "SubTree") == [{"ID": "feel-up", "arm": "{arm}"}]
    assert found("feel-touch", "Action") == [{"ID": "lower", "arm": "{arm}", "by": "{_by_}"}]
    assert found("feel-up", "Action") == [{"ID": "retract", "arm": "{arm}", "clearance": "20 mm"}]
    assert found("feel-touch-2", "Action") == [{"ID": "lower", "arm": "arm", "by": "{_by_}"}]
    assert found("feel-up-2", "Action") == [{"ID": "retract", "arm": "arm", "clearance": "30 mm"}]
    assert found("other-fails", "Action") != found("main", "Action")[-1:]
    assert found("main", "Decorator") == [
        {"ID": "with_keys", "keys": "{n: {type: int, default: 0}}"},
        {"ID": "repeat", "times": "2", "collect": "{all: $n}"},
    ]
    assert found("main", "Timeout") == [{"msec": "1"}, {"msec": "1"}]
    (port,) = [p for p in root.findall("TreeNodesModel/SubTree[@ID='feel-touch']/*") if p.get("type") == "Arm"]
    assert port.attrib == {"name": "arm", "type": "Arm", "default": "arm"}


def test_a_large_task_is_drawn_whole(tmp_path: Path) -> None:
    body = "\n".join(f"          - {{name: step{i}, wait: {{duration: {i} s}}}}" for i in range(60))
    text = f"format: stretch-tree/1\ntrees:\n  main:\n    sequence:\n      - selector:\n{body}\n"
    text += "".join(f"      - selector: [{{check: task.ticks > {i}}}, {{fail: no}}]\n" for i in range(20))
    path = tmp_path / "large.yaml"
    path.write_text(text)
    program = load_program(path)
    (root,) = views(program)
    assert sum(1 for _ in root.walk()) > 120
    for form in FORMATS:
        assert "step59" in export(program, form)


@pytest.mark.parametrize("form", ["text", "dot", "svg", "html", "btcpp"])
@pytest.mark.parametrize("loop", ["repeat: {times: 2", "until: {that: k > 2, max: 3"])
def test_the_keys_of_a_loop_are_shown(form: str, loop: str, tmp_path: Path) -> None:
    body = f"{loop}, keys: {{k: {{default: 1, max: 9}}}}, do: {{set: {{k: k + 1}}}}}}"
    (tmp_path / "loop.yaml").write_text(f"format: stretch-tree/1\ntrees: {{main: {{{body}}}}}\n")
    assert "{k: {default: 1, max: 9}}" in export(load_program(tmp_path / "loop.yaml"), form)


@pytest.mark.parametrize("form", ["text", "dot", "svg", "html", "btcpp"])
def test_the_keys_of_a_tree_are_shown_where_it_begins(form: str, tmp_path: Path) -> None:
    called = "called: {keys: {k: {default: 2}}, set: {k: k + 1}}"
    (tmp_path / "keys.yaml").write_text(
        "format: stretch-tree/1\nkeys: {k: {default: 1, max: 9}, l: }\n"
        f"trees: {{main: {{sequence: [set: {{k: k + 1, l: 3}}, called]}}, {called}}}\n"
    )
    text = export(load_program(tmp_path / "keys.yaml").require(), form)
    assert text.count("{k: {default: 1, max: 9}, l}") == text.count("{k: {default: 2}}") > 0


def test_an_unknown_format_and_a_wrong_task_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="did you mean 'svg'"):
        export(load_program(shipped_trees()[0]), "svgz")
    path = tmp_path / "wrong.yaml"
    path.write_text("format: stretch-tree/1\ntrees:\n  main: {sequence: [main]}\n")
    for form in FORMATS:
        with pytest.raises(TreeError, match="calls itself"):
            export(load_program(path), form)
