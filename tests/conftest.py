import os
import shutil
import signal
import subprocess
import sys
import tempfile
from importlib.resources import files
from pathlib import Path

import pytest
from hypothesis import settings
from lateness import Lateness

from stretch_bt.threads import ONE_THREAD

os.environ.update(
    ONE_THREAD
)  # before numpy is loaded: more threads wait for each other, and take the cores from the other tests

# where a shell forbids bytecode, each of the hundreds of processes that tests start would compile all that it imports
if os.environ.pop("PYTHONDONTWRITEBYTECODE", ""):
    sys.dont_write_bytecode, sys.pycache_prefix = False, tempfile.mkdtemp(prefix="stretch-bt-bytecode-")
    os.environ["PYTHONPYCACHEPREFIX"] = sys.pycache_prefix

# a shell that runs the tests in the background, or under nohup, has them ignored, and the processes of the tests would ignore them too
signal.signal(signal.SIGINT, signal.default_int_handler)
if hasattr(signal, "SIGHUP"):
    signal.signal(signal.SIGHUP, signal.SIG_DFL)

# how fast a machine is, is no property of the code; the same examples each time: `--hypothesis-profile search` looks for others
settings.register_profile("shared", deadline=None, derandomize=True)
settings.register_profile("search", deadline=None)
settings.load_profile("shared")

#: files that take longest, in this order: begun last, one of them would keep one process busy while the others have nothing left to do
LONGEST = (
    "hardware/test_ur_faults.py",
    "hardware/test_wired_run.py",
    "runtime/test_mutations.py",
    "hardware/test_contract.py",
    "trees/test_form_cookie.py",
    "hardware/test_gripper_faults.py",
    "hardware/test_camera_faults.py",
    "trees/test_palpate_stiffness.py",
    "docs/test_commissioning.py",
    "trees/test_reconstruct.py",
    "runtime/test_hand_calibration.py",
    "docs/test_docs.py",
    "examples/test_device_packages.py",
    "docs/test_drivers.py",
    "examples/test_planted_faults.py",
    "tree/test_modules.py",
    "hardware/test_peak_force.py",
    "trees/test_characterize.py",
    "hardware/test_silence.py",
    "cli/test_ends.py",
    "perception/solids/test_solids.py",
    "hardware/test_camera.py",
    "simulation/dough/test_tack.py",
    "accuracy/test_membrane.py",
    "hardware/test_scene_processes.py",
    "model/calibration/test_calibrate.py",
    "trees/test_palpate_active.py",
    "runtime/test_stop_anywhere.py",
    "hardware/test_off_effects.py",
    "trees/test_shipped.py",
    "trees/test_contact_sensitivity.py",
    "trees/test_again.py",
)
#: what goes by the clock of the machine, and so is held to deadlines
BY_THE_CLOCK = (
    "hardware",
    "cli",
    "docs",
    "examples",
    "runtime/test_hand_calibration.py",
    "behaviors/test_force_limit.py",
)
#: whose tests share nothing that is costly, and are spread over the processes one by one
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
    """Leave no bytecode behind; the processes of xdist have that of the first."""
    if "PYTEST_XDIST_WORKER" not in os.environ and "stretch-bt-bytecode-" in (sys.pycache_prefix or ""):
        shutil.rmtree(sys.pycache_prefix, ignore_errors=True)


def pytest_xdist_auto_num_workers():
    """One process more than cores: tests that wait for a wire leave half of one free."""
    return (os.cpu_count() or 1) + 1


def pytest_xdist_setupnodes():
    """Compile the kernels, a share on each core: the processes would each compile all of them at once."""
    modules = sorted(path.with_suffix("").relative_to(_ROOT) for path in (_ROOT / "stretch_bt").rglob("*_kernel.py"))
    names, cores = [".".join(module.parts) for module in modules], os.cpu_count() or 1
    shares = [f"import {', '.join(names[core::cores])}" for core in range(cores)]
    for compiling in [subprocess.Popen([sys.executable, "-c", share], cwd=_ROOT) for share in shares]:
        compiling.wait()


def pytest_xdist_make_scheduler(config, log):
    """Keep each file in one process, but for those whose tests share nothing that is costly."""
    from xdist.scheduler import LoadFileScheduling

    class Files(LoadFileScheduling):
        def _split_scope(self, nodeid):
            file = super()._split_scope(nodeid)
            return nodeid if file.endswith(SPREAD) else file

    return Files(config, log) if config.getvalue("dist") == "loadfile" else None


def pytest_collection_modifyitems(items):
    """Put the tests of files that take longest first, and repeat what a late machine may have broken."""
    ranks = {_FOLDER / name: rank for rank, name in enumerate(LONGEST)}
    items.sort(key=lambda item: ranks.get(item.path, len(LONGEST)))
    for item in items:
        if item.path.relative_to(_FOLDER).as_posix().startswith(BY_THE_CLOCK):
            item.add_marker(pytest.mark.flaky(reruns=AGAIN, condition=lateness.was_late))


@pytest.fixture(scope="session")
def at_hertz():
    """Return what writes a shipped scene into a folder at the fidelity that is known at once, and returns its path."""

    def write(name, folder):
        shipped = files("stretch_bt") / "trees" / "scenes" / f"{name}.yaml"
        path = folder / "scene.yaml"
        path.write_text(shipped.read_text("utf-8") + "fidelity: hertz\n", encoding="utf-8")
        return path

    return write


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item):
    """Watch the machine where a test goes by its clock."""
    if item.get_closest_marker("flaky"):
        lateness.begin()
