"""Inputs that break numerics, each with the outcome it must have.

A domain is a module, or a folder, of `domains` with `CASES`: a tuple of `Hard`. A case is addressed by its domain and its
name, and is never pickled: a worker looks it up. `run` carries one out and returns a row.
"""

from stretch_bt.hardcases.expect import Check, Expectation, Range, Refusal, Value, Warned
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.hardcases.registry import DOMAINS, case, cases
from stretch_bt.hardcases.run import CaseRow, run

__all__ = [
    "DOMAINS",
    "CaseRow",
    "Check",
    "Expectation",
    "Hard",
    "Range",
    "Refusal",
    "Value",
    "Warned",
    "case",
    "cases",
    "group",
    "run",
]
