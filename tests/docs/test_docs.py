"""The documentation says what the package does: its files check, its commands run, its tables equal the code's.

In a page, an HTML comment before a block states its kind:
`file: NAME` it is written there; `run: 0 2` its commands are run and exit so; `says` its lines stand in the output of the
commands before it; `wrong: code` it is refused for that; `header` and `body` a tree and places that may stand in it.
"""

import re
import runpy
import shlex
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import py_trees
import pytest

from stretch_bt.runtime.check import check
from stretch_bt.tree import registry
from stretch_bt.tree.flow import CONSTRUCTS
from stretch_bt.tree.registry import RESERVED

TABLES = runpy.run_path(str(Path(__file__).with_name("tables.py")))
ROOT = TABLES["ROOT"]
PAGES = sorted(
    [
        *(ROOT / "docs").glob("*.md"),
        ROOT / "docs" / "accuracy" / "index.md",
        ROOT / "CONTRIBUTING.md",
        ROOT / "README.md",
    ]
)
BLOCK = re.compile(r"((?:<!-- [^>]* -->\n)*)```(\w+)\n(.*?)```", re.DOTALL)
MARK = re.compile(r"<!-- ([\w-]+)(?:: (.*?))? -->")
LINK = re.compile(r"(?<!!)\[[^\]]*\]\(([^)\s]+)\)|!\[[^\]]*\]\(([^)\s]+)\)")
#: words that belong to a machine or to how the package came about, not to the package
FOREIGN = re.compile(
    r"/(?:tmp|home|root|work|Users)/|\bTODO\b|\bFIXME\b|\bissue \d|localhost|127\.0\.0\.1", re.IGNORECASE
)


@dataclass(frozen=True)
class Block:
    """A fenced block with its marks and the line that it begins on."""

    language: str
    text: str
    marks: dict[str, str]
    line: int


def blocks(page):
    text = page.read_text("utf-8")
    return [
        Block(m[2], m[3], dict(MARK.findall(m[1])), text.count("\n", 0, m.start(3)) + 1) for m in BLOCK.finditer(text)
    ]


def by_name(page):
    return page.name


pages = pytest.mark.parametrize("page", PAGES, ids=by_name)


@pytest.fixture
def folder(tmp_path, monkeypatch, request):
    """A folder to work in, with every file that the page names; nodes that it brings are forgotten afterwards."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(py_trees.ports, "_REGISTRY", {})  # which warns of a class that is defined again
    for block in blocks(request.getfixturevalue("page")):
        if "file" in block.marks:
            path = tmp_path / block.marks["file"]
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(block.text, encoding="utf-8")
    known, modules = registry.load_all(), set(sys.modules)
    yield tmp_path
    registry._nodes.clear()
    registry._nodes.update(known)
    for name in set(sys.modules) - modules:
        if str(getattr(sys.modules[name], "__file__", None)).startswith(str(tmp_path)):
            del sys.modules[name]


@pages
def test_tables_are_those_of_the_code(page):
    assert page.read_text("utf-8") == TABLES["renewed"](page.read_text("utf-8")), "run: python tests/docs/tables.py"


def test_the_picture_is_that_of_the_task():
    assert (ROOT / "docs" / "palpate_stiffness.svg").read_text("utf-8") == TABLES["picture"]()


@pages
def test_links_resolve(page):
    text = page.read_text("utf-8")
    for link in (a or b for a, b in LINK.findall(text)):
        path, _, anchor = link.partition("#")
        if not re.match(r"\w+:", link):
            target = (page.parent / path).resolve() if path else page
            assert target.exists(), f"{page.name}: {link}"
            assert not anchor or anchor in anchors(target), f"{page.name}: {link}"


def anchors(page):
    headings = re.findall(r"^#+ (.*)$", page.read_text("utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-") for heading in headings}


@pages
def test_says_nothing_of_a_machine_or_of_its_making(page):
    assert FOREIGN.findall(page.read_text("utf-8")) == []


@pages
def test_files_are_right_and_commands_run(page, folder, capfd):
    output = ""
    for block in blocks(page):
        where = f"{page.name}:{block.line}"
        if block.language == "yaml":
            checked(block, folder, where)
        if "run" in block.marks:
            output = run(block, where, capfd)
        if "says" in block.marks:
            for line in filter(None, block.text.splitlines()):
                assert " ".join(line.split()) in " ".join(output.split()), f"{where}\n{output}"


def checked(block, folder, where):
    """Check a YAML block of a whole file, as it stands in the page."""
    path = folder / block.marks.get("file", "block.yaml")
    if not block.text.startswith("format: stretch-"):
        return
    path.write_text(block.text, encoding="utf-8")
    found = check(path)
    if "wrong" in block.marks:
        assert block.marks["wrong"] in [d.code for d in found], f"{where}: {found}"
    elif "needs" not in block.marks:
        assert [str(d) for d in found if d.severity == "error"] == [], where


def run(block, where, capfd):
    """Run the commands of a block and return what they print."""
    if block.language == "python":
        exec(compile(block.text, where, "exec"), {"__name__": "__main__"})  # what it raises names the page and the line
        return "".join(capfd.readouterr())
    commands = [shlex.split(line, comments=True) for line in block.text.splitlines() if line.strip()]
    wanted = [int(status) for status in block.marks["run"].split()]
    assert len(commands) == len(wanted), f"{where}: one exit code for each command"
    output = ""
    for command, status in zip(commands, wanted, strict=True):
        done = execute(command, capfd)
        assert done[0] == status, f"{where}: {shlex.join(command)} ended with {done[0]}\n{done[1]}"
        output += done[1]
    return output


def execute(command, capfd):
    """Return exit code and output of one command; `stretch-bt` runs in this process."""
    *words, target = command if len(command) > 2 and command[-2] == ">" else [*command, None]
    if words[-1:] == [">"]:
        words.pop()
    if words[0] != "stretch-bt":
        words[:1] = [sys.executable, "-m", "pytest"] if words[0] == "pytest" else [sys.executable]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        return done.returncode, done.stdout + done.stderr
    status = command_line(words)
    out, err = capfd.readouterr()
    if target:
        Path(target).write_text(out, encoding="utf-8")
    return status, out + err


def command_line(words):
    from stretch_bt.cli import main

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "argv", words)
        try:
            main()
        except SystemExit as end:
            return end.code or 0
    return 0


@pages
def test_places_may_stand_in_the_tree_of_their_page(page, tmp_path):
    header = next((b.text for b in blocks(page) if "header" in b.marks), "")
    for block in (b for b in blocks(page) if "body" in b.marks):
        path = tmp_path / "tree.yaml"
        indented = "".join(f"      {line}" for line in block.text.splitlines(keepends=True))
        path.write_text(header + indented, encoding="utf-8")
        assert [str(d) for d in check(path) if d.severity == "error"] == [], f"{page.name}:{block.line}"


def test_every_code_has_a_mistake_and_every_mistake_a_code():
    assert {mistake["code"] for mistake in TABLES["mistakes"]()} == TABLES["codes_in_source"]()


def test_the_language_page_knows_every_construct_and_modifier():
    text = (ROOT / "docs" / "tree-language.md").read_text("utf-8")
    missing = [word for word in (*CONSTRUCTS, *RESERVED) if f"`{word}`" not in text]
    assert missing == []


def test_the_running_page_knows_every_option_and_field():
    import dataclasses

    from stretch_bt.cli.command_run import command
    from stretch_bt.runtime.task import RunResult

    text = (ROOT / "docs" / "running.md").read_text("utf-8")
    options = [f"--{name.rstrip('_')}" for name in command.__annotations__ if name not in ("tree", "return")]
    assert [option for option in options if option not in text] == []
    assert [f.name for f in dataclasses.fields(RunResult) if f"`{f.name}`" not in text] == []


def test_the_testing_page_knows_every_field_of_a_mocks_file():
    from stretch_bt.runtime.mocks_file import FIELDS, STATUSES, THEN, TOP

    text = (ROOT / "docs" / "testing.md").read_text("utf-8")
    assert [word for word in (*TOP, *FIELDS, *THEN, *STATUSES) if f"`{word}`" not in text] == []


def test_the_records_page_knows_every_event_and_schema():
    from stretch_bt.runtime.record.channels import _JSON_SCHEMAS

    text = (ROOT / "docs" / "records.md").read_text("utf-8")
    source = "".join(path.read_text("utf-8") for path in (TABLES["PACKAGE"] / "runtime").rglob("*.py"))
    events = {*re.findall(r"\b_?(?:note|event)\(\s*\"(\w+)\"", source), "write", "header"}
    assert {"status", "stop"} < events
    assert [word for word in [*events, *_JSON_SCHEMAS] if f"`{word}`" not in text] == []


@pages
def test_files_that_are_spoken_of_exist(page):
    spoken = re.findall(r"(?:tests|benchmarks|examples|stretch_bt)/[\w/.-]*\w", page.read_text("utf-8"))
    templates = ("NAME", "runs/")
    missing = [path for path in spoken if not any(t in path for t in templates) and not (ROOT / path).exists()]
    assert missing == []


def test_every_page_is_in_the_index():
    text = (ROOT / "docs" / "index.md").read_text("utf-8")
    assert [p.name for p in (ROOT / "docs").glob("*.md") if f"({p.name})" not in text and p.name != "index.md"] == []
