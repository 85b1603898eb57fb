"""The example task with a node and tests of its own, installed as a user would: it is checked, and its tests pass where they stand alone."""

import ast
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLE = Path(__file__).parents[2] / "examples" / "ripeness"
TESTS = EXAMPLE / "test_ripeness.py"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a copy of the example outside the repository."""
    return Path(shutil.copytree(EXAMPLE, tmp_path_factory.mktemp("example") / "ripeness"))


@pytest.fixture(scope="module")
def installed(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Return an environment in which the example is installed."""
    target = tmp_path_factory.mktemp("site")
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "install", "--quiet"]
    options = ["--no-deps", "--no-build-isolation", "--no-index", "--target", str(target)]
    subprocess.run([*pip, *options, str(folder)], check=True, capture_output=True)
    beside = [os.environ["PYTHONPATH"]] if os.environ.get("PYTHONPATH") else []
    return os.environ | {"PYTHONPATH": os.pathsep.join([str(target), *beside])}


def done(folder: Path, environment: dict[str, str], *command: str) -> str:
    found = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stdout + found.stderr
    return found.stdout


def test_its_tests_pass(folder: Path, installed: dict[str, str]) -> None:
    quiet = ["-q", "-p", "no:cacheprovider", "-p", "no:xdist", "-W", "error"]
    told = done(folder, installed, sys.executable, "-m", "pytest", *quiet, TESTS.name)
    assert "9 passed" in told


def test_its_task_is_clean(folder: Path, installed: dict[str, str]) -> None:
    code = "import sys; from stretch_bt import check; print(check('ripeness.yaml'))"
    assert done(folder, installed, sys.executable, "-c", code).strip() == "[]"


def test_its_tests_import_pytest_and_numpy_alone() -> None:
    tree = ast.parse(TESTS.read_text(encoding="utf-8"))
    imported = [n for n in ast.walk(tree) if isinstance(n, ast.Import | ast.ImportFrom)]
    names = {alias.name for node in imported for alias in node.names}
    assert names == {"numpy", "pytest"}
    assert len([n for n in tree.body if isinstance(n, ast.FunctionDef) and n.name.startswith("test_")]) == 8


def test_the_readme_names_its_files() -> None:
    text = (EXAMPLE / "README.md").read_text(encoding="utf-8")
    for name in ("ripeness.yaml", "stretch_bt_ripeness", "test_ripeness.py"):
        assert name in text
        assert (EXAMPLE / name).exists()
