"""The packages with drivers, installed as a stranger's would be: their own tests pass, and every command knows their devices."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("rosbags.rosbag2")
EXAMPLES = Path(__file__).parents[2] / "examples"
PACKAGES = ("modbus_gripper", "ros_bag_camera")


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """A folder into which both packages are installed, without a network."""
    target = tmp_path_factory.mktemp("site")
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "install", "--quiet"]
    options = ["--no-deps", "--no-build-isolation", "--no-index", "--target", str(target)]
    places = [str(EXAMPLES / name) for name in PACKAGES]
    subprocess.run([*pip, *options, *places], check=True, capture_output=True)
    return target


@pytest.fixture
def command(site, tmp_path):
    """Run a Python command with the packages installed, in an empty folder."""

    def run(*words):
        path = os.pathsep.join(filter(None, (str(site), os.environ.get("PYTHONPATH"))))
        return subprocess.run(
            [sys.executable, *words],
            cwd=tmp_path,
            env={**os.environ, "PYTHONPATH": path},
            capture_output=True,
            text=True,
            check=False,
        )

    return run


@pytest.mark.parametrize("package", PACKAGES)
def test_its_own_tests_pass(command, package):
    settings, tests = str(EXAMPLES / package / "pyproject.toml"), str(EXAMPLES / package / "tests")
    done = command("-m", "pytest", "-q", "-p", "no:cacheprovider", "-c", settings, tests)
    assert done.returncode == 0, done.stdout


def test_every_command_knows_its_device(command):
    cell = str(EXAMPLES / "modbus_gripper" / "cell.yaml")
    assert json.loads(command("-m", "stretch_bt", "check", cell, "--json").stdout) == []
    schema = command("-m", "stretch_bt", "schema", "cell").stdout
    assert '"const": "two_jaw"' in schema
    assert '"const": "ros_bag"' in schema
    said = json.loads(command("-m", "stretch_bt", "status", cell, "--device", "gripper", "--json").stdout)
    [about] = [row for row in said if row["check"] == "gripper"]
    assert not about["ok"]
    assert "does not answer" in about["detail"]


@pytest.mark.parametrize("package", PACKAGES)
def test_the_readme_names_its_files(package):
    text = (EXAMPLES / package / "README.md").read_text(encoding="utf-8")
    for path in (EXAMPLES / package).glob("*.yaml"):
        assert path.name in text
