"""A fixed computation whose CPU time says how fast a machine is at this moment."""

from __future__ import annotations

import time

import numpy as np

__all__ = ["yardstick"]

_SIZE, _ROUNDS, _LOOPS = 160, 8, 60_000


def yardstick() -> float:
    """Return CPU seconds of factorisations and of plain Python, about as much of each: some 10 ms."""
    matrix = np.eye(_SIZE) * _SIZE + np.linspace(0.0, 1.0, _SIZE * _SIZE).reshape(_SIZE, _SIZE)
    matrix = matrix + matrix.T
    began = time.process_time()
    for _ in range(_ROUNDS):
        np.linalg.inv(np.linalg.cholesky(matrix))
    total = 0
    for k in range(_LOOPS):
        total += k % 7
    return time.process_time() - began
