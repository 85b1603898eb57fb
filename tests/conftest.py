import atexit
import gc
import math
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from importlib.resources import files
from importlib.util import cache_from_source
from pathlib import Path

import pytest
from hypothesis import settings
from lateness import Lateness

from stretch_bt.cli.start import COLLECTED
from stretch_bt.threads import ONE_THREAD

os.environ.update(
    ONE_THREAD
)  # before numpy is loaded: more threads wait for each other, and take the cores from the other tests

gc.set_threshold(*COLLECTED)  # as the command has it

# where a shell forbids bytecode, each of the hundreds of processes that tests start would compile all that it imports
_MADE = tempfile.mkdtemp(prefix="stretch-bt-bytecode-") if os.environ.pop("PYTHONDONTWRITEBYTECODE", "") else ""
if _MADE:
    sys.dont_write_bytecode, sys.pycache_prefix = False, _MADE
    os.environ["PYTHONPYCACHEPREFIX"] = _MADE
    atexit.register(shutil.rmtree, _MADE, ignore_errors=True)

# a shell that runs the tests in the background, or under nohup, has them ignored, and the processes of the tests would ignore them too
signal.signal(signal.SIGINT, signal.default_int_handler)
if hasattr(signal, "SIGHUP"):
    signal.signal(signal.SIGHUP, signal.SIG_DFL)

# how fast a machine is, is no property of the code; the same examples each time: `--hypothesis-profile search` looks for others
settings.register_profile("shared", deadline=None, derandomize=True)
settings.register_profile("search", deadline=None)
settings.load_profile("shared")

#: files that take longest, and so are begun first; files that wait for a wire lie between files that compute, which have the cores meanwhile
LONGEST = (
    "hardware/test_contract.py",
    "docs/test_docs.py",
    "perception/solids/test_solids.py",
    "hardware/test_wired_run.py",
    "hardware/test_scene_processes.py",
    "hardware/test_ur_faults.py",
    "trees/test_form_cookie.py",
    "tree/test_modules.py",
    "benchmarks/test_drift.py",
    "trees/test_nothing_hidden.py",
    "testing/test_device_contract.py",
    "trees/test_reconstruct.py",
    "trees/test_contact_sensitivity.py",
    "simulation/test_world.py",
    "trees/test_palpate_stiffness.py",
    "trees/test_characterize.py",
    "examples/test_device_packages.py",
    "runtime/test_borrowed_devices.py",
    "runtime/test_mutations.py",
    "docs/test_drivers.py",
    "accuracy/test_palpation.py",
    "perception/test_noise_off_contact.py",
    "cli/test_commands.py",
    "docs/test_commissioning.py",
    "sweep/test_run_item.py",
    "runtime/test_reach.py",
    "model/calibration/test_calibrate.py",
    "examples/test_planted_faults.py",
    "runtime/test_load_ahead.py",
    "runtime/test_check.py",
    "cli/test_ends.py",
    "runtime/test_hand_calibration.py",
    "test_compiled.py",
    "accuracy/test_twin.py",
    "perception/clouds/test_relief.py",
    "sweep/test_engines.py",
    "runtime/test_forked.py",
    "cli/test_accuracy.py",
    "runtime/test_determinism.py",
    "hardware/test_camera_faults.py",
    "runtime/report/panels/test_palpation.py",
    "hardware/test_silence.py",
    "trees/test_palpate_active.py",
    "hardware/test_gripper_faults.py",
    "runtime/test_stop_anywhere.py",
    "perception/test_height_noise.py",
    "perception/test_drum.py",
    "hardware/test_ati.py",
    "runtime/test_cut_off.py",
    "cli/test_start.py",
    "hardware/test_peak_force.py",
    "cli/test_stop.py",
    "perception/clouds/test_cloud.py",
    "behaviors/test_track_height.py",
    "cli/test_calibrate.py",
    "cli/test_move.py",
    "hardware/test_emulators.py",
    "accuracy/test_perception.py",
    "runtime/test_foreign_nodes.py",
    "simulation/test_sheet_model.py",
    "hardware/test_ur_stand_in.py",
    "cli/test_look.py",
    "hardware/test_camera.py",
    "cli/test_emulate.py",
    "hardware/test_unwatched.py",
    "test_clock.py",
    "hardware/test_ur_client_ports.py",
)
#: tests that go by the clock of the machine, and so are held to deadlines
BY_THE_CLOCK = (
    "hardware",
    "cli",
    "docs",
    "examples",
    "runtime/test_hand_calibration.py",
    "behaviors/test_force_limit.py",
)
#: whose tests share nothing that is costly: one by one they keep all processes busy to the end
SPREAD = ("hardcases/test_hardcases.py",)
#: so often it is tried again where the machine was late
AGAIN = 4

_FOLDER = Path(__file__).parent
_ROOT = _FOLDER.parent
lateness = Lateness()


@pytest.fixture
def own_nodes(monkeypatch):
    """Forget at the end of the test what it registered."""
    from stretch_bt.tree import registry

    monkeypatch.setattr(registry, "_nodes", registry.load_all())


def pytest_unconfigure(config):
    """Leave no bytecode behind; processes that this one began share its folder."""
    if _MADE:
        shutil.rmtree(_MADE, ignore_errors=True)


def pytest_xdist_auto_num_workers():
    """Two processes more than cores: a third of the time goes by while tests wait for a wire."""
    return (os.cpu_count() or 1) + 2


def pytest_xdist_setupnodes(config):
    """Compile kernels and tests, a share on each core: the processes would each compile all of them at once."""
    kernels = sorted((_ROOT / "stretch_bt").rglob("*_kernel.py"))
    names = [".".join(path.relative_to(_ROOT).with_suffix("").parts) for path in kernels]
    _on_each_core(["-c"], lambda share: [f"import {', '.join(share)}"], names)
    asked = [Path(argument.partition("::")[0]).resolve() for argument in config.args]
    tests = [path for path in _FOLDER.rglob("test_*.py") if any(path.is_relative_to(place) for place in asked)]
    new = sorted(str(path) for path in tests if not _rewritten(path))
    _on_each_core(["-m", "pytest", "-n0", "--collect-only", "-qq"], list, new)


def _rewritten(path):
    """Return whether this pytest has bytecode of a test file; pytest itself compares their ages."""
    name = f"{path.stem}.{sys.implementation.cache_tag}-pytest-{pytest.__version__}.pyc"
    return Path(cache_from_source(str(path))).with_name(name).exists()


def _on_each_core(command, words, items):
    """Run a Python command on each core, each with a share of some items."""
    cores = os.cpu_count() or 1
    shares = [share for core in range(cores) if (share := items[core::cores])]
    for begun in [
        subprocess.Popen([sys.executable, *command, *words(share)], cwd=_ROOT, stdout=subprocess.DEVNULL)
        for share in shares
    ]:
        begun.wait()


def pytest_xdist_make_scheduler(config, log):
    """Keep each file in one process, but for files whose tests share nothing that is costly."""
    from xdist.scheduler import LoadFileScheduling

    class Files(LoadFileScheduling):
        def _split_scope(self, nodeid):
            file = super()._split_scope(nodeid)
            return nodeid if file.endswith(SPREAD) else file

    return Files(config, log) if config.getvalue("dist") == "loadfile" else None


def pytest_collection_modifyitems(items):
    """Put the tests of files that take longest first, spread ones last, and repeat tests that a late machine may have broken."""
    ranks = {_FOLDER / name: rank for rank, name in enumerate(LONGEST)} | {_FOLDER / name: math.inf for name in SPREAD}
    items.sort(key=lambda item: ranks.get(item.path, len(LONGEST)))
    for item in items:
        if item.path.relative_to(_FOLDER).as_posix().startswith(BY_THE_CLOCK):
            item.add_marker(pytest.mark.flaky(reruns=AGAIN, condition=lateness.was_late))


def pytest_collection_finish():
    """Leave what is there for good out of later collections: ten thousand tests and what they import."""
    gc.collect()
    gc.freeze()


@pytest.fixture(scope="session")
def at_hertz():
    """Return a function that writes a shipped scene into a folder at the fidelity that answers at once, and returns its path."""

    def write(name, folder):
        shipped = files("stretch_bt") / "trees" / "scenes" / f"{name}.yaml"
        path = folder / "scene.yaml"
        path.write_text(shipped.read_text("utf-8") + "fidelity: hertz\n", encoding="utf-8")
        return path

    return write


@pytest.fixture
def hand_at(tmp_path):
    """Return a function that writes the simulated cell with the hand at a height, mm, so near to an object, and a prompt operator."""

    def write(height):
        text = (files("stretch_bt") / "trees" / "cells" / "simulated.yaml").read_text("utf-8")
        for shipped, ours in (
            ("height: 120 mm}", f"height: {height} mm}}"),
            ("type: Operator, use: simulated}", "type: Operator, use: simulated, delay: 3 s}"),
        ):
            assert shipped in text
            text = text.replace(shipped, ours)
        path = tmp_path / "cell.yaml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item):
    """Watch the machine where a test goes by its clock."""
    if item.get_closest_marker("flaky"):
        lateness.begin()
