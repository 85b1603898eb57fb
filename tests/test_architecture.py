"""Rules about the repository itself: links, imports through them, words that do not belong here, tests in their places."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
LINKS = ("behaviors", "trees", "perception", "hardware")
TRACKED = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False).stdout.split()
SOURCES = sorted(
    p for folder in ("stretch_bt", "tests", "benchmarks", "examples") for p in (ROOT / folder).rglob("*.py")
)


NAMED = re.compile(rf"(?:\b(?:from|import)\s|[,;\\])\s*(?:{'|'.join(LINKS)})\b")


def imported(path):
    """Return what a file imports, if it may import a link; to parse them all takes seconds."""
    text = path.read_text("utf-8")
    for node in ast.walk(ast.parse(text)) if NAMED.search(text) else ():
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            yield node.module or ""


@pytest.mark.parametrize("name", LINKS)
def test_links_are_relative_and_lead_into_the_package(name):
    link = ROOT / name
    if not link.is_symlink():
        pytest.skip("this checkout has no symbolic links")
    assert link.readlink() == Path("stretch_bt") / name
    assert link.resolve() == (ROOT / "stretch_bt" / name).resolve()


def test_nothing_imports_through_the_links():
    assert len(SOURCES) > 100
    through = {p.name for p in SOURCES if any(m.partition(".")[0] in LINKS for m in imported(p))}
    assert through == set()


def test_heavy_packages_are_imported_where_they_are_used():
    """Importing the package must not load what only some users need."""
    code = "import stretch_bt, stretch_bt.perception, stretch_bt.model, sys; print([m for m in %r if m in sys.modules])"
    heavy = ["cv2", "scipy", "py_trees", "pymodbus", "rtde_control", "mcap"]
    done = subprocess.run([sys.executable, "-c", code % heavy], capture_output=True, text=True, check=True, cwd=ROOT)
    assert done.stdout.strip() == "[]"


def test_test_folders_mirror_the_package():
    packages = {p.parent.relative_to(ROOT / "stretch_bt") for p in (ROOT / "stretch_bt").rglob("__init__.py")}
    missing = {
        str(p) for p in packages if len(p.parts) == 1 and p.parts[0] != "trees" and not (ROOT / "tests" / p).is_dir()
    }
    assert missing == set()


@pytest.mark.skipif(not TRACKED, reason="not a git checkout")
def test_no_path_of_a_machine_and_no_unfinished_work():
    pattern = re.compile(r"/(?:home|root|work|tmp)/\w|\bTODO\b|\bFIXME\b|\bXXX\b")
    found = [
        f"{name}:{number}"
        for name in TRACKED
        if name.endswith((".py", ".md", ".yaml", ".toml", ".cff"))
        and name != "tests/test_architecture.py"
        and (ROOT / name).exists()
        for number, line in enumerate((ROOT / name).read_text("utf-8").splitlines(), 1)
        if pattern.search(line)
    ]
    assert found == []
