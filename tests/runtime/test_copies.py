"""Copies of files: a record names the originals, and what reads a file finds the copy."""

from pathlib import Path

import pytest

from stretch_bt.runtime.copies import copies_of, copy_of, named_by_originals


@pytest.mark.parametrize(
    ("originals", "copy", "original"),
    [
        ("/data/lab", "/scratch/copies/deep/tree.yaml", "/data/lab/deep/tree.yaml"),
        ("/data/lab", "/scratch/copies/../tree.yaml", "/data/lab/../tree.yaml"),
        ("/", "/scratch/copies/tree.yaml", "/tree.yaml"),
        ("/scratch/copies", "/scratch/copies/tree.yaml", "/scratch/copies/tree.yaml"),
        ("/data/lab", "/scratch/copies2/tree.yaml", "/scratch/copies2/tree.yaml"),
        ("/data/lab", "water_balloon", "water_balloon"),
        ("/data/lab", "of /scratch/copies/tree.yaml", "of /scratch/copies/tree.yaml"),
    ],
)
def test_a_path_of_a_copy_is_that_of_the_original_and_back(originals, copy, original):
    with copies_of(originals, Path("/scratch/copies")):
        assert named_by_originals({"a": [{copy: copy}], "b": 1}) == {"a": [{copy: original}], "b": 1}
        assert copy_of(original) == copy
    assert named_by_originals(copy) == copy_of(copy) == copy
