"""Counts and CPU times of a world's work and of each effect that is on."""

from __future__ import annotations

from typing import Any

from stretch_bt.simulation.world import World

__all__ = ["account"]

#: where the work of a group of effects is done; its time cannot be separated from the rest
_WITHIN = {"membrane": "solve", "object": "contact"}


def account(world: World) -> list[dict[str, Any]]:
    """Return a row for all that was done, the dearest first, and one for each effect that is on.

    A row holds `name`, `group` (`twin`, or the effect's group), `count`, `cpu_seconds`, and `within`: an effect that changes an
    equation is solved with the others in it, so that it has no time of its own, but a part of the time of `within`.
    """
    groups = {effect.name: effect.group for effect in world.effects}
    rows = [{**row, "group": groups.get(row["name"], "twin"), "within": None} for row in world.stats.to_json()]
    timed = {row["name"] for row in rows}
    for name, group in groups.items():
        if name not in timed:
            within = _WITHIN.get(group)
            count = world.stats.counts.get(within, 0) if within else 0
            seconds = None if within else 0.0
            rows.append({"name": name, "group": group, "count": count, "cpu_seconds": seconds, "within": within})
    return rows
