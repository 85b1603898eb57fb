"""One item of a sweep as it is handed to a worker, and the rows that it may come to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from stretch_bt.runtime.record.folder import Kept
from stretch_bt.sweep.job import Ran

if TYPE_CHECKING:
    from stretch_bt.runtime.result import RunResult

__all__ = ["AGAIN", "KILLED", "TIMED_OUT", "Spec"]

#: statuses of a row that are no status of a run: its process died, or its limit of wall time passed
KILLED, TIMED_OUT = "killed", "timed_out"
#: rows that say nothing of the item itself, so that it is run again
AGAIN = (KILLED, TIMED_OUT)
#: fields that a row takes over from the result of a run
_OF_RESULT = ("outputs", "truth", "ticks", "task_seconds", "wall_seconds", "cpu_seconds")


@dataclass(frozen=True, slots=True)
class Spec:
    """An item, whole: names and the content of files, no path that is opened, so that a process anywhere can run it.

    Parameters
    ----------
    key
        Digest of everything that the row depends on.
    tree, scene, cell
        Shipped names, or files among `files`, relative to `home`.
    scene_name
        What the row calls the scene: as the sweep file or the tree names it.
    params
        Text by name, as `--set` takes it.
    tolerance
        SI number by the name of a result, as `run` takes it.
    limit
        Wall time, s, after which the run is stopped at its next tick.
    files
        Content by path, all below one folder.
    home
        The folder among them that names are relative to.
    source
        Digest of the package that the key was made with.
    origin
        The folder, on the machine of the sweep, that holds `files`: a record names it, for a replay finds modules there.
    """

    key: str
    tree: str
    scene: str | None
    scene_name: str | None
    cell: str | None
    seed: int
    params: Mapping[str, str]
    tolerance: Mapping[str, float]
    limit: float | None
    record: Kept
    files: Mapping[str, bytes]
    home: str
    source: str
    origin: str

    def row(
        self, status: str, reason: str, result: RunResult | None = None, worker: str | None = None
    ) -> dict[str, Any]:
        """Return a row of this item; without a result, of a run that never ticked."""
        from stretch_bt.runtime.result import RunResult

        plain = (result or RunResult.without_ticks(status, reason, None)).to_json()
        return {
            "key": self.key,
            "tree": self.tree,
            "scene": self.scene_name,
            "seed": self.seed,
            "set": dict(self.params),
            "status": status,
            "reason": reason,
            **{name: plain[name] for name in _OF_RESULT},
            "worker": worker,
        }

    def run(self) -> Ran:
        """Return what comes of it, as `run_item` does."""
        from stretch_bt.sweep.run_item import run_item

        return run_item(self)

    def killed(self) -> Ran:
        """Return what is known of an item whose process died of it."""
        return Ran(self.row(KILLED, "its process died while it ran"))
