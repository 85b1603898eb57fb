"""Behaviour trees for the StRETcH tactile hand."""

__version__ = "0.1.0"
