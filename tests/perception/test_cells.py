"""Points by the cells that they lie in."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from stretch_bt.perception.cells import cells_of

FAR = 2**62


@given(
    arrays(
        np.int64,
        array_shapes(min_dims=2, max_dims=2, min_side=1, max_side=12),
        elements=st.one_of(st.integers(-3, 3), st.sampled_from((-FAR, FAR))),
    )
)
def test_cells_are_those_of_a_search_row_by_row(numbers):
    wanted = np.unique(numbers, axis=0, return_index=True, return_inverse=True, return_counts=True)
    for part, known in zip(cells_of(numbers), wanted, strict=True):
        assert np.array_equal(part, known.reshape(part.shape))


@pytest.mark.parametrize("columns", [2, 3])
def test_no_points_lie_in_no_cells(columns):
    assert [part.shape[0] for part in cells_of(np.empty((0, columns), np.int64))] == [0, 0, 0, 0]
