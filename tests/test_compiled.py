"""Compiled kernels are kept where they can be, and belong to one state of all kernels."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from stretch_bt import compiled

ASK = "from stretch_bt.compiled import cache_folder; print(cache_folder())"


def folder_in(**environment):
    """Return the cache folder of a fresh process."""
    unset = {"NUMBA_CACHE_DIR", "XDG_CACHE_HOME"} - environment.keys()
    env = {k: v for k, v in os.environ.items() if k not in unset} | environment
    done = subprocess.run([sys.executable, "-c", ASK], env=env, capture_output=True, text=True, check=True)
    return done.stdout.strip()


@pytest.mark.parametrize("variable", ["NUMBA_CACHE_DIR", "XDG_CACHE_HOME"])
def test_kernels_are_kept_where_the_user_says(tmp_path, variable):
    assert Path(folder_in(**{variable: str(tmp_path)})).is_relative_to(tmp_path)


def test_nothing_is_kept_where_nothing_can_be_written(tmp_path):
    (tmp_path / "file").write_text("")
    assert folder_in(XDG_CACHE_HOME=str(tmp_path / "file")) == "None"


def test_a_change_of_any_kernel_leaves_the_old_code_behind(tmp_path, monkeypatch):
    (tmp_path / "compiled.py").write_text("")
    (tmp_path / "part").mkdir()
    monkeypatch.setattr(compiled, "__file__", str(tmp_path / "compiled.py"))
    prints = set()
    for text in ("a", "b"):
        (tmp_path / "part" / "some_kernel.py").write_text(text)
        prints.add(compiled._fingerprint())
    assert len(prints) == 2


#: kernels that it does not call are not compiled
SETTLE = """\
import hashlib, numpy as np
from stretch_bt import compiled
kernel = compiled.kernel
compiled.kernel = lambda signature=None: kernel()
from stretch_bt.perception.top_kernel import settle
draw = np.random.default_rng(0)
design, q = draw.normal(size=(6, 501)), np.zeros(6)
assert settle(design, draw.normal(size=501), q, 3.0, 1e-9, 9)
print(hashlib.sha256(q.tobytes()).hexdigest())
"""


def test_a_processor_with_fewer_instructions_gives_the_same_digits():
    """It fuses no product with a sum, and adds up in another width; numba keeps the code of each processor apart."""
    digits = set()
    for own in ({}, {"NUMBA_CPU_NAME": "generic"}):
        done = subprocess.run(
            [sys.executable, "-c", SETTLE], env=os.environ | own, capture_output=True, text=True, check=True
        )
        digits.add(done.stdout)
    assert len(digits) == 1
