"""What a run was made from and on: own modules of nodes, scene and cell, processor and kernels."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stretch_bt.hardware.imported_texts import imported_digest, stands_in
from stretch_bt.runtime.record.places import Places, usual_folders
from stretch_bt.source import Map, Scalar
from stretch_bt.threads import kernels
from stretch_bt.tree.document import Document
from stretch_bt.tree.program import Program

if TYPE_CHECKING:
    from stretch_bt.hardware.cell_file import CellSpec
    from stretch_bt.simulation.scene import Scene

__all__ = ["choice_of", "driver_modules", "effects_on", "machine", "others", "own_modules", "places_of", "processor"]

#: names of the program that this process was started with: a tree that imports its file has it under another one
_PROGRAMS = ("__main__", "__mp_main__")


def own_modules(program: Program, origin: Path | None = None) -> dict[str, dict[str, str | None]]:
    """Return file, digest and commit of each Python module of nodes that a tree brings.

    The other modules of their packages and of the tree's folder that were imported count too. `origin` is the tree file
    beside which they stand, where the program was read from a copy.
    """
    tops = {name.partition(".")[0] for name in _named(program.document)} - {"py_trees"}  # whose version is noted
    tree = origin or program.document.path
    return _imported(tops, tree.resolve().parent if tree and tops else None)


def driver_modules(spec: CellSpec | None) -> dict[str, dict[str, str | None]]:
    """Return the same of the modules of drivers that are not shipped, which a cell brings; a replay needs none of them."""
    if spec is None:
        return {}
    drivers = [device.implementation for device in spec.devices.values() if not device.implementation.shipped]
    tops = {*spec.imports, *(found.cls.__module__.partition(".")[0] for found in drivers)}
    return _imported(tops, spec.path.resolve().parent if spec.imports else None)


def _imported(tops: set[str], home: Path | None) -> dict[str, dict[str, str | None]]:
    """Return what is known of the imported modules of some packages, and of all modules in packages that stand in a folder.

    The latter may be imported later, as by a node in its first tick. A script beside the tree is no module of it.
    """
    if not tops and home is None:
        return {}
    files, beside = dict[str, Path](), set[str]()
    for name, module in sorted(sys.modules.items()):
        file, top = str(getattr(module, "__file__", None) or ""), name.partition(".")[0]
        if not file.endswith(".py") or name in _PROGRAMS:
            continue
        stands = home is not None and home.name.casefold() in file.casefold() and stands_in(Path(file), home, top)
        if stands or top in tops:
            files[name] = Path(file)
        if stands:
            beside.add(top)
    if home is not None:
        for path in (path for top in sorted(beside) for path in sorted((home / top).rglob("*.py"))):
            parts = path.relative_to(home).with_suffix("").parts
            files.setdefault(".".join(parts[:-1] if parts[-1] == "__init__" else parts), path)
    commits = {folder: _commit(folder) for folder in {file.parent for file in files.values()}}
    return {
        name: {"file": str(file), "sha256": imported_digest(name, file), "commit": commits[file.parent]}
        for name, file in sorted(files.items())
    }


def _named(document: Document) -> Iterator[str]:
    """Yield the Python modules that a tree file and those that it imports name."""
    table = document.root.get("imports")
    for key in document.modules:
        target = table.get(key) if isinstance(table, Map) else None
        if isinstance(target, Scalar):
            yield target.text
    for imported in document.imports.values():
        yield from _named(imported)


def _commit(folder: Path) -> str | None:
    """Return the commit that is checked out where a folder lies, or None where git knows none."""
    command = ["git", "-C", str(folder), "rev-parse", "HEAD"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=2, check=False)  # noqa: S603
    except (OSError, subprocess.TimeoutExpired):
        return None
    return done.stdout.strip() if done.returncode == 0 else None


def others(recorded: Mapping[str, Any], program: Program, installed: Mapping[str, str]) -> list[str]:
    """Return where a replay runs something else than run.json says: versions of packages, and modules of nodes."""
    before: Mapping[str, str] = recorded.get("versions") or {}
    found = [
        f"{name} {installed[name]} (recorded with {before[name]})"
        for name in before
        if name in installed and installed[name] != before[name]
    ]
    present, modules = own_modules(program, Path(recorded["tree"])), recorded.get("modules")
    if not isinstance(modules, dict):
        return found
    for name in sorted(present.keys() | modules.keys()):
        old, new = modules.get(name), present.get(name)
        if old is None or new is None:
            found.append(f"module {name} ({'recorded without it' if old is None else 'not imported now'})")
        elif old["sha256"] != new["sha256"]:
            found.append(f"module {name}, {new['file']}{_commits(old['commit'], new['commit'])}")
    return found


def _commits(old: str | None, new: str | None) -> str:
    return f" (recorded at commit {old}, now at {new})" if old != new else " (its text is another than recorded)"


def effects_on(scene: Scene | None) -> list[str]:
    """Return the effects that the twin of a scene has on."""
    if scene is None:
        return []
    from stretch_bt.simulation.advisor.advise import advise

    return [verdict.name for verdict in advise(scene) if verdict.on]


def choice_of(scene: Scene | None) -> dict[str, Any] | None:
    """Return what the advisor chose for a scene, with its prediction and cost; None without a scene."""
    if scene is None:
        return None
    from stretch_bt.simulation.advisor.choose import choose
    from stretch_bt.simulation.advisor.told import to_json

    return to_json(scene, choose(scene))


def places_of(spec: CellSpec | None, tree: Path | None = None) -> Places:
    """Return what the log of a run leaves out: addresses of the cell's devices, and folders that messages may name."""
    options = [] if spec is None else [device.options.given() for device in spec.devices.values()]
    hosts = [host for option in options if isinstance(host := getattr(option, "host", None), str)]
    files = [file for file in (tree, None if spec is None else spec.path) if file is not None]
    folders = [*(str(file.resolve().parent) for file in files), *usual_folders()]
    return Places(hosts, sorted(folders, key=len, reverse=True))


def machine(compiled: bool) -> dict[str, Any]:
    """Return the processor and the libraries on it, on which the last digits depend; numba's part only where code is compiled."""
    extensions = np.show_config(mode="dicts")["SIMD Extensions"]
    return {
        "processor": processor(),
        "architecture": platform.machine(),
        "cores": os.cpu_count(),
        "blas": kernels(),
        "numpy_features": [*extensions.get("baseline", []), *extensions.get("found", [])],  # an empty one is left out
        "numba_cpu": _numba_cpu() if compiled else None,
    }


def processor() -> str:
    """Return the model name of the processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text("utf-8").splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


def _numba_cpu() -> str:
    """Return the processor that numba compiles for."""
    from llvmlite.binding import get_host_cpu_name  # type: ignore[import-untyped]

    return os.environ.get("NUMBA_CPU_NAME") or str(get_host_cpu_name())
