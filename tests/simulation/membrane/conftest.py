"""What the tests of the membrane share: the drawing and fitting of its benchmarks, and a check of derivatives."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from stretch_bt.simulation.membrane.sheet.problem import EXACT, GRADIENT

BENCHMARKS = Path(__file__).parents[3] / "benchmarks"


def loaded(name):
    spec = importlib.util.spec_from_file_location(name, BENCHMARKS / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="session")
def trends():
    return loaded("membrane_trends")


@pytest.fixture(scope="session")
def random_presses():
    return loaded("membrane_random")


@pytest.fixture(scope="session")
def check_derivatives():
    """A check that gradient and Hessian of a problem are derivatives at a shape; it returns the evaluation and Hessian."""

    def check(problem, control, direction, rel, hessian_rel, step=1e-6):
        band = problem.bands()[0]
        band.fill(0.0)
        here = problem.evaluate(control, EXACT, band)
        ahead, behind = (problem.evaluate(control + s * step * direction, GRADIENT) for s in (1, -1))
        assert (ahead.energy - behind.energy) / (2 * step) == pytest.approx(np.vdot(here.gradient, direction), rel=rel)
        change = ((ahead.gradient - behind.gradient) / (2 * step))[1:-1].ravel()
        lower = np.zeros((problem.unknowns, problem.unknowns))
        for k in range(band.shape[1]):
            np.fill_diagonal(lower[k:], band[: problem.unknowns - k, k])
        full = lower + np.tril(lower, -1).T
        bound = hessian_rel * np.abs(change).max()
        np.testing.assert_allclose(full @ direction[1:-1].ravel(), change, rtol=hessian_rel, atol=bound)
        return here, full

    return check
