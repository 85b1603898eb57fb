import os
import signal
from pathlib import Path

from hypothesis import settings

from stretch_bt.threads import ONE_THREAD

os.environ.update(
    ONE_THREAD
)  # before numpy is loaded: more threads wait for each other, and take the cores from the other tests

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
    "hardware/test_wired_run.py",
    "hardware/test_ur_faults.py",
    "run/test_stop_anywhere.py",
    "run/test_mutations.py",
    "trees/test_form_cookie.py",
    "hardware/test_contract.py",
    "docs/test_commissioning.py",
)


def pytest_collection_modifyitems(items):
    """Put the tests of files that take longest first."""
    folder = Path(__file__).parent
    ranks = {folder / name: rank for rank, name in enumerate(LONGEST)}
    items.sort(key=lambda item: ranks.get(item.path, len(LONGEST)))
