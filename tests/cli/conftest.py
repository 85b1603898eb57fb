import sys

import pytest

from stretch_bt.cli.app import main


@pytest.fixture
def cli(tmp_path, monkeypatch, capfd):
    """Run a command in an empty folder: (exit code, standard output, standard error)."""
    monkeypatch.chdir(tmp_path)

    def call(*arguments):
        monkeypatch.setattr(sys, "argv", ["stretch-bt", *map(str, arguments)])
        with pytest.raises(SystemExit) as exited:
            main()
        return exited.value.code or 0, *capfd.readouterr()

    return call
