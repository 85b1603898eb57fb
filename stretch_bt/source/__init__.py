"""Text files with positions: YAML 1.2 core values, duplicate keys refused, every value knows its line and column.

A file is read into `Scalar`, `Seq` and `Map` values; `validate` fits one to a pydantic model and reports every mistake at
once, at its place, with a suggestion. Anchors are expanded by copying, within a budget, so no two places share an object.
"""

from stretch_bt.source.compose import parse
from stretch_bt.source.fit import FILE_KINDS, validate
from stretch_bt.source.read import load, read_text, resolve
from stretch_bt.source.suggest import MISSPELT, closest, did_you_mean, few_suggestions, stands_already, unknown_key
from stretch_bt.source.syntax import lines_of
from stretch_bt.source.values import TRUTHS, Map, Mark, Scalar, Seq, Value, is_nothing, is_null, told, walk

__all__ = [
    "FILE_KINDS",
    "MISSPELT",
    "TRUTHS",
    "Map",
    "Mark",
    "Scalar",
    "Seq",
    "Value",
    "closest",
    "did_you_mean",
    "few_suggestions",
    "is_nothing",
    "is_null",
    "lines_of",
    "load",
    "parse",
    "read_text",
    "resolve",
    "stands_already",
    "told",
    "unknown_key",
    "validate",
    "walk",
]
