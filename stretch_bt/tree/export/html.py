"""A page that stands alone: the drawing, what a run can be given and gives back, and the nodes that it uses."""

from __future__ import annotations

import inspect
from collections.abc import Iterable

from stretch_bt.tree.cell import MISSING
from stretch_bt.tree.document import Declared
from stretch_bt.tree.export.escape import xml
from stretch_bt.tree.export.headings import documents, facts, rows
from stretch_bt.tree.export.style import colour
from stretch_bt.tree.export.svg import drawing
from stretch_bt.tree.flow import Leaf
from stretch_bt.tree.node_description import describe
from stretch_bt.tree.node_info import NodeInfo
from stretch_bt.tree.program import Program
from stretch_bt.tree.schema.nodes import as_text

__all__ = ["write"]

_STYLE = """
:root{--ink:#1c2430;--soft:#5b6675;--line:#e3e7ec}
body{margin:0;background:#f5f6f8;color:var(--ink);font:14px/1.5 system-ui,-apple-system,"Segoe UI",Roboto,sans-serif}
main{max-width:1640px;margin:0 auto;padding:28px 20px 40px}
header,section{background:#fff;border:1px solid var(--line);border-radius:8px;padding:16px 20px;margin:0 0 14px}
h1{font-size:22px;margin:0 0 4px}h2{font-size:15px;margin:0 0 10px}h3{font-size:14px;margin:18px 0 2px}
h3 small{font-weight:500;color:#fff;border-radius:20px;padding:2px 9px;margin-left:8px;font-size:11px}
p{margin:4px 0;max-width:80ch}.facts{color:var(--soft);max-width:none}.facts b{color:var(--ink);font-weight:600;margin-right:18px}
.scroll{overflow:auto}svg{display:block}
table{border-collapse:collapse;margin-top:4px}
th{font-weight:600;color:var(--soft);font-size:12px;text-align:left}
th,td{padding:4px 16px 4px 0;border-bottom:1px solid var(--line);vertical-align:top;max-width:80ch}
tr:last-child td{border-bottom:0}td:first-child{font:12.5px ui-monospace,SFMono-Regular,Menlo,Consolas,monospace}
@media print{body{background:#fff}}
"""


def write(program: Program) -> str:
    """Return the page."""
    document = program.document
    named = "".join(f"{xml(name)} <b>{xml(text)}</b>" for name, text in facts(document).items())
    head = f"<header><h1>{xml(document.file)}</h1><p>{xml(document.doc)}</p><p class='facts'>{named}</p></header>"
    sections = [
        _section("Tree", f'<div class="scroll">{drawing(program, titled=False)}</div>'),
        _section("Parameters", _declared((d.params.values(), d.prefix, "") for d in documents(document))),
        *(_tree(program, name) for name in document.trees),
        _section("Nodes", "".join(_node(info) for info in _used(program))),
    ]
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{xml(document.file)}</title>'
        f'<meta name="viewport" content="width=device-width, initial-scale=1"><style>{_STYLE}</style></head>'
        f"<body><main>{head}{''.join(sections)}</main></body></html>\n"
    )


def _section(title: str, content: str) -> str:
    return f"<section><h2>{xml(title)}</h2>{content}</section>" if content else ""


def _tree(program: Program, name: str) -> str:
    signature = program.document.trees[name]
    doc = f"<p>{xml(signature.doc)}</p>" if signature.doc else ""
    tables = (
        ("input", signature.ins),
        ("input and output", signature.inouts),
        ("output", signature.outs),
        ("own key", signature.keys),
    )
    return _section(f"Tree {name}", doc + _declared((table.values(), "", role) for role, table in tables))


def _declared(groups: Iterable[tuple[Iterable[Declared], str, str]]) -> str:
    """Return one table of declarations, given with a prefix and what they are."""
    found = [(row[0], role, *row[1:]) for declared, prefix, role in groups for row in rows(declared, prefix)]
    return _table(("name", "", "type", "value", "bounds", "meaning"), found) if found else ""


def _table(titles: tuple[str, ...], body: Iterable[Iterable[str]]) -> str:
    """Return a table without its empty columns."""
    lines = [list(row) for row in body]
    kept = [i for i in range(len(titles)) if any(line[i] for line in lines)]
    head = "".join(f"<th>{titles[i]}</th>" for i in kept)
    cells = ("".join(f"<td>{xml(line[i])}</td>" for i in kept) for line in lines)
    return f"<table><tr>{head}</tr>{''.join(f'<tr>{row}</tr>' for row in cells)}</table>"


def _used(program: Program) -> list[NodeInfo]:
    found = {p.info.name: p.info for body in program.bodies.values() for p in body.parts() if isinstance(p, Leaf)}
    return [found[name] for name in sorted(found)]


def _node(info: NodeInfo) -> str:
    kind = f'<small style="background:{colour(info.cls.kind)}">{xml(info.cls.kind)}</small>'
    paragraphs = "".join(f"<p>{xml(text)}</p>" for text in (inspect.getdoc(info.cls) or "").split("\n\n"))
    return f"<h3>{xml(info.name)}{kind}</h3>{paragraphs}{_ports(info)}"


def _ports(info: NodeInfo) -> str:
    about = describe(info)
    inputs = [
        (p["name"], p["type"], way, "required" if p["required"] else _default(info, p["name"]), p["doc"])
        for way, key in (("in", "inputs"), ("in and out", "inouts"))
        for p in about[key]
    ]
    outputs = [(p["name"], p["type"], "out", "", p["doc"]) for p in about["outputs"]]
    devices = [(p["name"], p["type"], "device", "" if p["required"] else "optional", "") for p in about["devices"]]
    return _table(("port", "type", "", "default", "meaning"), [*inputs, *outputs, *devices])


def _default(info: NodeInfo, name: str) -> str:
    default = info.ports[name].default
    return "" if default is None or default is MISSING else as_text(default, info.types[name])
