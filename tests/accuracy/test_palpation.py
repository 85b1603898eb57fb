"""The domain palpation: errors beside the robot's time, and its protocols."""

from types import SimpleNamespace

import pytest

from stretch_bt.accuracy import domain_palpation, measure
from stretch_bt.accuracy.palpation import settings
from stretch_bt.accuracy.palpation.palpated import PalpationTruth
from stretch_bt.accuracy.palpation.protocols import AVERAGING, LEVELS, PROTOCOLS
from stretch_bt.accuracy.palpation.settings import SERIES, ProtocolSeries
from stretch_bt.tree.program import load_program

FEW = (
    ProtocolSeries("palpate_stiffness", "shipped", {}, (0,)),
    ProtocolSeries("from zero by 2 mm", "from zero", {"step": 0.002}, (0,)),
    ProtocolSeries("palpate_stiffness without force", "shipped", {"max_force": 0.1}, (0,)),
)
SEEDS = (0,)


@pytest.fixture(scope="module")
def rows():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(settings, "SERIES", FEW)
        patch.setattr(settings, "BALLOONS", ("seeds",))
        patch.setattr(settings, "SEEDS", SEEDS)
        return list(measure(["palpation"]))


@pytest.mark.slow
def test_each_run_has_its_errors_and_the_time_of_the_robot(rows):
    found = [row for row in rows if row.status == "ok"]
    assert [(str(row.setting), row.error_kind) for row in found] == [
        (f"{series.name}: least", kind) for series in FEW[:2] for kind in domain_palpation.DOMAIN.kinds
    ]
    for row in found:
        assert 0 <= row.error < (0.3 if row.setting.series.startswith("palpate") else 0.5)
        assert 8 < row.robot_seconds < 45
        assert row.cpu_seconds > 0
        assert row.to_json()["robot_seconds"] == row.robot_seconds
        assert (row.case, row.seed, row.reference_error) == ("seeds balloon, hertz", SEEDS[0], 0.0)


def test_an_interrupted_run_ends_the_measurement(monkeypatch):
    ended = SimpleNamespace(status="INTERRUPTED", cpu_seconds=1.0)
    monkeypatch.setattr(settings, "palpated", lambda *arguments: (ended, None))
    with pytest.raises(KeyboardInterrupt):
        next(settings.jobs()).run()


@pytest.mark.slow
def test_a_run_that_fails_says_why(rows):
    row = rows[-1]
    assert (str(row.setting), row.error) == ("palpate_stiffness without force: least", None)
    assert row.status == "failed"
    assert row.reason.startswith("FAILURE: main/")
    assert row.robot_seconds > 5


def test_the_default_is_the_tree_as_it_is_shipped():
    defaults = {job.setting for job in settings.jobs() if job.default}
    assert [str(setting) for setting in defaults] == ["palpate_stiffness: as shipped"]
    for protocol in ("shipped", "active"):
        params = load_program(PROTOCOLS[protocol]).document.params
        for name, value in LEVELS[protocol][settings.SHIPPED].items():
            assert params[name].default == pytest.approx(value), (protocol, name)


@pytest.mark.parametrize("series", SERIES, ids=lambda series: series.name)
def test_params_are_those_of_the_tree_of_the_protocol(series):
    tree = load_program(PROTOCOLS[series.protocol])
    assert tree.diagnostics == []
    assert set(series.levels) <= set(range(len(AVERAGING)))
    for level in series.levels:
        asked = {**LEVELS[series.protocol][level], **series.params}
        assert load_program(PROTOCOLS[series.protocol], asked).diagnostics == []
        assert asked.keys() <= tree.document.params.keys()


def test_steps_of_the_same_protocol_differ():
    for protocol, name in (("from zero", "step"), ("shipped", "stretch_step")):
        steps = [series.params[name] for series in SERIES if series.protocol == protocol and name in series.params]
        assert len(set(steps)) == len(steps) == 3


@pytest.mark.parametrize(
    ("forces", "falls"), [([], 0), ([1.0, 1.1, 1.09], 0), ([1.0, 0.97, 2.0, 1.9], 2), ([0.1, 0.091], 0)]
)
def test_a_fall_is_more_than_both_limits(forces, falls):
    assert PalpationTruth(SimpleNamespace(), 0.0, forces).falls() == falls
