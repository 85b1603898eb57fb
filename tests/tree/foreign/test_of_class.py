"""Every class of behaviours that py_trees brings either builds and ticks as a node, or is refused with a reason."""

import inspect
import re

import py_trees
import pytest

from stretch_bt import run
from stretch_bt.tree.foreign.of_class import info_of
from stretch_bt.tree.foreign.refused import BehaviourRefused

MODULES = (py_trees.behaviours, py_trees.timers, py_trees.decorators, py_trees.composites, py_trees.ports)
CLASSES = {
    f"{module.__name__}.{name}": cls
    for module in MODULES
    for name, cls in vars(module).items()
    if inspect.isclass(cls) and issubclass(cls, py_trees.behaviour.Behaviour) and cls.__module__ == module.__name__
}
#: what stands in the braces of each that can be written, and how it ends within five ticks
SAMPLES = {
    "behaviours.Success": ("{}", "SUCCESS"),
    "behaviours.Failure": ("{}", "FAILURE"),
    "behaviours.Running": ("{}", "RUNNING"),
    "behaviours.Dummy": ("{}", "RUNNING"),
    "behaviours.Periodic": ("{n: 2}", "SUCCESS"),
    "behaviours.StatusQueue": ("{queue: [RUNNING, FAILURE], eventually: none}", "FAILURE"),
    "behaviours.SuccessEveryN": ("{n: 1}", "SUCCESS"),
    "behaviours.TickCounter": ("{duration: 3, completion_status: FAILURE}", "FAILURE"),
    "behaviours.BlackboardToStatus": ("{variable_name: none_such}", "ERROR"),
    "behaviours.CheckBlackboardVariableExists": ("{variable_name: none_such}", "FAILURE"),
    "behaviours.WaitForBlackboardVariable": ("{variable_name: none_such}", "RUNNING"),
    "behaviours.UnsetBlackboardVariable": ("{key: none_such}", "SUCCESS"),
    "behaviours.SetBlackboardVariable": ("{variable_name: a, variable_value: 3, overwrite: true}", "SUCCESS"),
    "behaviours.ProbabilisticBehaviour": ("{weights: [1, 0, 0]}", "SUCCESS"),
    "timers.Timer": ("{duration: 0.002}", "SUCCESS"),
}
#: which argument stands in the way of the others
REFUSED = {
    "behaviours.CheckBlackboardVariableValue": "check",
    "behaviours.CheckBlackboardVariableValues": "checks",
    "behaviours.WaitForBlackboardVariableValue": "check",
    "behaviours.CompareBlackboardVariables": "operator",
}
TREE = """\
format: stretch-tree/1
tick: 1 ms
imports: {{node: {name}}}
trees:
  main:
    timeout: {limit}
    node: {given}
"""


def short(name):
    return name.removeprefix("py_trees.")


@pytest.mark.parametrize("name", CLASSES)
def test_a_class_ticks_or_is_refused_with_a_reason(tmp_path, name):
    if short(name) not in SAMPLES:
        with pytest.raises(BehaviourRefused) as refused:
            info_of(CLASSES[name])
        assert CLASSES[name].__name__ in str(refused.value)
        assert refused.value.hint
        if short(name) in REFUSED:
            assert repr(REFUSED[short(name)]) in str(refused.value)
            assert "a node of your own with @node" in refused.value.hint
        return
    given, end = SAMPLES[short(name)]
    tree = tmp_path / "tree.yaml"
    limit = (
        "20 s" if short(name) == "timers.Timer" else "5 ms"
    )  # a timer goes by the clock of a machine that may be late
    tree.write_text(TREE.format(name=name, given=given, limit=limit))
    result = run(tree, out=tmp_path / "record")
    if end == "RUNNING":
        assert "out of time while main/node was running" in result.reason
    else:
        assert result.status == end, result.reason
    if end in ("FAILURE", "ERROR"):
        assert "main/node: " in result.reason


def test_the_samples_are_classes_of_py_trees():
    assert {f"py_trees.{name}" for name in (*SAMPLES, *REFUSED)} <= CLASSES.keys()


@pytest.mark.parametrize("name", [name for name in CLASSES if re.search("decorators|composites", name)])
def test_what_holds_other_behaviours_is_a_construct_of_the_language(name):
    with pytest.raises(BehaviourRefused) as refused:
        info_of(CLASSES[name])
    assert "holds other behaviours" in str(refused.value) or "is abstract" in str(refused.value)
    if name.endswith(("Sequence", "Inverter", "Retry")):
        assert re.fullmatch("use '(sequence|invert|retry)' of the language", refused.value.hint)


class Base(py_trees.behaviour.Behaviour):
    def update(self):
        return py_trees.common.Status.SUCCESS


class Untyped(Base):
    def __init__(self, name, depth):
        super().__init__(name)


class OnlyForCheckers(Base):
    def __init__(self, name: str, pose: "Pose"):  # noqa: F821
        super().__init__(name)


class Client(Base):
    def __init__(self, name: str, client: py_trees.blackboard.Client):
        super().__init__(name)


class Positional(Base):
    def __init__(self, depth: int, /, name: str = "p"):
        super().__init__(name)


class Holder(Base):
    def __init__(self, name: str, inner: py_trees.behaviour.Behaviour | None = None):
        super().__init__(name)


class WithDefaults(Base):
    def __init__(self, name: str, count=3, on_end: "Pose | None" = None, check=print, *more, gain: float = 2, **rest):  # noqa: F821
        super().__init__(name)


@pytest.mark.parametrize(
    ("cls", "said", "hint"),
    [
        (
            Untyped,
            "Untyped needs 'depth' without a type",
            "annotate it, or write a subclass that gives 'depth' a value",
        ),
        (OnlyForCheckers, "needs 'pose' of type Pose", "write a subclass that gives 'pose' a value"),
        (Client, "needs 'client' of type Client", "a node of your own with @node"),
        (Positional, "needs 'depth' of type int", "write a subclass"),
        (Holder, "its argument 'inner' takes py_trees.behaviour.Behaviour | None", "the language's own constructs"),
        (int, "int is a class, but none of behaviours", "name a class of behaviours"),
    ],
)
def test_a_class_that_no_file_can_make_is_refused_with_its_argument(cls, said, hint):
    with pytest.raises(BehaviourRefused) as refused:
        info_of(cls)
    assert said in str(refused.value)
    assert hint in refused.value.hint


def test_what_no_file_can_write_keeps_the_default_of_the_class():
    info = info_of(WithDefaults, "other")
    assert info.name == "other"
    assert {name: (str(info.types[name]), port.default) for name, port in info.ports.items()} == {
        "count": ("int", 3),
        "gain": ("float", 2),
    }
