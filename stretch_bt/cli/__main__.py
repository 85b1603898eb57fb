"""`python -m stretch_bt.cli`."""

from stretch_bt.cli import program

program()
