"""Engines: the same rows from each, on real processes; and what is refused."""

import json
import socket
import threading
import warnings
from contextlib import contextmanager

import pytest

from stretch_bt.errors import InvalidInput, StretchError
from stretch_bt.runtime.replay import replay
from stretch_bt.sweep import dask_scheduler, sweep
from stretch_bt.sweep.cluster import _begun, _client, cluster
from stretch_bt.sweep.engines import engine_of
from stretch_bt.sweep.local import _closed
from stretch_bt.sweep.serial import serial

TWENTY = "tree: count.yaml\nset: {number: [1, 2, 3, 4]}\nseeds: 5"


def test_twenty_items_on_two_dask_workers_are_those_of_this_process(lab, tmp_path, rows, monkeypatch):
    """And a worker keeps no pictures of its stack: it grew by 2 MB an item."""
    import dask

    pictures = []

    @contextmanager
    def asked(*given):
        with _client(*given) as client:
            yield client
            pictures.extend(client.run(dask.config.get, "distributed.worker.profile.enabled").values())

    monkeypatch.setattr("stretch_bt.sweep.cluster._client", asked)
    lab.sweep(TWENTY)
    here = sweep(lab.file, out=tmp_path / "here")
    there = sweep(lab.file, engine_of("dask", 2, None), out=tmp_path / "there")
    assert there.whole
    assert rows(there.folder) == rows(here.folder)
    lines = (there.folder / "rows.jsonl").read_text()
    assert len({line.rpartition('"worker": ')[2] for line in lines.splitlines()}) == 2
    assert pictures == [False, False]


NODE = '''\
from stretch_bt import Behavior, Status, node


@node
class OfTheLab(Behavior):
    """End at once."""

    def update(self):
        return Status.SUCCESS
'''


def test_a_record_of_a_worker_names_the_files_of_the_sweep_and_is_replayed(lab, own_nodes, tmp_path):
    """It named the worker's own folder, which is gone, and which anybody could have made again with other modules."""
    lab.write("trees/sweep_kept_node.py", NODE)
    tree = "format: stretch-tree/1\nimports: {own: sweep_kept_node}\ntrees: {main: {sequence: [of_the_lab]}}\n"
    lab.write("trees/own.yaml", tree)
    lab.sweep("tree: trees/own.yaml\nrecord: full")
    found = []
    for engine in ("serial", "local"):
        sweep(lab.file, engine_of(engine, None, None), out=tmp_path / engine)
        (record,) = (tmp_path / engine / "records").iterdir()
        info = json.loads((record / "run.json").read_text())
        found.append({name: info[name] for name in ("tree", "scene", "cell", "modules", "driver_modules")})
        assert replay(record, trust=True).identical
    assert found[0] == found[1]
    assert found[0]["tree"] == str(lab.folder / "trees/own.yaml")


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (("dusk", None, None), "did you mean 'dask'"),
        (("serial", None, "tcp://lab:8786"), "--scheduler is for the engine dask"),
        (("local", None, "tcp://lab:8786"), "--scheduler is for the engine dask"),
        (("serial", 2, None), "runs in this process"),
        (("dask", 2, "tcp://lab:8786"), "has the workers of its scheduler"),
        ((None, 2, "tcp://lab:8786"), "has the workers of its scheduler"),
        (("local", 0, None), "write 1 or more"),
    ],
)
def test_what_does_not_go_together_is_refused(given, said):
    with pytest.raises(InvalidInput, match=said):
        engine_of(*given)


def test_without_a_name_the_scheduler_says_which_engine():
    assert engine_of(None, None, None) is serial


def test_a_worker_with_threads_is_refused(lab):
    from distributed import LocalCluster

    with (
        LocalCluster(n_workers=1, threads_per_worker=2, processes=False, dashboard_address="127.0.0.1:0") as two,
        pytest.raises(InvalidInput, match=r"has 2 threads, .* start it with --nthreads 1"),
    ):
        next(cluster(lab.specs(), 1, two.scheduler_address))


def test_where_no_host_is_nothing_runs(lab):
    with pytest.raises(InvalidInput, match="there is no Dask scheduler at 'nowhere:1'"):
        next(cluster(lab.specs(), 1, "nowhere:1"))


@pytest.mark.parametrize("speaks", [b"", b"SSH-2.0-OpenSSH_9.2\r\n", b"220 smtp\r\n"])
def test_where_no_scheduler_is_nothing_runs(lab, monkeypatch, speaks):
    """What listened in silence was waited for without end, and what spoke first ended in a traceback."""
    monkeypatch.setattr(dask_scheduler, "PATIENCE", 0.5)
    with socket.create_server(("127.0.0.1", 0)) as server:
        address = f"tcp://127.0.0.1:{server.getsockname()[1]}"
        held = []

        def greet():
            held.append(server.accept()[0])
            held[0].sendall(speaks)

        thread = threading.Thread(target=greet)
        thread.start()
        with pytest.raises(InvalidInput, match=f"there is no Dask scheduler at '{address}'"):
            next(cluster(lab.specs(), 1, address))
        thread.join()
        held[0].close()


def test_workers_that_do_not_begin_are_told_with_the_next_step():
    def fails():
        raise RuntimeError("Nanny failed to start.")

    with pytest.raises(StretchError, match=r"Nanny failed to start.*if __name__ == .* --engine serial"):
        _begun(fails)


def test_a_sweep_that_ends_before_its_items_hears_nothing_of_batches():
    def rans():
        try:
            yield 1
        finally:
            warnings.warn("You could benefit from adjusting the input task iterator", stacklevel=1)

    found = rans()
    with warnings.catch_warnings(record=True) as told, _closed(found):
        next(found)
    assert told == []
