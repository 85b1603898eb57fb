"""The items of a sweep: one `Spec` for each tree, scene, combination of params, and seed."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

from stretch_bt.errors import InvalidInput
from stretch_bt.hardware.imported_texts import digest_of_file
from stretch_bt.runtime.provenance import driver_modules, own_modules
from stretch_bt.runtime.sweep_check import CheckedSweep
from stretch_bt.source import Scalar
from stretch_bt.sweep.bundle import Bundle
from stretch_bt.sweep.package_digest import package_digest
from stretch_bt.sweep.spec import Spec
from stretch_bt.tree.program import Program
from stretch_bt.tree.values import written

__all__ = ["Items", "items_of"]

Digests = Mapping[str, str]


@dataclass(frozen=True, slots=True)
class _Named:
    """A tree, a scene or a cell: its name, what a run takes for it, and the digests of its files."""

    text: str
    given: str
    digests: Digests


class Items:
    """The items of a sweep that was found right, in the order of its file; seeds turn fastest.

    Each is made when it is asked for: a million of them need no memory.
    """

    def __init__(self, checked: CheckedSweep) -> None:
        self._file = checked.file
        self._bundle = Bundle(self._file.folder)
        self._trees = [self._tree(name, checked.programs[name.text]) for name in self._file.trees]
        self._scenes = [self._named(name) for name in self._file.scenes]
        self._own_scenes = {t.text: self._own_scene(checked.programs[t.text]) for t in self._trees}
        self._cell = None if self._file.cell is None else self._of_cell(self._file.cell)
        texts = {name: [written(value) for value in values] for name, values in self._file.choices.items()}
        self._choices = {
            name: [(text, self._bundle.add_named(text)) for text in values] for name, values in texts.items()
        }
        self._files, self._home = self._bundle.layout()
        self._origin = str(self._bundle.above.resolve())

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self._file)

    def __iter__(self) -> Iterator[Spec]:
        """Yield each item."""
        for tree in self._trees:
            scenes: list[_Named | None] = [*self._scenes] or [self._own_scenes[tree.text]]
            for scene in scenes:
                for choice in product(*self._choices.values()):
                    params = dict(zip(self._choices, choice, strict=True))
                    for seed in self._file.seeds:
                        yield self._spec(tree, scene, params, seed)

    def _spec(self, tree: _Named, scene: _Named | None, params: Mapping[str, tuple[str, Digests]], seed: int) -> Spec:
        file = self._file
        key = {
            "tree": [tree.text, tree.digests],
            "scene": None if scene is None else [scene.text, scene.digests],
            "cell": None if self._cell is None else [self._cell.text, self._cell.digests],
            "params": params,
            "tolerance": file.tolerance,
            "seed": seed,
            "source": package_digest(),
        }
        return Spec(
            key=_digest(key),
            tree=tree.given,
            scene=None if scene is None else scene.given,
            scene_name=None if scene is None else scene.text,
            cell=None if self._cell is None else self._cell.given,
            seed=seed,
            params={name: text for name, (text, _) in params.items()},
            tolerance=file.tolerance,
            limit=file.limit,
            record=file.record,
            files=self._files,
            home=self._home,
            source=package_digest(),
            origin=self._origin,
        )

    def _named(self, name: Scalar, modules: Mapping[str, Mapping[str, str | None]] | None = None) -> _Named:
        return self._placed(name.text, self._file.place(name), modules)

    def _placed(self, text: str, place: str, modules: Mapping[str, Mapping[str, str | None]] | None = None) -> _Named:
        """Return what is known of a file, or of a shipped one, with the digests of the Python modules that it brings."""
        _check_unchanged(modules or {})
        digests = {f"module {name}": str(about["sha256"]) for name, about in (modules or {}).items()}
        if not Path(place).is_file():
            return _Named(text, place, digests)
        path = Path(place).absolute()
        beside = [Path(str(about["file"])) for about in (modules or {}).values()]
        for module in beside:
            if module.is_relative_to(path.parent.resolve()):
                self._bundle.add(path.parent / module.relative_to(path.parent.resolve()))
        return _Named(text, self._bundle.name(path), {**self._bundle.add(path), **digests})

    def _tree(self, name: Scalar, program: Program) -> _Named:
        return self._named(name, own_modules(program))

    def _own_scene(self, program: Program) -> _Named | None:
        """Return the scene that a tree names, which counts where the sweep names none."""
        document = program.document
        if document.scene is None or document.scene_path is None:
            return None
        return self._placed(document.scene.text, document.scene_path)

    def _of_cell(self, name: Scalar) -> _Named:
        from stretch_bt.hardware.cell_file import load_cell

        return self._named(name, driver_modules(load_cell(self._file.place(name))))


def items_of(checked: CheckedSweep) -> Items:
    """Return the items of a sweep.

    Raises
    ------
    SweepError
        The file or a file that it names is wrong.
    InvalidInput
        The files are too large to be handed around, or a Python module was changed after this process imported it.
    """
    return Items(checked.require())


def _check_unchanged(modules: Mapping[str, Mapping[str, str | None]]) -> None:
    """Refuse modules whose files were changed since: the key would be of a text that nothing here runs."""
    for about in modules.values():
        if digest_of_file(Path(str(about["file"]))) != about["sha256"]:
            what = f"{about['file']} was changed after this process imported it"
            raise InvalidInput(f"{what}; restart Python, and run the sweep again")


def _digest(content: Any) -> str:
    text = json.dumps(content, sort_keys=True, ensure_ascii=False, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()[:32]
