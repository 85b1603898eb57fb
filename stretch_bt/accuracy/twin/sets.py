"""The costs of sets of effects in the twin, and the differences of their results from a run with all effects of the scene."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache, partial
from typing import NamedTuple

from stretch_bt.accuracy.job import Job
from stretch_bt.accuracy.points import FAILED, REFERENCE, Answer, Setting
from stretch_bt.accuracy.twin.judge import RELATIVE, price
from stretch_bt.accuracy.twin.ledger import Ledger, Runs
from stretch_bt.errors import NoAnswer
from stretch_bt.simulation.advisor.advise import advise
from stretch_bt.simulation.scene import Scene, load_scene

__all__ = ["DEAR", "SETS", "apart", "jobs", "small_jobs"]

EVERYTHING, AUTO = "everything", "auto"
DEAR = ("friction", "mullins")  # which remember, so that every press on the way has to be solved
CHEAP = "all but friction and softening"
SETS = (EVERYTHING, AUTO, CHEAP, "least", "nothing")


class Study(NamedTuple):
    """A scene, its paired seeds, and CPU seconds of a run with everything on and of any other."""

    scene: str
    seeds: int
    everything: float
    other: float


STUDIES = (
    Study("calibration_sphere", 3, 5.0, 0.6),
    Study("calibration_cylinder", 3, 5.0, 1.0),
    Study("wooden_cube", 3, 6.0, 1.3),
    Study("wooden_half_cylinder", 3, 12.0, 0.5),
    Study("wooden_prism", 3, 10.0, 2.0),
    Study("glass_snowman", 3, 13.0, 1.2),
    Study("paper_cube", 2, 20.0, 1.1),
    Study("wooden_bridge", 2, 20.0, 4.0),
    Study("wire_circle", 2, 30.0, 4.0),
    Study("calibration_cone", 1, 40.0, 4.0),
    Study("dough_cube", 1, 55.0, 1.3),
    Study("water_balloon", 1, 115.0, 4.0),
)
_TRIED = 8  # sets that finding the least takes, about


def small_jobs() -> Iterator[Job]:
    """Yield one run of one scene with few sets of effects, against all effects that remember nothing."""
    scene, seconds = STUDIES[0].scene, STUDIES[0].other
    case = f"{scene}, against {CHEAP}"
    settings = {
        CHEAP: Setting("reference", CHEAP),
        AUTO: Setting("effects", AUTO),
        "nothing": Setting("effects", "nothing"),
    }
    for label, setting in settings.items():
        yield Job(
            case, setting, "apart", seconds, partial(_small_answer, scene, label), 0, label == AUTO, case, once=True
        )


def jobs() -> Iterator[Job]:
    """Yield each scene with each set of effects, seed by seed."""
    for study in STUDIES:
        whole = study.seeds * (study.everything + _TRIED * study.other)
        for label in SETS:
            for seed in range(study.seeds):
                run = partial(_answer, study, label, seed)
                setting, default = Setting("effects", label), label == AUTO
                yield Job(study.scene, setting, "apart", whole, run, seed, default, study.scene, once=True)
                whole = 0.0


@lru_cache(maxsize=2)
def _priced(study: Study) -> tuple[Scene, dict[str, Runs]]:
    name, seeds, ledger = study.scene, range(study.seeds), Ledger(None, workers=1)
    found = dict(price(name, ledger, seeds, seeds).runs)
    every = [verdict.name for verdict in advise(load_scene(name)) if verdict.possible]
    found[CHEAP] = ledger.runs(name, [effect for effect in every if effect not in DEAR], every, seeds)
    return load_scene(name), found


def _answer(study: Study, label: str, seed: int) -> list[Answer]:
    scene, runs = _priced(study)
    return _answered(scene, runs[EVERYTHING], runs[label], seed)


@lru_cache(maxsize=4)
def _small_runs(name: str, label: str) -> Runs:
    verdicts = [v for v in advise(load_scene(name)) if v.possible]
    sets = {
        CHEAP: [v.name for v in verdicts if v.name not in DEAR],
        AUTO: [v.name for v in verdicts if v.on],
        "nothing": [],
    }
    return Ledger(None, workers=1).runs(name, sets[label], [v.name for v in verdicts], [0])


def _small_answer(name: str, label: str) -> list[Answer]:
    found = _answered(load_scene(name), _small_runs(name, CHEAP), _small_runs(name, label), 0)
    return [replace(answer, status=REFERENCE) for answer in found] if label == CHEAP else found


def _answered(scene: Scene, full: Runs, runs: Runs, number: int) -> list[Answer]:
    found = runs.outcomes[number]
    if not full.outcomes[number].values:
        raise NoAnswer(f"with everything on: {full.outcomes[number].reason}")
    if not found.values:
        return [Answer("apart", None, found.cpu_seconds, 0.0, status=FAILED, reason=found.reason)]
    return [Answer("apart", apart(scene, full, runs, number), found.cpu_seconds, 0.0)]


def apart(scene: Scene, full: Runs, runs: Runs, number: int) -> float:
    """Return the difference of one run from the run with everything on, over the tolerance; of the observables the largest."""
    found, right = runs.outcomes[number].values, full.outcomes[number].values
    tolerances = scene.tolerance.named()
    scales = {name: tolerances[name] * (abs(value) if name in RELATIVE else 1.0) for name, value in right.items()}
    return max((abs(found[name] - right[name]) / scales[name] for name in found.keys() & right.keys()), default=0.0)
