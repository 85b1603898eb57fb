"""The example package, installed as a user would: its nodes are listed, completed, checked and run."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLE = Path(__file__).parents[2] / "examples" / "third_party"
NODES = ("force_loss", "press_twice")

PROBE = """
import json, sys
from pathlib import Path
from stretch_bt import run
from stretch_bt.source import load
from stretch_bt.tree.program import load_program
from stretch_bt.tree.registry import load_all
from stretch_bt.tree.node_description import describe
from stretch_bt.tree.schema import schema

folder = Path(sys.argv[1])
nodes = load_all()
tree = folder / "relaxation.yaml"
program = load_program(tree)
outcome = run(tree, mocks=folder / "relaxation.mocks.yaml", out="record")
loss = outcome.outputs["loss"]
print(json.dumps({
    "described": [describe(nodes[name]) for name in sys.argv[2:]],
    "modules": [nodes[name].cls.__module__ for name in sys.argv[2:]],
    "diagnostics": [str(d) for d in program.diagnostics],
    "schema": schema("tree"),
    "tree": load(tree).plain(),
    "status": outcome.status,
    "loss": loss["value"],
    "sd": loss["sd"],
}))
"""


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> dict:
    target = tmp_path_factory.mktemp("site")
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "install", "--quiet"]
    options = ["--no-deps", "--no-build-isolation", "--no-index", "--target", str(target)]
    subprocess.run([*pip, *options, str(EXAMPLE)], check=True, capture_output=True)
    environment = os.environ | {"PYTHONPATH": str(target)}
    command = [sys.executable, "-c", PROBE, str(EXAMPLE), *NODES]
    done = subprocess.run(command, check=True, capture_output=True, text=True, env=environment, cwd=target)
    return json.loads(done.stdout)


def test_its_nodes_are_listed(found: dict) -> None:
    assert tuple(entry["name"] for entry in found["described"]) == NODES
    assert [module.partition(".")[0] for module in found["modules"]] == ["stretch_bt_gestures"] * 2
    assert [entry["kind"] for entry in found["described"]] == ["model", "actuation"]
    for entry in (port for node in found["described"] for port in (*node["inputs"], *node["outputs"])):
        assert entry["doc"]


def test_the_editor_completes_its_nodes(found: dict) -> None:
    import jsonschema

    validator = jsonschema.Draft7Validator(found["schema"])
    assert list(validator.iter_errors(found["tree"])) == []
    press = next(p["press_twice"] for p in found["tree"]["trees"]["main"]["sequence"] if "press_twice" in p)
    press["dept"] = press.pop("depth")
    assert not validator.is_valid(found["tree"])


def test_its_tree_is_clean_and_runs_without_a_device(found: dict) -> None:
    assert found["diagnostics"] == []
    assert found["status"] == "SUCCESS"
    assert found["loss"] == pytest.approx(0.1)
    assert found["sd"] == pytest.approx(0.05 / 3 * (1 + 0.9**2) ** 0.5)


def test_the_readme_names_its_files() -> None:
    text = (EXAMPLE / "README.md").read_text(encoding="utf-8")
    for name in ("relaxation.yaml", "relaxation.mocks.yaml"):
        assert name in text
        assert (EXAMPLE / name).is_file()
