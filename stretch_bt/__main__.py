"""`python -m stretch_bt`."""

from stretch_bt.cli import program

program()
