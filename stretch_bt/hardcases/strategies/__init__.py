"""Strategies that draw hard inputs of a domain, for the tests and for `make fuzz`; they need the extra `fuzz`."""

from stretch_bt.errors import MissingExtra

try:
    import hypothesis as hypothesis
except ImportError:
    raise MissingExtra("hard inputs are drawn by hypothesis; pip install 'stretch-bt[fuzz]'") from None
