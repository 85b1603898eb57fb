"""How many threads the tests, and what they start, let BLAS have."""

import subprocess
import sys

import numpy  # noqa: F401  only libraries that are loaded have threads
import scipy.linalg  # noqa: F401
from threadpoolctl import threadpool_info

ASKED = "import numpy, scipy.linalg, threadpoolctl; print({p['num_threads'] for p in threadpoolctl.threadpool_info()})"


def test_one_thread_here_and_in_every_process_that_a_test_starts():
    assert {pool["num_threads"] for pool in threadpool_info()} == {1}
    assert subprocess.run([sys.executable, "-c", ASKED], capture_output=True, text=True).stdout.strip() == "{1}"
