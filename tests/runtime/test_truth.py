"""An output is held against what the scene knew when a node found it, as the node's port declares."""

import dataclasses
import re
from importlib.resources import files

import pytest

from stretch_bt.runtime.task import run
from stretch_bt.runtime.truth import Truths
from stretch_bt.simulation.scene import load_scene
from stretch_bt.tree import registry
from stretch_bt.tree.ports import Behavior, In, Out, PortError, Status, port
from stretch_bt.units import Curvature, Force, Length

SCENES = sorted(p.name.removesuffix(".yaml") for p in (files("stretch_bt") / "trees" / "scenes").iterdir())


@dataclasses.dataclass(frozen=True)
class Ball:
    radius: float


@dataclasses.dataclass(frozen=True)
class Round:
    bend: Curvature


class Looks(Behavior):
    """Finds the number that it is given."""

    value: In[float] = 1.0
    seen: Out[float | None] = port(truth="top")
    ball: Out[Ball] = port(truth={"radius": "radius"})

    def update(self) -> Status:
        self.seen = self.value if self.value > 0 else None
        self.ball = Ball(self.value)
        return Status.SUCCESS


def found(bench, steps):
    """Run some steps beside a scene whose `top` is 10, 20, 30 at each question, and return what was known of the output."""
    registry.node(Looks)
    asked = iter(range(10, 1000, 10))
    head = "keys: {a: float, b: float, ball: Ball, n: {type: float, default: 1}}"
    tree = bench.build(f"out: {{out: float, roundness: {{type: float, scene: true}}}}\nsequence: [{steps}]", head)
    truths = Truths(tree, lambda: {"top": float(next(asked)), "radius": 3.0, "roundness": 7.0, "bad": float("nan")})
    assert bench.run(tree, watchers=[truths]).status == "SUCCESS"
    return truths.found


@pytest.mark.parametrize(
    ("steps", "known"),
    [
        ("looks: {seen: $out}", 10.0),
        ("looks: {seen: $a}, set: {out: a}", 10.0),  # as it was when the node looked, not when the output was written
        ("looks: {seen: $a}, set: {b: a}, set: {out: b}", 10.0),
        ("looks: {seen: $out}, {name: again, looks: {seen: $out}}", 20.0),
        ("looks: {seen: $a}, {name: again, looks: {seen: $b, value: 2}}, set: {a: b, b: a}, set: {out: a}", 20.0),
        (
            "looks: {seen: $a}, {name: again, looks: {seen: $b, value: 2}}, set: {a: b, b: a}, set: {out: b}",
            None,
        ),  # none rather than a wrong one
        ("looks: {seen: $a}, {name: again, looks: {seen: $b, value: 2}}, set: {out: b}", 10.0),
        ("looks: {ball: $ball}, set: {out: ball.radius}", 3.0),
        ("looks: {seen: $a}, set: {out: 2 * a}", None),
        ("looks: {seen: $out}, set: {out: 2}", None),
        ("looks: {seen: $a}, set: {a: 5}, set: {out: a}", None),
        ("looks: {seen: $out}, {name: again, looks: {seen: $out, value: 0}}", None),
    ],
)
def test_the_truth_is_of_what_the_node_found(bench, steps, known):
    truth = found(bench, re.sub(r"(?<!again, )\b(\w+): (\{[^}]*\})", r"{\1: \2}", steps))
    assert truth.get("out") == known
    assert truth["roundness"] == 7.0


@pytest.mark.parametrize(
    ("role", "truth"), [(In[float], "top"), (Out[float], 3), (Out[float], {"radius": "the radius"}), (Out[float], {})]
)
def test_only_outputs_have_truths_and_these_have_names(role, truth):
    with pytest.raises(PortError, match="truth"):
        type("Wrong", (Behavior,), {"__annotations__": {"x": role}, "x": port(truth=truth)})


@pytest.mark.parametrize(
    ("role", "truth", "told"),
    [
        (Out[Ball], {"raduis": "radius"}, "did you mean 'radius'"),
        (Out[Ball], "radius", "is of type Ball, but its truth 'radius' is a number; .* truth={'radius': 'radius'}"),
        (Out[list[Length]], "height", "but its truth 'height' is a number; leave the truth out"),
        (Out[str], "height", "is of type str"),
        (Out[Length], {"radius": "radius"}, "no attribute 'radius'; write truth='radius'"),
        (Out[Force], "height", "the port is a Force, but 'height' is a Length"),
        (Out[Round], {"bend": "radius"}, "its 'bend' is a Curvature, but 'radius' is a Length"),
    ],
)
def test_what_cannot_be_compared_is_refused(own_nodes, role, truth, told):
    with pytest.raises(registry.RegistryError, match=told):
        registry.node(
            type("Wrong", (Behavior,), {"__doc__": "Look.", "__annotations__": {"x": role}, "x": port(truth=truth)})
        )


@pytest.mark.parametrize(("known", "slips"), [("tops", 1), ("top", 0), ("stiffness", 0)])
def test_a_truth_that_the_scene_nearly_knows_is_a_slip_and_one_that_it_lacks_is_none(bench, known, slips):
    registry.node(Looks)
    tree = bench.build("out: {out: float}\nsequence: [looks: {seen: $out}]", "")
    truths = Truths(tree, lambda: {known: 1.0})
    assert bench.run(tree, watchers=[truths]).status == "SUCCESS"
    assert [note.partition("did you mean ")[2] for note in truths.notes] == slips * [f"{known!r}?"]


def test_a_run_says_a_slip_and_none_where_the_scene_lacks_a_shipped_quantity(bench, own_nodes, tmp_path):
    (tmp_path / "looking.py").write_text(
        "from stretch_bt import Behavior, Out, Status, node, port\nfrom stretch_bt.units import Length\n"
        '@node\nclass LookAt(Behavior):\n    """Look."""\n'
        '    one: Out[Length] = port(truth="heigth")\n    two: Out[Length] = port(truth="radius_2")\n'
        "    def update(self):\n        self.one = self.two = 1.0\n        return Status.SUCCESS\n"
    )
    head = "format: stretch-tree/1\nimports: {looking: looking}\nscene: water_balloon\ndevices: {camera: DepthCamera}\n"
    body = "{out: {one: Length, two: Length}, sequence: [capture: {frame}, look_at: {one: $one, two: $two}]}"
    (tmp_path / "tree.yaml").write_text(f"{head}trees: {{main: {body}}}\n")
    notes = run(tmp_path / "tree.yaml", record="none").notes
    assert [note.partition("the scene knows no ")[2] for note in notes if "knows no" in note] == [
        "'heigth', which a port declares as its truth; did you mean 'height'?"
    ]


def test_a_scene_knows_what_ports_are_compared_with():
    known = {"force", "deflection", "stretch", "depth", "height", "contact_height"}
    for name in SCENES:
        scene = load_scene(name)
        known |= {*scene.object.known(), *scene.dimensions}
    declared = {q for info in registry.load_all().values() for p in info.ports.values() for q in p.truth.values()}
    assert declared
    assert declared <= known


def test_a_height_above_the_membrane_is_not_compared_with_one_in_the_world(tmp_path):
    """It was once reported as 98 % off, beside the height of an object that nothing had touched."""
    tree = "format: stretch-tree/1\ndevices: {camera: DepthCamera}\nscene: water_balloon\n"
    body = "{out: [height], sequence: [capture: {frame}, track_height: {frame, height}]}"
    (tmp_path / "tree.yaml").write_text(f"{tree}trees: {{main: {body}}}\n")
    result = run(tmp_path / "tree.yaml", record="none")
    assert result.status == "SUCCESS"
    assert "height" in result.outputs
    assert "height" not in result.truth


def test_what_follows_from_mocks_has_no_truth(tmp_path):
    """A palpation whose heights were mocked was compared with a twin that nobody pressed."""
    tree = "format: stretch-tree/1\ndevices: {arm: Arm, force_sensor: ForceSensor}\nscene: water_balloon\n"
    body = "{out: [force], sequence: [wait: {duration: 1 s}, measure_force: {force}]}"
    (tmp_path / "tree.yaml").write_text(f"{tree}trees: {{main: {body}}}\n")
    for mocks, known in (({"mocks": [{"match": "main/wait"}]}, set()), (None, {"force"})):
        result = run(tmp_path / "tree.yaml", mocks=mocks, record="none")
        assert (result.status, result.truth.keys()) == ("SUCCESS", known), result.reason
