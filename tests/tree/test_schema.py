"""The schemas accept what the language accepts, flag what an editor can flag, and grow with the registry."""

import json
import re
from pathlib import Path

import jsonschema
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.errors import InvalidInput, MocksError, TreeError
from stretch_bt.runtime import mocks_file
from stretch_bt.source import parse
from stretch_bt.tree.flow import CONSTRUCTS
from stretch_bt.tree.fragments import WORDS
from stretch_bt.tree.program import load_program, shipped_trees
from stretch_bt.tree.registry import load_all
from stretch_bt.tree.schema import schema
from stretch_bt.tree.shared import SHARED, shipped
from stretch_bt.units import KINDS, unit_names

KINDS_OF_FILE = ("tree", "mocks", "scene", "cell")
TREE = jsonschema.Draft7Validator(schema("tree"))
MOCKS = jsonschema.Draft7Validator(schema("mocks"))

DESIGN = """
format: stretch-tree/1
doc: Stiffness of a fixed, soft, roughly spherical object.
devices: {arm: Arm, gripper: Gripper, camera: DepthCamera}
scene: water_balloon                      # the scene that `run` simulates when no scene or cell is named
params:
  sensing_depth: {type: Length, default: 10 mm, min: 2 mm, max: 15 mm, doc: press that feels the shape}
  drop:          {type: Length, default: 1.5 mm, min: 0.1 mm, doc: height lost that counts as deformed}
  stretch_step:  {type: Length, default: 10 mm, min: 1 mm, max: 40 mm}
  depth_step:    {type: Length, default: 1 mm, min: 0.2 mm, max: 5 mm}
  max_force:     {type: Force, default: 5 N}
keys: {contact: Contact, sphere: Sphere, stretch: Length, depth: Length, height: Length, h0: Length, force: Force}
trees:
  main:
    out: {stiffness: Stiffness, force: Force, deflection: Length, radius: Length}
    guard: {that: "arm.force < max_force", name: force_limit}       # held on every tick
    sequence:
      - set_stretch: {stretch: 0 mm}
      - approach: {contact_height: $h0}
      - press: {depth: $sensing_depth}
      - feel: {contact: $contact, height: $height}
      - fit_sphere: {contact: $contact, sphere: $sphere}
      - until:
          that: "h0 - height >= drop"
          max: 120                                                          # no loop without a bound
          do:
            selector:
              - press_deeper: {depth: $depth, height: $height}              # FAILURE at the depth limit
              - stretch_further: {stretch: $stretch, force: $force, depth: $depth}
      - predict_force: {radius: "$sphere.radius", stretch: $stretch, depth: "$depth - ($h0 - $height)", force: $force}
      - estimate_stiffness: {force: $force, deflection: "$h0 - $height", stiffness: $stiffness}
    finally:
      - retract: {clearance: 20 mm}
"""

#: every construct and reserved word once, in each of its forms
EVERYTHING = """
format: stretch-tree/1
tick: 20 ms
devices: {arm: Arm, camera: DepthCamera}
params:
  step: {type: Length, default: 1 mm, min: 0.1 mm, max: 5 mm, unit: mm, doc: of each press}
  steps: {type: "list[Length]", default: [1 mm, 2 mm], min: 0 mm}
  often: {type: int, default: 3, min: 1}
  part: {type: float, default: 5 %}
  look: {type: bool, default: true}
keys:
  depth: {type: Length, default: 0 mm}
  count: {type: int, default: 0}
  frame: DepthFrame
  contact: Contact
trees:
  main:
    doc: All of it.
    out: {top: Length}
    guard: [arm.force < 5 N, {that: count < 100, name: enough}]
    sequence:
      - approach
      - {timeout: 8 s, retry: 2, press: {depth: $step, speed: 5 mm/s}, name: first, doc: the first press}
      - {set: {count: count + 1, depth: 2 mm}, skip_if: not look, log: counted}
      - capture: {frame: $frame, camera: camera}
      - segment_contact: {frame: $frame, rule: either, contact: $contact}
      - for_each: {items: $steps, as: $depth, do: {press: {depth: $depth}}}
      - until: {that: count >= 3, max: $often, do: [{set: {count: count + 1}}, wait: {duration: 10 ms}]}
      - repeat: {times: 2, do: {guard: count < 50, wait: {duration: 1 s}}}
      - retry: {attempts: 3, do: {check: count > 0}}
      - timeout: {after: 2 s, do: {guard: {that: count > 0, do: {wait: {duration: 100 ms}}}}}
      - reactive_sequence: [{check: {that: arm.force < 5 N, name: soft}}, {wait: {duration: 10 ms}}]
      - reactive_selector: [{check: count > 100}, {wait: {duration: 10 ms}}]
      - parallel: [{wait: {duration: 1 ms}}, {name: longer, wait: {duration: 2 ms}}]
      - parallel: {policy: success_on_selected, selected: [a], children: [{name: a, wait: {duration: 1 ms}}, {check: count > 0}]}
      - selector: [{invert: {check: count > 5}}, {force_failure: [{check: count > 0}]}, {force_success: {fail: never mind}}]
      - run: {tree: look, with: {from: $depth, top: $top}}
      - {run: look, with: {from: $depth, top: $top}}
      - timeout: 5 s
        look: {from: 1 mm, top: $top}
    finally: {retract: {clearance: 20 mm}}
  look:
    in: {from: Length, limit: {type: int, default: 24}}
    out: {top: Length}
    sequence:
      - set: {top: from}
      - force_success: {selector: [{check: limit > 30}, {fail: too few}]}
"""

#: what is written -> what stands there instead, each a mistake that an editor should underline
MISTAKES = {
    "unknown port": ("press: {depth: $depth}", "press: {dept: $depth}"),
    "missing input": ("press: {depth: $depth}", "press: {speed: 5 mm/s}"),
    "missing input, bare": ("- approach\n", "- press\n"),
    "wrong enum value": ("rule: either", "rule: eiter"),
    "bare number in a port": ("wait: {duration: 1 s}}}", "wait: {duration: 1}}}"),
    "quoted number without unit": ("speed: 5 mm/s", "speed: '5'"),
    "wrong unit": ("clearance: 20 mm", "clearance: 20 N"),
    "wrong unit of a default": ("default: 1 mm, min", "default: 1 N, min"),
    "bare number as a bound": ("max: 5 mm, unit", "max: 5, unit"),
    "bare number in a list": ("default: [1 mm, 2 mm]", "default: [1 mm, 2]"),
    "default of another type": ("default: true", "default: 3"),
    "fraction for a whole number": ("default: 3, min", "default: 3.5, min"),
    "literal for an output": ("frame: $frame, camera", "frame: frame, camera"),
    "misspelt top-level key": ("params:\n", "parms:\n"),
    "format of another file": ("stretch-tree/1", "stretch-scene/1"),
    "no trees": ("trees:\n", "tree:\n"),
    "unknown device": ("arm: Arm", "arm: Arms"),
    "unknown type": ("{type: float,", "{type: flaot,"),
    "unknown field of a parameter": ("min: 0.1 mm", "minimum: 0.1 mm"),
    "until without max": ("until: {that: count >= 3, max: $often,", "until: {that: count >= 3,"),
    "until without that": ("until: {that: count >= 3,", "until: {"),
    "repeat without times": ("repeat: {times: 2,", "repeat: {"),
    "retry of no attempts": ("attempts: 3", "attempts: 0"),
    "timeout without unit": ("timeout: 8 s", "timeout: 8"),
    "misspelt word beside": ("log: counted", "lgo: counted"),
    "word inside": ("rule: either,", "rule: either, retry: 2,"),
    "misspelt policy": ("success_on_selected, sel", "sucess_on_selected, sel"),
    "unknown field of parallel": ("selected: [a],", "select: [a],"),
    "sequence of a mapping": (
        "- selector: [{invert: {check: count > 5}}, ",
        "- selector: {invert: {check: count > 5}}\n      - selector: [",
    ),
    "empty group": ("selector: [{check: limit > 30}, {fail: too few}]", "selector: []"),
    "name of two words": ("name: longer", "name: much longer"),
    "two nodes at a place": ("- capture: {frame", "- wait: {duration: 1 s}\n        capture: {frame"),
    "for_each without as": ("as: $depth, ", ""),
    "for_each into no key": ("as: $depth", "as: depth"),
    "finally of a node": ("{set: {count: count + 1, depth", "{finally: [approach], set: {count: count + 1, depth"),
    "tick without unit": ("tick: 20 ms", "tick: 20"),
    "fail without reason": ("{fail: too few}", "{fail: }"),
    "set of nothing": ("set: {top: from}", "set: {}"),
}


def errors(validator: jsonschema.protocols.Validator, text: str) -> list[str]:
    found = validator.iter_errors(parse(text, "a.yaml").plain())  # type: ignore[union-attr]
    return [f"{'/'.join(map(str, e.absolute_path))}: {e.message[:200]}" for e in found]


def findings(text: str, folder: Path) -> list[str]:
    path = folder / "a.yaml"
    path.write_text(text, encoding="utf-8")
    try:
        return [str(d) for d in load_program(path).errors]
    except TreeError as error:  # of a file that is none of a tree at all
        return [str(d) for d in error.diagnostics]


@pytest.mark.parametrize("kind", KINDS_OF_FILE)
def test_each_schema_is_a_schema_and_json(kind: str) -> None:
    found = schema(kind)
    jsonschema.validators.validator_for(found).check_schema(found)
    assert json.loads(json.dumps(found)) == found


def test_an_unknown_kind_names_the_known_ones() -> None:
    with pytest.raises(InvalidInput, match=r"'teapot'; known here: cell, mocks, scene, sweep, tree"):
        schema("teapot")
    with pytest.raises(InvalidInput, match=r"did you mean 'scene'"):
        schema("scenes")


@pytest.mark.parametrize("name", shipped_trees())
def test_shipped_trees_fit(name: str) -> None:
    assert errors(TREE, shipped(f"{name}.yaml").read_text(encoding="utf-8")) == []


def test_a_tree_of_the_manual_fits() -> None:
    assert errors(TREE, DESIGN) == []


def test_every_form_of_every_construct_fits_and_is_a_task(tmp_path: Path) -> None:
    used = set(re.findall(r"\b\w+(?=:)", EVERYTHING))
    assert set(CONSTRUCTS) | set(WORDS) <= used
    assert findings(EVERYTHING, tmp_path) == []
    assert errors(TREE, EVERYTHING) == []


#: a whole tree -> whether it is one
BODIES = {
    "[wait: {duration: 1 s}, check: 1 > 0]": True,
    "[[wait: {duration: 1 s}]]": True,
    "other": True,
    "{sequence: [other]}": True,
    "[]": False,
    "[wait: {duration: 1}]": False,
    "[press]": False,
    "press": False,
    "sequence": False,
    "5": False,
    "": False,
}


@pytest.mark.parametrize("body", BODIES)
def test_a_tree_is_whatever_stands_where_a_body_stands(body: str, tmp_path: Path) -> None:
    other = "  other: {check: 1 > 0}\n" if "other" in body else ""
    text = f"format: stretch-tree/1\ntrees:\n  main: {body}\n{other}"
    found = errors(TREE, text), findings(text, tmp_path)
    assert [not problems for problems in found] == [BODIES[body]] * 2, found


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistakes_are_flagged_and_are_mistakes(mistake: str, tmp_path: Path) -> None:
    before, after = MISTAKES[mistake]
    assert EVERYTHING.count(before) == 1
    text = EVERYTHING.replace(before, after)
    assert errors(TREE, text)
    assert findings(text, tmp_path), "the schema is stricter than the language"


def test_calls_of_trees_and_nodes_of_other_modules_are_allowed() -> None:
    text = DESIGN.replace("- feel:", "- elsewhere.feel:").replace("contact: Contact,", "contact: ClassOfAnotherModule,")
    assert errors(TREE, text) == []


def test_every_node_port_and_construct_is_described() -> None:
    definitions = schema("tree")["$defs"]
    for name, info in load_all().items():
        node = definitions[f"node_{name}"]
        assert node["description"] == info.doc
        assert set(node["properties"]) == {*info.ports, *info.outputs}
        for port in {*info.ports, *info.outputs}:
            assert len(node["properties"][port]["description"]) > 3
        assert definitions["node"]["properties"][name] == {"$ref": f"#/$defs/node_{name}"}
    for name, part in CONSTRUCTS.items():
        assert part.schema(), f"{name} has no schema"
        assert definitions[f"construct_{name}"]["description"]
        assert name in definitions["node"]["properties"]
    assert set(definitions["node"]["properties"]) == {*load_all(), *SHARED, *CONSTRUCTS, *WORDS, "run", "with"}
    for name in SHARED:
        assert definitions[f"node_{name}"]["description"]


def test_no_reference_leads_nowhere() -> None:
    for kind in ("tree", "mocks"):
        found = schema(kind)
        used = set(re.findall(r'"#/\$defs/(\w+)"', json.dumps(found)))
        assert used <= set(found["$defs"])


@given(
    kind=st.sampled_from(sorted(KINDS)),
    number=st.one_of(st.integers(-(10**6), 10**6), st.floats(-1e9, 1e9)),
    space=st.sampled_from(["", " "]),
    data=st.data(),
)
def test_every_unit_of_a_kind_fits_and_a_bare_number_does_not(
    kind: str, number: float, space: str, data: st.DataObject
) -> None:
    dimension = KINDS[kind].dimension
    unit = data.draw(st.sampled_from([*unit_names(dimension), KINDS[kind].unit, KINDS[kind].si_unit]))
    definition = TREE.evolve(schema={"$ref": f"#/$defs/input_{kind}", "$defs": TREE.schema["$defs"]})
    assert definition.is_valid(f"{number}{space}{unit}")
    assert not definition.is_valid(number)
    assert not definition.is_valid(f"{number}")
    other = next(k for k in KINDS.values() if k.dimension != dimension and unit_names(k.dimension) != [k.unit])
    assert not definition.is_valid(f"{number} {unit_names(other.dimension)[0]}")


@pytest.mark.parametrize("text", ["$depth", "$step * 2", "arm.force / 2", "max(a, b)", "h0 - height", "2 * step"])
def test_expressions_fit_every_number(text: str) -> None:
    for name in (*KINDS,):
        assert TREE.evolve(schema={"$ref": f"#/$defs/input_{name}", "$defs": TREE.schema["$defs"]}).is_valid(text)


def test_editors_are_offered_units_and_options() -> None:
    definitions = schema("tree")["$defs"]
    offered = [s["label"] for s in definitions["literal_Length"]["defaultSnippets"]]
    assert offered[0] == "10 mm"
    assert {f"10 {unit}" for unit in unit_names(KINDS["Length"].dimension)} == set(offered)
    assert definitions["node_segment_contact"]["properties"]["rule"]["anyOf"][0] == {"enum": ["mean", "either"]}
    assert definitions["node_press"]["properties"]["speed"]["default"] == "5 mm/s"


MOCKS_FILE = """
format: stretch-mocks/1
doc: Two presses.
tree: palpate_stiffness
mocks:
  - {match: "**/press", status: [success, failure], after: 0.4 s, then: cycle, message: blocked}
  - {match: main/track_height, outputs: {height: [20 mm, {value: 19 mm, sd: 0.1 mm}], other: 3}, then: repeat_last}
  - {match: "**/check", status_when: depth > 2 mm}
readings: {arm.force: [1 N, 2 N], gripper.opening: 60 mm}
expect: {result: success, visited: [main/press], never: ["**/retract#failure"], ticks_max: 400,
  outputs: {stiffness: {value: 1 N/mm, within: 5 %}, presses: 3}, commands: [arm.move]}
"""
MOCK_MISTAKES = {
    "unknown key": ("doc:", "docs:"),
    "no tree": ("tree: palpate_stiffness\n", ""),
    "no pattern": ('match: "**/press", ', ""),
    "unknown status": ("[success, failure]", "[success, failed]"),
    "time without unit": ("after: 0.4 s", "after: 0.4"),
    "unknown then": ("then: cycle", "then: cycles"),
    "unknown reading": ("arm.force", "arm.forces"),
    "reading without unit": ("2 N]", "2]"),
    "unknown result": ("result: success", "result: succes"),
    "unknown expectation": ("ticks_max", "max_ticks"),
    "output within what": ("within: 5 %", "sd: 5 %"),
    "command of no device": ("[arm.move]", "[move]"),
    "ticks as text": ("ticks_max: 400", "ticks_max: many"),
    "status twice": ('"**/check",', '"**/check", status: success,'),
}


def test_mocks_fit(tmp_path: Path) -> None:
    assert errors(MOCKS, MOCKS_FILE) == []
    path = tmp_path / "a.yaml"
    path.write_text(MOCKS_FILE, encoding="utf-8")
    mocks_file.read_mocks(path)


def test_readings_may_be_arrays_of_files() -> None:
    for name in ("force.npy", "data/force.npz#first", "[1 N, force.npy]"):
        assert errors(MOCKS, MOCKS_FILE.replace("[1 N, 2 N]", name)) == []


@pytest.mark.parametrize("mistake", MOCK_MISTAKES)
def test_mistakes_in_mocks_are_flagged_and_are_mistakes(mistake: str, tmp_path: Path) -> None:
    before, after = MOCK_MISTAKES[mistake]
    assert MOCKS_FILE.count(before) == 1
    text = MOCKS_FILE.replace(before, after)
    assert errors(MOCKS, text)
    path = tmp_path / "a.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(MocksError):
        mocks_file.read_mocks(path)


def test_the_schema_of_mocks_says_what_their_reader_says() -> None:
    found = schema("mocks")
    mock = found["$defs"]["mock"]["properties"]
    assert tuple(found["properties"]) == mocks_file.TOP
    assert set(mock) == set(mocks_file.FIELDS)
    assert tuple(mock["then"]["enum"]) == mocks_file.THEN
    assert set(mock["status"]["anyOf"][0]["enum"]) == set(mocks_file.STATUSES)
    assert found["properties"]["format"]["const"] == mocks_file.FORMAT
