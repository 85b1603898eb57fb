"""`stretch-bt new`."""

from __future__ import annotations

import ast
from collections.abc import Mapping
from importlib.resources import files
from keyword import iskeyword
from pathlib import Path
from typing import Annotated

import typer

from stretch_bt.errors import InvalidInput
from stretch_bt.hardware.own_modules import installed_module
from stretch_bt.source import closest, did_you_mean

__all__ = ["command"]

KINDS = {
    "tree": {"NAME.yaml": "tree.yaml"},
    "scene": {"NAME.yaml": "scene.yaml"},
    "cell": {"NAME.yaml": "cell.yaml"},
    "mocks": {"NAME.yaml": "mocks.yaml"},
    "node": {"NAME.py": "node_KIND.py"},
    "device": {"NAME.py": "device_KIND.py", "NAME.yaml": "device.yaml", "test_NAME.py": "device_test.py"},
}
#: kinds of a node, the first by default
NODES = ("model", "perception", "actuation")
#: for each kind of device: its name in the cell, and further names in its test
_POSES = "from stretch_bt.frames import Pose\n"
DEVICES = {
    "Arm": (
        "arm",
        {
            "POSES": _POSES,
            "MOVES": "moves=(Pose((0, 0, 0.2)), Pose((0, 0, 0.23), (0, 0, 0.2))), ",
            "TOLERANCE": "0.0005",
        },
    ),
    "Gripper": ("gripper", {"POSES": "", "MOVES": "moves=(0.060, 0.080), ", "TOLERANCE": "0.0005"}),
    "DepthCamera": ("camera", {"POSES": "", "MOVES": "", "TOLERANCE": "0.001"}),
    "ForceSensor": ("force_sensor", {"POSES": "", "MOVES": "", "TOLERANCE": "0.1"}),
}


def command(
    what: Annotated[str, typer.Argument(help="tree, scene, cell, mocks, node or device")],
    name: Annotated[str, typer.Argument(help="Its name, and the file's name.")],
    kind: Annotated[
        str | None, typer.Option("--kind", help=f"Kind of device: {', '.join(DEVICES)}; of node: {', '.join(NODES)}.")
    ] = None,
) -> None:
    """Write commented files to begin with, in the present folder."""
    if what == "sweep":
        raise InvalidInput(
            "no sweep is written: docs/sweeps.md has one to copy, and `stretch-bt schema sweep` its keys"
        )
    if what not in KINDS:
        raise InvalidInput(
            f"{what!r} is not a kind of file; {did_you_mean(what, KINDS) or 'one of ' + ', '.join(KINDS)}"
        )
    if not name.isidentifier() or not name.islower():
        raise InvalidInput(f"{name!r} is not a name; use small letters, digits and _")
    words = {**_of_kind(what, kind), "NAME": name, "TITLE": _title(name)}
    wanted = {Path(_filled(file, words)): _template(template, words) for file, template in KINDS[what].items()}
    if there := [str(path) for path in wanted if path.exists()]:
        raise InvalidInput(f"{there[0]} is there already; choose another name")
    if what == "device":
        _check_device(name, words["KIND"])
    _check_names(name, {path: text for path, text in wanted.items() if path.suffix == ".py"})
    if what == "node":
        _check_node(name)
    for path, text in wanted.items():
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
        typer.echo(str(path))


def _title(name: str) -> str:
    return "".join(part.capitalize() for part in name.split("_"))


def _template(template: str, words: Mapping[str, str]) -> str:
    name = f"{_filled(template, words)}.txt"
    return _filled(files("stretch_bt.cli").joinpath("templates", name).read_text("utf-8"), words)


def _check_names(name: str, modules: Mapping[Path, str]) -> None:
    """Raise InvalidInput where a module or class of this name takes the place of another one."""
    another = f"choose another name, such as my_{name}"
    if modules and (iskeyword(name) or iskeyword(_title(name)) or name == "null"):
        raise InvalidInput(f"{name!r} has a meaning of its own in Python or YAML; {another}")
    for path, text in modules.items():
        if installed_module(path.stem) is not None:
            raise InvalidInput(f"{path} would have the name of an installed Python module; {another}")
        if _bound(text).count(_title(name)) > 1:
            raise InvalidInput(
                f"the class {_title(name)} would hide another {_title(name)} that {path} needs; {another}"
            )


def _check_device(name: str, kind: str) -> None:
    """Raise InvalidInput where cell files mean a shipped device of this kind by the name."""
    from stretch_bt.hardware.implementations import SHIPPED

    if (kind, name) in SHIPPED:
        raise InvalidInput(f"{name!r} is the name of a shipped {kind}; choose another name, such as my_{name}")


def _check_node(name: str) -> None:
    """Raise InvalidInput where trees write something else by this name."""
    from stretch_bt.tree.node_info import snake_case

    if (made := snake_case(_title(name))) != name:
        raise InvalidInput(
            f"its class, {_title(name)}, would be the node {made!r}, not {name!r}; choose another name, such as {_free(made)}"
        )
    if _free(name) != name:
        raise InvalidInput(
            f"trees write something else by {name!r} already; choose another name, such as {_free(name)}"
        )


def _free(name: str) -> str:
    """Return a name, or one like it where trees write something else by it."""
    from stretch_bt.tree.flow import CONSTRUCTS
    from stretch_bt.tree.registry import load_all

    return f"my_{name}" if name in load_all() or name in CONSTRUCTS else name


def _bound(text: str) -> list[str]:
    """Return the names that the top level of a module imports or defines."""
    found: list[str] = []
    for made in ast.parse(text).body:
        if isinstance(made, ast.Import | ast.ImportFrom):
            found += [alias.asname or alias.name for alias in made.names]
        elif isinstance(made, ast.ClassDef | ast.FunctionDef):
            found.append(made.name)
    return found


def _of_kind(what: str, kind: str | None) -> dict[str, str]:
    """Return the words of a kind of node or device."""
    kinds = {"node": NODES, "device": tuple(DEVICES)}.get(what)
    if kinds is None:
        if kind is not None:
            raise InvalidInput("only a node or a device has a kind; leave --kind out")
        return {}
    kind = NODES[0] if what == "node" and kind is None else kind
    if kind not in kinds:
        given = f"a {what} needs --kind" if kind is None else f"{kind!r} is not a kind of {what}"
        raise InvalidInput(f"{given}; write --kind {(kind and closest(kind, list(kinds))) or ', '.join(kinds)}")
    if what == "node":
        return {"KIND": kind}
    device, more = DEVICES[kind]
    return {**more, "KIND": kind, "DEVICE": device}


def _filled(text: str, words: Mapping[str, str]) -> str:
    for word, value in words.items():
        text = text.replace(word, value)
    return text
