"""The command line: thin, one command to a file."""

from stretch_bt.cli.app import main

__all__ = ["main"]
