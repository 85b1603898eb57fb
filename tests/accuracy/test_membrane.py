"""The domain membrane: its figures, its references, and the simulators that it compares with."""

import math
import sys

import numpy as np
import pytest

from stretch_bt.accuracy import peers
from stretch_bt.accuracy.domain_membrane import DOMAIN
from stretch_bt.accuracy.membrane import cases as table
from stretch_bt.accuracy.membrane import known, presses
from stretch_bt.accuracy.membrane.errors import Reference
from stretch_bt.accuracy.points import REFERENCE
from stretch_bt.errors import NoEquilibrium
from stretch_bt.simulation.membrane.press import press
from stretch_bt.simulation.membrane.sheet.settings import Settings

#: largest error over the three presses, in units of 1 and m
BOUNDS = {
    "reference: known": {"force": 0.004},
    "reference: sheet": {"force": 0.005, "surface": 1e-4, "contact_radius": 0.15},
    "axisymmetric, round membrane: known": {"force": 1e-6},
    "axisymmetric, round membrane: slope": {"force": 1e-6},
    "sheet from flat: Settings()": {"force": 0.008, "surface": 2e-4, "contact_radius": 0.3},
    "sheet from the last press: Settings()": {"force": 0.008, "surface": 2e-4, "contact_radius": 0.3},
    "sheet from flat, settled: Settings.within(0.01)": {"force": 0.01, "surface": 3e-4, "contact_radius": 0.3},
    "sheet from the last press, settled: Settings.within(0.03)": {
        "force": 0.03,
        "surface": 5e-4,
        "contact_radius": 0.3,
    },
    "sheet from the last press, settled: Settings.within(0.01)": {
        "force": 0.01,
        "surface": 3e-4,
        "contact_radius": 0.3,
    },
    "sheet from the last press, settled: Settings.within(0.003)": {
        "force": 0.005,
        "surface": 2e-4,
        "contact_radius": 0.2,
    },
}


@pytest.fixture(scope="module")
def rows(measured):
    """The three presses that little time is given to, by every solver, and what is known from elsewhere."""
    jobs = [*presses.jobs(quick=True), *known.jobs()]
    return measured("membrane", DOMAIN, [job for job in jobs if job.seconds < 100])


@pytest.mark.slow
@pytest.mark.parametrize("prefix", BOUNDS)
def test_errors_stay_below_their_bounds(rows, prefix):
    found = [row for row in rows if str(row.setting).startswith(prefix)]
    assert {row.error_kind for row in found} == BOUNDS[prefix].keys()
    for row in found:
        assert 0 <= row.error < BOUNDS[prefix][row.error_kind], row
        assert row.cpu_seconds > 0


@pytest.mark.slow
def test_every_row_has_an_error_or_says_why_not(rows):
    for row in rows:
        answered = row.status in ("ok", "reference")
        assert answered == (row.error is not None and math.isfinite(row.error)), row
        assert answered or row.reason.startswith("NoEquilibrium: "), row
        assert row.error_kind in DOMAIN.kinds


@pytest.mark.slow
def test_finer_elements_err_less(rows):
    surface = {
        row.setting.variant: row.error
        for row in rows
        if row.case.startswith("sphere 20 mm") and row.setting.series == "sheet from flat, uniform elements"
        if row.error_kind == "surface"
    }
    assert surface["4 mm"] < surface["8 mm"]


def test_absent_peers_are_skipped_and_say_what_to_install(monkeypatch):
    for package in ("mujoco", "newton"):
        monkeypatch.setitem(sys.modules, package, None)
    found = {job.setting.series: job.run() for job in peers.presses()}
    assert found.keys() == DOMAIN.peers == {"MuJoCo flex", "Newton VBD"}
    for (answer,) in found.values():
        assert (answer.status, answer.reason) == ("skipped", "install stretch-bt[peers]")


def test_a_peer_is_held_to_the_sheet(monkeypatch):
    """The reference press of the peers gives the force that two independent programs agree on."""

    class Peer:
        NAME, PACKAGES, SETTING = "peer", ("numpy",), "exact"

        @staticmethod
        def press():
            return peers.PeerAnswer(0.6074, 1.0)

    class Restless(Peer):
        @staticmethod
        def press():
            raise NoEquilibrium("the sheet still moves")

    class Changed(Peer):
        @staticmethod
        def press():
            raise AttributeError("no such name")

    made = {"one": Peer, "two": Restless, "three": Changed}
    monkeypatch.setattr(peers, "PRESSES", tuple(made))
    monkeypatch.setattr(peers, "import_module", lambda name: made[name.rpartition(".")[2]])
    jobs = [*peers.presses()]
    assert str(jobs[0].setting) == "peer: exact"
    (exact,) = jobs[0].run()
    assert exact.error < exact.reference_error == 0.004
    with pytest.raises(NoEquilibrium):
        jobs[1].run()
    (failed,) = jobs[2].run()
    assert (failed.error, failed.status, failed.reason) == (None, "failed", "AttributeError: no such name")


@pytest.mark.parametrize("name", peers.PRESSES)
def test_an_installed_peer_gives_a_force_in_its_known_range(name):
    pytest.importorskip({"mujoco_flex": "mujoco", "newton_vbd": "newton"}[name])
    from importlib import import_module

    found = import_module(f"stretch_bt.accuracy.peers.{name}").press()
    low, high = {"mujoco_flex": (1.3, 1.5), "newton_vbd": (0.64, 0.71)}[name]
    assert low < found.force < high


def test_the_surface_error_is_that_of_height_over_a_fixed_place():
    """Against heights interpolated over the same places, which are good to 0.02 mm on their own."""
    fine = press("sphere:20mm", 0.03, 0.008, settings=Settings(coarsen=0.7))
    rough = press("sphere:20mm", 0.03, 0.008, settings=Settings(mesh=6e-3, growth=1.0))
    right = Reference.of(fine)
    x, y, z = np.moveaxis(right.places, -1, 0)
    over = np.abs(rough.detail.shape.height(x, y) - z).max()
    assert right.errors(rough)["surface"] == pytest.approx(over, abs=3e-5)
    assert right.errors(fine) == {"force": 0.0, "surface": 0.0, "contact_radius": 0.0}


def test_cases_and_settings_have_names_of_their_own():
    names, ways = [case.name for case in table.cases()], [way.name for way in table.variants()]
    assert len(set(names)) == len(names) >= 20
    assert len(set(ways)) == len(ways) > 0
    assert {case.stretch for case in table.cases()} == {0.0, 0.01, 0.03, 0.06, 0.08}
    jobs = [*presses.jobs(quick=False)]
    assert len({(job.case, job.setting) for job in jobs}) == len(jobs)
    defaults = {str(job.setting) for job in jobs if job.default}
    assert defaults == {"sheet from flat: Settings()", "sheet from the last press: Settings()"}


def test_the_reference_is_finer_than_what_is_held_to_it():
    for case in table.cases():
        fine, coarse = table.reference_settings(case)
        assert fine.mesh < coarse.mesh
        assert fine.growth < coarse.growth
        assert fine.exact
        assert coarse.exact
        assert all(way.settings.mesh is None or way.settings.mesh > coarse.mesh for way in table.variants())


@pytest.mark.slow
def test_each_case_has_its_reference(rows):
    assert {row.case for row in rows if row.status == REFERENCE} >= {case.name for case in table.quick_cases()}
