"""One table over every registered node, and what the registry refuses."""

import inspect
import json
import re
import subprocess
import sys
from dataclasses import is_dataclass
from pathlib import Path
from typing import Any, Literal

import pytest

from stretch_bt import check, run
from stretch_bt.behaviors import protocol_records, records
from stretch_bt.hardware.cell_file import load_cell
from stretch_bt.hardware.interfaces import Arm, Gripper
from stretch_bt.hardware.limits import LIMITED
from stretch_bt.tree import registry
from stretch_bt.tree.flow import CONSTRUCTS
from stretch_bt.tree.node_description import describe, fields_of
from stretch_bt.tree.node_info import snake_case
from stretch_bt.tree.ports import Behavior, In, Out, Role, Status, Uses, port
from stretch_bt.tree.registry import RESERVED, RegistryError, load_all, lookup, node
from stretch_bt.tree.shared_signatures import describe_shared, shared_signatures
from stretch_bt.tree.types import Family
from stretch_bt.units import Estimate, Length

NODES = load_all()
KINDS = {"actuation", "perception", "model", "condition", "action"}
INPUT = {"name", "type", "unit", "default", "required", "doc"}


@pytest.fixture
def fresh(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let a test register nodes that no other test sees."""
    monkeypatch.setattr(registry, "_nodes", registry.load_all())


@pytest.mark.parametrize("name", NODES)
def test_a_node_is_named_documented_and_typed(name: str) -> None:
    info = NODES[name]
    assert re.fullmatch(r"[a-z][a-z0-9]*(_[a-z0-9]+)*", name)
    assert name == snake_case(info.cls.__name__)
    assert name not in CONSTRUCTS
    assert info.doc.endswith(".")
    assert info.cls.kind in KINDS
    assert info.cls.update is not Behavior.update
    for declared in info.ports.values():
        type_ = info.types[declared.name]
        assert type_.name
        if declared.role is Role.DEVICE:
            continue
        assert declared.doc, f"{name}.{declared.name} has no doc"
        if type_.is_number and declared.role is Role.INPUT:
            bounds = [b for b in (declared.min, declared.max) if b is not None]
            assert bounds == sorted(bounds)
            if isinstance(declared.default, int | float):
                bounds.append(declared.default)
                assert declared.min in (None, min(bounds))
                assert declared.max in (None, max(bounds))


@pytest.mark.parametrize("name", NODES)
def test_a_node_is_made_without_a_device(name: str) -> None:
    made = NODES[name].cls(f"main/{name}")
    assert (made.path, made.name) == (f"main/{name}", name)
    assert inspect.signature(NODES[name].cls).parameters.keys() == {"path"}


@pytest.mark.parametrize("name", NODES)
def test_a_node_is_described_as_the_contract_says(name: str) -> None:
    info = NODES[name]
    found = describe(info)
    assert json.loads(json.dumps(found)) == found
    assert {"name", "kind", "doc", "module", "inputs", "outputs"} <= set(found)
    assert found["module"] == info.cls.__module__
    for entry in (*found["inputs"], *found["outputs"]):
        assert set(entry) >= INPUT
        assert isinstance(entry["required"], bool)
        assert entry["doc"]
    inputs = {entry["name"]: entry for entry in found["inputs"]}
    assert set(inputs) == {p.name for p in info.of(Role.INPUT)}
    for entry in inputs.values():
        assert entry["required"] == info.ports[entry["name"]].required
        assert not (entry["required"] and entry["default"] is not None)
        assert (entry["unit"] is not None) == (info.types[entry["name"]].family is Family.QUANTITY)


@pytest.mark.parametrize("name", NODES)
def test_every_number_that_a_node_writes_has_its_standard_deviation(name: str) -> None:
    outputs = NODES[name].outputs
    for declared in NODES[name].of(Role.OUTPUT):
        assert declared.name in outputs
        if outputs[declared.name].is_number and not declared.name.endswith("_sd"):
            assert outputs[f"{declared.name}_sd"] == outputs[declared.name]


CONTRACT = """
set_stretch{stretch, speed} approach{speed, contact_height: out} press{depth, speed, max_force} retract{clearance, speed}
roll{radius, speed, depth} capture{frame: out} average_frames{count, frame: out} segment_contact{frame, rule, contact: out}
fit_sphere{contact, sphere: out} track_height{frame, contact, height: out} detect_contact{frame, in_contact: out}
predict_force{radius, stretch, depth, model, force: out} next_indentation{radius, stretch, force, model, depth: out}
choose_stretch{radius, depth, force, model, stretch: out} fuse_contact{contact, cloud: inout} estimate_stiffness{force, deflection, stiffness: out}
"""


@pytest.mark.parametrize(("name", "ports"), re.findall(r"(\w+)\{([^}]*)\}", CONTRACT))
def test_the_promised_ports_are_there(name: str, ports: str) -> None:
    info, tree = lookup(name), shared_signatures().get(name)
    found = describe(info) if info is not None else describe_shared(tree) if tree is not None else {}
    for text in ports.split(", "):
        port_name, _, way = text.partition(": ")
        entries = found[{"": "inputs", "out": "outputs", "inout": "inouts"}[way]]
        assert port_name in [entry["name"] for entry in entries]


RECORDS = {getattr(module, name) for module in (records, protocol_records) for name in module.__all__}


@pytest.mark.parametrize("record", sorted(RECORDS, key=lambda cls: cls.__name__), ids=lambda cls: cls.__name__)
def test_a_record_is_frozen_and_each_field_has_a_doc(record: type) -> None:
    assert is_dataclass(record)
    assert record.__dataclass_params__.frozen  # type: ignore[attr-defined]
    assert record.__doc__
    assert [field["name"] for field in fields_of(record) if not field["doc"]] == []


def test_what_a_record_of_nodes_is_shows_beside_the_node() -> None:
    felt = describe(NODES["fit_deflection"])["records"]["Felt"]
    [deflection] = [field for field in felt if field["name"] == "deflection"]
    assert (deflection["type"], deflection["unit"]) == ("Length", "m")


def behavior(ports: dict[str, Any] | None = None, doc: str | None = "A probe.", **members_: Any) -> type[Behavior]:
    def update(self: Behavior) -> Status:
        return Status.SUCCESS

    members = {
        "__doc__": doc,
        "__module__": __name__,
        "__qualname__": "Probe",
        "__annotations__": ports or {},
        "update": update,
        **members_,
    }
    return type("Probe", (Behavior,), members)


@pytest.mark.parametrize("word", RESERVED)
def test_reserved_words_cannot_be_ports(word: str, fresh: None) -> None:
    with pytest.raises(RegistryError, match=rf"'{word}'; the word is reserved"):
        node(behavior({word: In[Length]}))


TAKEN = sorted(name for name in {*dir(Behavior), *vars(Behavior())} if not name.startswith("_"))


@pytest.mark.parametrize("word", [*TAKEN, "status", "parent", "children", "instant", "_hidden", "größe", "__class__"])
@pytest.mark.parametrize("kind", [In[Length], Out[Length]])
def test_a_port_has_no_name_that_every_node_has(word: str, kind: Any, fresh: None) -> None:
    with pytest.raises(RegistryError, match=rf"Probe: a port cannot be called '{word}'; "):
        node(behavior({word: kind}))


#: annotation, options, what is said of them
WRONG_PORTS = [
    (In[Length], "5 mm", "its default is wrong: it takes a Length .*, not '5 mm'; write 0.005"),
    (In[Length], None, "not None"),
    (In[Length], float("nan"), "not nan"),
    (In[Length], float("inf"), "not inf"),
    (In[Length], port(0.5, max=0.1), "500 mm is above 100 mm"),
    (In[int], 1.5, "an int, not 1.5"),
    (In[Literal["a", "b"]], "c", "one of a, b, not 'c'"),
    (In[Length], port(min=0.2, max=0.1), "its bounds are 0.2 and 0.1"),
    (In[Length], port(min="1 mm"), "its bounds are '1 mm' and None"),  # type: ignore[arg-type]
    (Out[Length], port(max=float("nan")), "its bounds are None and nan"),
    (In[Length], port(limit="dept"), "no cell has a limit 'dept'; did you mean 'depth'?"),
    (In[Literal[1, 2]], True, "one of 1, 2, not True"),
    (In[Literal[1, 2]], 3, "one of 1, 2, not 3"),
    (In[Literal[1, 2]], "1", "one of 1, 2, not '1'"),
]


@pytest.mark.parametrize(("kind", "given", "told"), WRONG_PORTS)
def test_a_default_or_bound_that_does_not_fit_is_refused(kind: Any, given: Any, told: str, fresh: None) -> None:
    with pytest.raises(RegistryError, match=f"node 'probe', port 'size': .*{told}"):
        node(behavior({"size": kind}, size=given))


def test_a_default_has_no_deviation_where_a_port_has_it(fresh: None) -> None:
    with pytest.raises(
        RegistryError, match=r"'size': the deviation of its default would be lost .* write 0.5, and 0.1"
    ):
        node(behavior({"size": In[Length], "size_sd": In[Length]}, size=Estimate(0.5, 0.1), size_sd=0.2))
    node(behavior({"size": In[Length]}, size=Estimate(0.5, 0.1)))


@pytest.mark.parametrize("kind", [Uses[int], Uses[Length | None], Uses[Arm | Gripper]])
def test_a_device_is_one_that_a_cell_can_have(kind: Any, fresh: None) -> None:
    with pytest.raises(RegistryError, match=r"node 'probe', port 'size': it uses no device of a cell; write Uses\[D\]"):
        node(behavior({"size": kind}))


@pytest.mark.parametrize("name", LIMITED)
def test_a_limit_of_a_port_is_one_that_every_cell_knows(name: str, fresh: None) -> None:
    node(behavior({"size": In[Length]}, size=port(limit=name)))
    low, high = load_cell("simulated").span(name)
    assert low < high


def test_options_that_are_numbers_reach_the_node_as_numbers(fresh: None, tmp_path: Path) -> None:
    seen = []

    def update(self: Any) -> Status:
        seen.append((self.side, self.other))
        return Status.SUCCESS

    node(behavior({"side": In[Literal[1, 2]], "other": In[Literal[1, 2]]}, other=2, update=update))
    tree = tmp_path / "tree.yaml"
    tree.write_text("format: stretch-tree/1\ntrees: {main: {sequence: [probe: {side: 1}]}}\n")
    assert run(tree, out=tmp_path / "record").status == "SUCCESS"
    assert seen == [(1, 2)]
    assert check([tree]) == []
    tree.write_text(tree.read_text().replace("side: 1", "side: 3"))
    assert [d.code for d in check([tree])] == ["option-unknown"]


def test_a_node_is_made_from_its_path_alone(fresh: None) -> None:
    def init(self: Behavior, path: str, more: int) -> None: ...

    with pytest.raises(RegistryError, match="node 'probe': its __init__ does not take a path alone"):
        node(behavior(__init__=init))


def test_a_name_is_taken_once(fresh: None) -> None:
    class Press(Behavior):
        """Not the press of the library."""

    with pytest.raises(RegistryError, match=r"'press' of .* is already registered by stretch_bt\.behaviors\.press"):
        node(Press)
    assert lookup("press") is NODES["press"]


def test_a_module_may_be_read_again(fresh: None) -> None:
    first = node(behavior())
    second = node(behavior())
    assert first is not second
    found = lookup("probe")
    assert found is not None
    assert found.cls is second


@pytest.mark.parametrize("doc", [None, "", "  \n "])
def test_a_node_needs_a_docstring(doc: str | None, fresh: None) -> None:
    with pytest.raises(RegistryError, match="has no docstring"):
        node(behavior(doc=doc))


def test_a_port_needs_a_type_of_the_language(fresh: None) -> None:
    with pytest.raises(RegistryError, match="port 'size'"):
        node(behavior({"size": In[Length | str]}))


def test_an_output_has_no_default() -> None:
    with pytest.raises(TypeError, match="only an input port can have a default"):

        class Probe(Behavior):
            """A probe."""

            size: Out[Length] = 0.0


def test_types_and_options_of_ports_are_read_from_the_class(fresh: None) -> None:
    class HTTPProbe2D(Behavior):
        """A probe."""

        size: In[Length] = port(0.01, min=0.001, max=0.1, doc="how large")
        way: In[Literal["up", "down"]] = "up"  # where to
        sizes: In[list[Length]]
        found: Out[Length]

    node(HTTPProbe2D)
    info = lookup("http_probe2_d") or lookup("http_probe2d")
    assert info is not None
    assert info.types["way"].options == ("up", "down")
    assert info.types["sizes"].name == "list[Length]"
    assert [p.name for p in info.ports.values() if p.required] == ["sizes"]
    entry = describe(info)["inputs"][0]
    assert entry == {
        "name": "size", "type": "Length", "unit": "m", "default": 0.01, "required": False, "doc": "how large",
        "min": 0.001, "max": 0.1,
    }  # fmt: skip
    assert list(info.outputs) == ["found", "found_sd"]


def test_what_is_no_node_class_is_refused_with_what_to_write(fresh: None) -> None:
    def probe() -> None: ...

    wrongs: list[Any] = [probe, int, 5]
    for wrong in wrongs:
        with pytest.raises(
            RegistryError, match=r"@node stands above '(probe|int)', .* write class (probe|int)\(Behavior\)"
        ):
            node(wrong)
    with pytest.raises(RegistryError, match="@node has parentheses; write '@node' alone"):
        node()


@pytest.mark.parametrize(("method", "instead"), [("tick", "update"), ("stop", "terminate")])
def test_what_the_framework_calls_is_not_overridden(method: str, instead: str, fresh: None) -> None:
    cls = type("Probe", (Behavior,), {"__doc__": "A probe.", method: lambda self, *status: None})
    with pytest.raises(RegistryError, match=rf"node 'probe': {method}\(\) belongs to the framework.* write {instead}"):
        node(cls)


@pytest.mark.parametrize("method", ["update", "initialise", "terminate", "prepare"])
def test_code_that_would_not_run_when_called_is_refused(method: str, fresh: None) -> None:
    async def waits(self: Behavior) -> None: ...

    def yields(self: Behavior) -> Any:
        yield

    for wrong, told in ((waits, "async"), (yields, "a generator")):
        members: dict[str, Any] = {method: wrong}
        with pytest.raises(RegistryError, match=rf"node 'probe': {method}\(\) is {told}, .* plain 'def {method}'"):
            node(behavior(**members))


@pytest.mark.parametrize(
    "name", [name for name, info in NODES.items() if info.cls.__module__.startswith("stretch_bt.")]
)
def test_a_shipped_node_stands_in_a_file_of_its_name(name: str) -> None:
    assert NODES[name].cls.__module__ == f"stretch_bt.behaviors.{name}"


ALONE = """
import sys
from stretch_bt import Behavior, node
from stretch_bt.errors import StretchError
from stretch_bt.tree.registry import lookup

lookup("wait")
print(sorted(name for name in sys.modules if name.startswith("stretch_bt.behaviors.") and "._" not in name))
print([name for name in ("scipy", "cv2", "numba") if name in sys.modules])
class Press(Behavior):
    "Press otherwise."
try:
    node(Press)
except StretchError as error:
    print(error)
print(lookup("nothing_of_this_name"), lookup("records"))
"""


def test_a_node_is_found_by_its_name_without_importing_the_others() -> None:
    found = subprocess.run([sys.executable, "-c", ALONE], capture_output=True, text=True, check=True)
    assert found.stdout.splitlines() == [
        "['stretch_bt.behaviors.wait']",
        "[]",
        "node 'press' of __main__ is already registered by stretch_bt.behaviors.press",
        "None None",
    ]


def test_the_name_of_a_record_is_no_other_value_s():
    """A record that is left out is wired to its own name, where it would meet a value of another type."""
    described = [describe(each) for each in NODES.values()]
    kept = {name for each in described for name in each["records"]}
    types: dict[str, set[str]] = {}
    for each in described:
        for found in each["inputs"] + each["outputs"]:
            types.setdefault(found["name"], set()).add(found["type"])
    assert not {name: has for name, has in types.items() if has & kept and len(has) > 1}
