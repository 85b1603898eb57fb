"""The command line: thin, one command to a file."""

from stretch_bt.cli.start import main, program

__all__ = ["main", "program"]
