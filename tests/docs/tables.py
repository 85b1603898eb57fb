"""The tables of the documentation that are made from the code.

`python tests/docs/tables.py` writes them into the pages, between `<!-- table: NAME -->` and `<!-- end -->`, and draws the
picture of the README; the tests compare. Messages come from running each small mistake of mistakes.yaml.
"""

import ast
import json
import math
import os
import re
import resource
import sys
import tempfile
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import yaml

import stretch_bt
from stretch_bt.errors import Diagnostic, FileError
from stretch_bt.quantity_text import format_quantity
from stretch_bt.units import KINDS, Dimension, unit_names

ROOT = Path(__file__).parents[2]
PAGES = ROOT / "docs"
PACKAGE = Path(stretch_bt.__file__).parent
MARKED = re.compile(r"(<!-- table: ([\w-]+) -->\n).*?(<!-- end -->)", re.DOTALL)
OPTION = ["option", "default", "meaning"]
FORMATS = ("tree", "scene", "cell", "mocks", "sweep")


def rows(headings: list[str], content: list[list[str]]) -> str:
    """Return a table in Markdown."""
    safe = [[cell.replace("|", "\\|").replace("\n", " ") for cell in row] for row in content]
    lines = [headings, ["---"] * len(headings), *safe]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def code(text: str) -> str:
    """Return text as code, or nothing."""
    return f"`{text}`" if text else ""


# --- nodes


def described() -> list[dict[str, Any]]:
    """Return every shipped node as `nodes --json` has it."""
    from stretch_bt.tree.node_description import describe
    from stretch_bt.tree.registry import load_all
    from stretch_bt.tree.shared_signatures import describe_shared, shared_signatures

    found = [describe(info) for info in load_all().values() if info.cls.__module__.startswith("stretch_bt.")]
    found += [describe_shared(tree) for tree in shared_signatures().values()]
    return sorted(found, key=lambda entry: str(entry["name"]))


def nodes() -> str:
    """Each node with its ports."""
    parts = []
    for entry in described():
        uses = ", ".join(f"{d['name']}" + ("" if d["required"] else " (if declared)") for d in entry["devices"])
        head = f"### {entry['name']}\n\n{entry['doc']} Kind: {entry['kind']}." + (f" Uses: {uses}." if uses else "")
        ports = [port_row(p, "in") for p in entry["inputs"]]
        ports += [port_row(p, "in and out") for p in entry["inouts"]]
        ports += [port_row(p, "out") for p in entry["outputs"] if not is_sd(p, entry["outputs"])]
        table = rows(["port", "", "type", "default", "bounds", "meaning"], ports)
        parts.append(f"{head}\n\n{table}" if ports else f"{head}\n")
    return "\n" + "\n".join(parts) + "\n"


def is_sd(port: dict[str, Any], ports: list[dict[str, Any]]) -> bool:
    """Whether a port is the standard deviation of another."""
    return port["name"].removesuffix("_sd") in {p["name"] for p in ports} and port["name"].endswith("_sd")


def port_row(port: dict[str, Any], direction: str) -> list[str]:
    """Return the row of a port."""
    kind = KINDS.get(port["type"])
    default = ("required" if port["required"] else shown(port["default"], kind)) if direction != "out" else ""
    low, high = (shown(port[end], kind) if end in port else "" for end in ("min", "max"))
    return [code(port["name"]), direction, port["type"], default, bounds(low, high), port["doc"]]


def bounds(low: str, high: str) -> str:
    """Return the bounds of a port as text."""
    if low and high:
        return f"{low} to {high}"
    return f"from {low}" if low else f"to {high}" if high else ""


def shown(value: Any, kind: Any) -> str:
    """Return a default as a file would have it."""
    if value is None:
        return "none"
    return format_quantity(value, kind, 6) if kind else f"{value:g}" if isinstance(value, float) else str(value)


# --- types


def types() -> str:
    """The quantities with the units that can be written for them."""
    content = []
    for kind in KINDS.values():
        units = dict.fromkeys([kind.unit, *unit_names(kind.dimension), kind.si_unit])
        content.append([code(kind.name), ", ".join(code(u) for u in units), dimension(kind.dimension)])
    return rows(["type", "units, the one it is shown in first", "dimension"], content)


def dimension(given: Dimension) -> str:
    """Return a dimension in base units."""
    names = ("m", "kg", "s", "rad")
    return " ".join(n if e == 1 else f"{n}^{e}" for n, e in zip(names, given, strict=True) if e)


def objects() -> str:
    """What expressions may read of the objects that nodes hand on."""
    from stretch_bt.tree.registry import object_types
    from stretch_bt.tree.types import attributes

    content = []
    for name, cls in sorted(object_types().items()):
        if not cls.__module__.startswith("stretch_bt."):
            continue
        parts = ", ".join(f"`.{part}` {type_}" for part, type_ in attributes(cls).items())
        content.append([code(name), parts or "nothing"])
    return rows(["type", "attributes"], content)


def readings() -> str:
    """The readings of devices that expressions may use."""
    from stretch_bt.hardware.interfaces import INTERFACES, readings_of
    from stretch_bt.tree.types import from_annotation

    content = []
    for name, interface in INTERFACES.items():
        parts = [f"`.{reading}` {from_annotation(a)}" for reading, a in readings_of(interface).items()]
        content.append([code(name), (interface.__doc__ or "").split(";")[0].rstrip("."), ", ".join(parts) or "none"])
    return rows(["kind", "what it is", "readings in expressions"], content)


# --- files


def scene() -> str:
    """The fields of a scene file, without the options of the kinds of objects and the effects."""
    from stretch_bt.simulation.scene.file import _model

    return file_table(_model(), skip=("object", "effects"))


def kinds() -> str:
    """The options of each kind of object, and the effects that it can have."""
    from stretch_bt.simulation.objects.base import ObjectSpec
    from stretch_bt.simulation.objects.registry import kinds

    shared = tuple(ObjectSpec.model_fields)
    parts = [f"#### Every object\n\n{rows(OPTION, list(fields_of(ObjectSpec, '', ('type',))))}"]
    for name, cls in kinds().items():
        content = list(fields_of(cls, "", shared))
        able = ", ".join(code(effect) for effect in cls.effects)
        doc = f"{first_paragraph(cls)} " + (f"It can have {able}." if able else "It has no effects of its own.")
        parts.append(f"#### `type: {name}`\n\n{doc}\n" + (f"\n{rows(OPTION, content)}" if content else ""))
    return "\n" + "\n".join(parts) + "\n"


def effects() -> str:
    """Each effect with its parameters and its cost."""
    from stretch_bt.simulation.effects import registry

    content = []
    for name, cls in registry().items():
        options = [f"{row[0]} {row[1]}: {row[2]}" for row in fields_of(cls.Parameters, "")]
        cost = f"{cls.cost_ms:g} ms a {cls.cost_per}"
        content.append([code(name), cls.group, first_paragraph(cls), "; ".join(options), cost])
    return rows(["effect", "of the", "what it is", "parameters", "about"], content)


def presets() -> str:
    """What each camera preset adds."""
    from stretch_bt.simulation.camera.presets import PRESETS

    content = []
    for name, chosen in PRESETS.items():
        for effect, given in chosen.items():
            fields = [(k, f) for k, f in type(given).model_fields.items() if getattr(given, k) is not None]
            values = [f"{code(key)} {show_default(field, getattr(given, key))}" for key, field in fields]
            content.append([code(name), code(effect), ", ".join(values)])
    return rows(["camera", "effect", "with"], content)


def scenes() -> str:
    """The shipped scenes."""
    from stretch_bt.simulation.scene import load_scene, scene_names

    content = []
    for name in scene_names():
        read = load_scene(name)
        content.append([code(name), read.object.type, code(read.fidelity), " ".join(read.doc.split())])
    return rows(["scene", "object", "fidelity", "what it is, and what in it is assumed"], content)


def first_paragraph(cls: Any) -> str:
    """Return the first paragraph of a docstring on one line."""
    return " ".join((cls.__doc__ or "").split("\n\n")[0].split())


def cell() -> str:
    """The fields of a cell file, without the options of the implementations."""
    from stretch_bt.hardware import cell_file

    return file_table(cell_file._CellFile, skip=("devices",))


def implementations() -> str:
    """The options of each implementation of a device."""
    from stretch_bt.hardware.implementations import SHIPPED, driver_class

    parts = []
    for kind, use in SHIPPED:
        cls = driver_class(kind, use)
        doc = first_paragraph(cls)
        content = list(fields_of(cls.Options, "", ("type", "use")))
        table = rows(OPTION, content) if content else "It has no options.\n"
        parts.append(f"#### {kind}, `use: {use}`\n\n{doc}\n\n{table}")
    return "\n" + "\n".join(parts) + "\n"


def planted_faults() -> str:
    """The faults planted in copies of the example drivers, and the clause that finds each."""
    sys.path.insert(0, str(ROOT / "benchmarks"))
    try:
        found = import_module("planted_faults").FAULTS
    finally:
        sys.path.remove(str(ROOT / "benchmarks"))
    return rows(
        ["fault", "in the driver", "found by"], [[f.name, f.package.parent.name, code(f.clause)] for f in found]
    )


def stand_ins() -> str:
    """The faults of each stand-in."""
    from stretch_bt.hardware.emulators.registry import STAND_INS, stand_in_class

    classes = {name: stand_in_class(name) for name in STAND_INS}
    ports = "".join(
        f"- `{name}`: {first_paragraph(cls)} Ports: {', '.join(f'{w} {p}' for w, p in cls.PORTS.items())}.\n"
        for name, cls in classes.items()
    )
    content: dict[tuple[str, str], list[str]] = {}
    for name, cls in classes.items():
        for key, fault in cls.FAULTS.items():
            words = {k: " or ".join(v) for k, v in fault.choices.items()}
            numbers = {k: f"{v:g}" for k, v in fault.parameters.items()}
            defaults = ", ".join(f"`{k}`: {v}" for k, v in {**numbers, **words}.items())
            content.setdefault((key, fault.doc + (f" ({defaults})" if defaults else "")), []).append(name)
    faults = [[code(key), ", ".join(code(n) for n in names), doc] for (key, doc), names in content.items()]
    return f"\n{ports}\n{rows(['fault', 'of', 'the stand-in'], faults)}\n"


def gripper_faults() -> str:
    """The fault codes of the gripper."""
    from stretch_bt.hardware.robotiq.registers import FAULTS

    content = [[code(f"{number:02X}"), fault.means, fault.remedy] for number, fault in FAULTS.items()]
    return rows(["code", "it means", "what to do"], content)


def file_table(model: Any, skip: tuple[str, ...] = ()) -> str:
    """Return the fields of a pydantic model, nested ones with their path."""
    return rows(["field", "default", "meaning"], list(fields_of(model, "", skip)))


def fields_of(model: Any, prefix: str, skip: tuple[str, ...] = ()) -> Iterator[list[str]]:
    """Yield a row for each field."""
    from pydantic import BaseModel

    for name, field in model.model_fields.items():
        if name in skip:
            continue
        inner = [a for a in variants(field.annotation) if isinstance(a, type) and issubclass(a, BaseModel)]
        own = not inner or any(a is str for a in variants(field.annotation))
        if own or field.is_required():
            yield [code(f"{prefix}{name}"), default_of(field), meaning(field)]
        found = merged([list(fields_of(variant, f"{prefix}{name}.")) for variant in inner])
        given = getattr(field.default, "model_fields_set", None)
        yield from (with_default(row, field.default, f"{prefix}{name}.") if given else row for row in found)


def merged(tables: list[list[list[str]]]) -> list[list[str]]:
    """Return the rows of the variants of a union as one list; a row of some of them says of which."""
    names = {row[0]: None for table in tables for row in sorted(table, key=lambda row: not row[0].endswith(".type`"))}
    found = []
    for name in names:
        same = [(row, table) for table in tables for row in table if row[0] == name]
        texts = dict.fromkeys(row[2] for row, _ in same)
        of = [next(r[2] for r in table if r[0].endswith(".type`")) for _, table in same if len(same) < len(tables)]
        note = [f"of {', '.join(of)}"] if of else []
        found.append([name, same[0][0][1], "; ".join(text for text in [*note, ", ".join(texts)] if text)])
    return found


def with_default(row: list[str], whole: Any, prefix: str) -> list[str]:
    """Return the row of a nested field with the default that the outer field gives it, which goes where a file names another."""
    name = row[0].strip("`").removeprefix(prefix)
    field = type(whole).model_fields.get(name)
    if field is None:
        return row
    value = getattr(whole, name)
    alone = "" if field.is_required() or value == field.default else f", unless the file has {code(prefix.rstrip('.'))}"
    return [row[0], show_default(field, value) + alone, row[2]]


def variants(annotation: Any) -> list[Any]:
    """Return the types that an annotation allows."""
    import typing

    origin, args = typing.get_origin(annotation), typing.get_args(annotation)
    if origin is typing.Annotated:
        return variants(args[0])
    if args and origin is not typing.Literal and origin not in (list, dict, tuple):
        return [v for a in args for v in variants(a)]
    return [annotation]


def default_of(field: Any) -> str:
    """Return the default of a field as a file would have it."""
    return "required" if field.is_required() else show_default(field, field.default)


def show_default(field: Any, value: Any) -> str:
    """Return a value as a file would have it."""
    from stretch_bt.units import Kind
    from stretch_bt.within import Within

    kinds = [m for m in metadata(field) if isinstance(m, Kind)]
    if value is None:
        return "none"
    if any(m.percent for m in metadata(field) if isinstance(m, Within)):
        return code(f"{100 * value:g} %")
    if isinstance(value, bool):
        return code(str(value).lower())
    if isinstance(value, list):
        return code(json.dumps(value))
    if value == {}:
        return "none"
    return code(shown(value, kinds[0] if kinds else None)) if value != "" else "empty"


def metadata(field: Any) -> list[Any]:
    """Return what is annotated to a field, also inside an optional."""
    import typing

    found = list(field.metadata)
    for part in (field.annotation, *typing.get_args(field.annotation)):
        found += typing.get_args(part)[1:] if typing.get_origin(part) is typing.Annotated else ()
    return found


def meaning(field: Any) -> str:
    """Return the description of a field with what it may hold."""
    from stretch_bt.units import Kind
    from stretch_bt.within import Within

    marks = metadata(field)
    kinds = [m for m in marks if isinstance(m, Kind)]
    parts = [field.description] if field.description else []
    for within in (m for m in marks if isinstance(m, Within)):
        ends = [end for end in (within.min, within.max) if math.isfinite(end)]
        texts = [f"{100 * end:g} %" if within.percent else shown(end, kinds[0] if kinds else None) for end in ends]
        parts += [" to ".join(texts)] if texts else []
    options = [str(a) for v in variants(field.annotation) for a in getattr(v, "__args__", ()) if isinstance(a, str)]
    parts += [", ".join(code(o) for o in options)] if options else []
    return "; ".join(parts)


# --- diagnostics


#: names of functions that make a diagnostic of a code which they are given
MAKERS = ("error", "warning", "refuse", "_refuse", "_error", "Diagnostic", "ExpressionError")


def codes_in_source() -> set[str]:
    """Return every diagnostic code that the package can give."""
    found: set[str] = set()
    called = re.compile(rf"\b({'|'.join(('resolve', *MAKERS))})\s*\(")
    for text in filter(called.search, (path.read_text("utf-8") for path in PACKAGE.rglob("*.py"))):
        for call in ast.walk(ast.parse(text)):
            if isinstance(call, ast.Call):
                found |= set(code_of(call))
    return found


def code_of(call: ast.Call) -> Iterator[str]:
    """Yield the code that a call makes a diagnostic with."""
    name = call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")
    texts = [a.value for a in call.args if isinstance(a, ast.Constant) and isinstance(a.value, str)]
    if name == "resolve" and texts:
        yield f"{texts[-1]}-unknown"
    elif name in MAKERS:
        yield from [t for t in texts if re.fullmatch(r"[a-z]+(-[a-z]+)*", t) and t not in ("error", "warning")][:1]


def mistakes() -> list[dict[str, Any]]:
    """Return the small mistakes."""
    return list(yaml.safe_load(Path(__file__).with_name("mistakes.yaml").read_text("utf-8")))


def made_in(folder: Path, mistake: dict[str, Any]) -> Diagnostic:
    """Make a mistake in an empty folder, which must be the working directory, and return what is said of it."""
    write_mistake(folder / "given.yaml", mistake)
    for name, text in mistake.get("beside", {}).items():
        (folder / name).write_text(text)
    for name, text in mistake.get("record", {}).items():
        (folder / "given").mkdir(exist_ok=True)
        (folder / "given" / name).write_text(text)
    found = findings(mistake)
    return next(d for d in found if d.code == mistake["code"])


def write_mistake(path: Path, mistake: dict[str, Any]) -> None:
    """Write the file that a mistake is in."""
    made = {
        "LARGE": "# " + "x" * 2_000_000,
        "NESTED": "[" * 200 + "]" * 200,
        "MANY": "a: [" + "1, " * 60_000 + "1]",
    }
    deep = "[" * 110 + "{wait: {duration: 1 s}}" + "]" * 110
    for kind in FORMATS:
        if kind in mistake:
            body = f"trees: {{main: {{sequence: {deep}}}}}\n" if mistake[kind] == "DEEP" else mistake[kind]
            path.write_text(f"format: stretch-{kind}/1\n{body}")
    if mistake.get("text") == "LOOP":
        path.symlink_to(path.name)
    elif mistake.get("text") == "PIPE":
        os.mkfifo(path)
    elif "text" in mistake:
        path.write_text(made.get(mistake["text"], mistake["text"]))
    elif mistake.get("folder"):
        path.mkdir()


def findings(mistake: dict[str, Any]) -> list[Diagnostic]:
    """Return what the mistake's command says."""
    from stretch_bt.runtime.check import check
    from stretch_bt.runtime.replay import replay
    from stretch_bt.runtime.report import write_report
    from stretch_bt.runtime.task import run
    from stretch_bt.sweep import sweep

    commands: dict[str, Callable[[], Any]] = {
        "check": lambda: check("given.yaml", cell=mistake.get("against")),
        "run": lambda: run("given.yaml", params=mistake.get("set"), **mistake.get("arguments", {})),
        "replay": lambda: replay("given"),
        "sweep": lambda: sweep("given.yaml", out="given", resume=True),
        "report": lambda: write_report(run("given.yaml").record, Path("no/folder/report.html")),
    }
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (mistake.get("disk", before[0]), before[1]))
    try:
        return list(commands[mistake.get("command", "check")]())
    except FileError as error:
        return error.diagnostics
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def codes() -> str:
    """Every code with a message."""
    content = []
    here = Path.cwd()
    for mistake in sorted(mistakes(), key=lambda m: m["code"]):
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            try:
                found = made_in(Path(folder), mistake)
            finally:
                os.chdir(here)
        text = f"{found.message}; {found.hint}" if found.hint else found.message
        content.append([code(found.code), text])
    return rows(["code", "an example of what it says"], content)


# --- hard cases


def hard_cases() -> str:
    """Every hard case by its domain and by why it is hard, with what must come of it."""
    from stretch_bt.hardcases import DOMAINS, cases
    from stretch_bt.hardcases.registry import about

    parts = []
    for domain in DOMAINS:
        found = list(cases(domain).values())
        parts.append(f"## {domain}\n\n{about(domain)} {len(found)} cases.\n")
        for why in dict.fromkeys(hard.why for hard in found):
            content = [[named_case(hard), hard.expect.says] for hard in found if hard.why == why]
            parts.append(f"{why[0].upper()}{why[1:]}.\n\n{rows(['case', 'must end with'], content)}")
    return "\n" + "\n".join(parts) + "\n"


def named_case(hard: Any) -> str:
    """Return the name of a case, and whether it is one of the slow ones."""
    return f"{hard.name} (slow)" if hard.costly else str(hard.name)


def hard_elsewhere() -> str:
    """The tests marked `hard`: hard cases that change code, signals or processes, and so are not in the catalogue."""
    content = []
    for path in sorted((ROOT / "tests").rglob("test_*.py")):
        text = path.read_text("utf-8")
        if "mark.hard" not in text:
            continue
        tree, file = ast.parse(text), path.relative_to(ROOT).as_posix()
        if any(isinstance(node, ast.Assign) and "mark.hard" in ast.unparse(node) for node in tree.body):
            content.append([code(file), (ast.get_docstring(tree) or "").split("\n\n")[0]])
            continue
        for node in tree.body:
            if isinstance(node, ast.FunctionDef) and any("mark.hard" in ast.unparse(d) for d in node.decorator_list):
                said = ast.get_docstring(node) or node.name.removeprefix("test_").replace("_", " ")
                content.append([code(f"{file}::{node.name}"), said.split("\n\n")[0]])
    return rows(["test", "what it is"], content)


# --- shipped trees


def shipped_trees() -> str:
    """Each shipped tree with what it takes and what it gives."""
    from stretch_bt.tree.program import load_program, shipped_trees

    parts = []
    for name in shipped_trees():
        document = load_program(name).require().document
        main = document.trees["main"]
        uses = ", ".join(code(device.interface.__name__) for device in document.devices.values())
        head = f"### {name}\n\n{document.doc} Uses: {uses}. On the twin by default: the scene `{document.scene.text}`."
        given = [
            [
                code(p.name),
                p.type.name,
                shown(p.value, p.type.kind),
                bounds(*(shown(b, p.type.kind) if b is not None else "" for b in (p.min, p.max))),
                p.doc,
            ]
            for p in document.params.values()
        ]
        got = [[code(out.name), out.type.name, out.unit or "", out.doc] for out in main.outs.values()]
        parts.append(
            f"{head}\n\n{rows(['output', 'type', 'unit', 'meaning'], got)}\n{rows(['param', 'type', 'default', 'bounds', 'meaning'], given)}"
        )
    return "\n" + "\n".join(parts) + "\n"


TABLES: dict[str, Callable[[], str]] = {
    "nodes": nodes,
    "shipped-trees": shipped_trees,
    "types": types,
    "objects": objects,
    "readings": readings,
    "scene": scene,
    "kinds": kinds,
    "effects": effects,
    "presets": presets,
    "scenes": scenes,
    "cell": cell,
    "implementations": implementations,
    "planted-faults": planted_faults,
    "stand-ins": stand_ins,
    "gripper-faults": gripper_faults,
    "codes": codes,
    "hard-cases": hard_cases,
    "hard-elsewhere": hard_elsewhere,
}


def renewed(text: str) -> str:
    """Return a page with its tables made anew."""
    return MARKED.sub(lambda match: match[1] + TABLES[match[2]]() + match[3], text)


def picture() -> str:
    """Return the picture that the README shows."""
    from stretch_bt.tree.export import export
    from stretch_bt.tree.program import load_program

    return export(load_program("palpate_stiffness").require(), "svg")


if __name__ == "__main__":
    (PAGES / "palpate_stiffness.svg").write_text(picture(), encoding="utf-8")
    for page in sorted(PAGES.glob("*.md")):
        page.write_text(renewed(page.read_text("utf-8")), encoding="utf-8")
