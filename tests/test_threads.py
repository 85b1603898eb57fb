"""How many threads the tests, and what they start, let BLAS have."""

import os
import subprocess
import sys

import numpy  # noqa: F401  only libraries that are loaded have threads
import scipy.linalg  # noqa: F401
from threadpoolctl import threadpool_info

ASKED = "import numpy, scipy.linalg, threadpoolctl; print({p['num_threads'] for p in threadpoolctl.threadpool_info()})"


def test_one_thread_here_and_in_every_process_that_a_test_starts():
    assert {pool["num_threads"] for pool in threadpool_info()} == {1}
    assert subprocess.run([sys.executable, "-c", ASKED], capture_output=True, text=True).stdout.strip() == "{1}"


LATER = """
import sys, threadpoolctl
from stretch_bt.threads import one_thread
with one_thread():
    before = "scipy.linalg" in sys.modules
    import scipy.linalg
    print(before, {p["num_threads"] for p in threadpoolctl.threadpool_info() if p["user_api"] == "blas"})
print({p["num_threads"] for p in threadpoolctl.threadpool_info() if p["user_api"] == "blas"})
"""


def test_the_library_of_scipy_has_one_thread_though_scipy_is_imported_later():
    two = {name: value for name, value in os.environ.items() if not name.endswith("NUM_THREADS")}
    found = subprocess.run(
        [sys.executable, "-c", LATER], capture_output=True, text=True, env=two | {"OPENBLAS_NUM_THREADS": "2"}
    )
    assert found.stdout.splitlines() == ["False {1}", "{2}"], found.stderr
