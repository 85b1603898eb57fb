"""The address of a scheduler, as it is or in the file that the scheduler wrote."""

import json
import logging

import pytest

from stretch_bt.errors import InvalidInput
from stretch_bt.sweep.dask_scheduler import address_of, quiet


@pytest.mark.parametrize("given", ["tcp://lab:8786", "lab:8786", "tls://lab:1"])
def test_an_address_is_taken_as_it_is(given):
    assert address_of(given) == given


def test_a_scheduler_file_is_read(tmp_path):
    path = tmp_path / "dask.json"
    path.write_text(json.dumps({"type": "Scheduler", "address": "tcp://10.0.0.1:8786"}))
    assert address_of(str(path)) == "tcp://10.0.0.1:8786"


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (None, "No such file"),
        ("{}", "holds no 'address'"),
        ("[", "holds no 'address'"),
        ("[1]", "holds no 'address'"),
        ('{"address": null}', "holds no"),
    ],
)
def test_a_file_without_an_address_is_refused(tmp_path, content, said):
    path = tmp_path / "dask.json"
    if content is not None:
        path.write_text(content)
    with pytest.raises(InvalidInput, match=f"{path}: .*{said}.*; name a scheduler file, or tcp://HOST:8786"):
        address_of(str(path))


def test_a_name_too_long_for_a_file_is_refused():
    with pytest.raises(InvalidInput, match="name too long; name a scheduler file"):
        address_of("x" * 300)


def test_the_client_of_dask_is_quiet_for_the_time_of_a_sweep(caplog):
    """Where the scheduler was killed, 35 lines of its own stood before what to do."""
    logger = logging.getLogger("distributed.client")
    before = logger.level
    with quiet():
        assert not logger.isEnabledFor(logging.ERROR)
    assert logger.level == before
