"""A Dask scheduler that runs already: its address, and whether it is one."""

from __future__ import annotations

import asyncio
import json
import logging
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from stretch_bt.errors import InvalidInput

__all__ = ["address_of", "await_scheduler", "quiet"]

#: longest wait for the greeting of a scheduler, s
PATIENCE = 10.0


def address_of(scheduler: str) -> str:
    """Return the address of a scheduler from itself, or from the file that `dask scheduler --scheduler-file` wrote.

    Raises
    ------
    InvalidInput
        The file holds none.
    """
    path = Path(scheduler)
    try:
        if "://" in scheduler or not (path.is_file() or path.suffix == ".json"):
            return scheduler
        address = json.loads(path.read_text("utf-8"))["address"]
        if not isinstance(address, str):
            raise TypeError
        return address
    except OSError as error:
        raise InvalidInput(f"{scheduler}: {error.strerror}; name a scheduler file, or tcp://HOST:8786") from None
    except (ValueError, LookupError, TypeError):
        what = "holds no 'address' of a Dask scheduler"
        raise InvalidInput(f"{scheduler}: it {what}; name a scheduler file, or tcp://HOST:8786") from None


def await_scheduler(address: str) -> None:
    """Return once what listens at an address has greeted as Dask does, for which a client would wait without end.

    Raises
    ------
    Exception
        Nothing listens there, or what listens is silent, or another server.
    """
    if address.startswith("inproc://"):  # of this process, known to its own event loop alone
        return
    found: list[Exception] = []
    heard = threading.Event()

    async def greet() -> None:
        try:
            await _greeting(address)
        except Exception as error:
            found.append(error)
        finally:
            heard.set()

    # a notebook has an event loop in its own thread; what waits for the rest of a message hears of no limit
    threading.Thread(target=lambda: asyncio.run(greet()), daemon=True).start()
    if not heard.wait(1.2 * PATIENCE):
        raise TimeoutError(f"no greeting within {PATIENCE:.0f} s")
    if found:
        raise found[0]


async def _greeting(address: str) -> None:
    from distributed.comm import connect
    from distributed.security import Security

    arguments: dict[str, Any] = Security().get_connection_args("client")
    comm = await connect(address, timeout=PATIENCE, **arguments)
    await comm.close()


@contextmanager
def quiet() -> Iterator[None]:
    """Let Dask's client log nothing: where the scheduler is gone, it would show where it was before we say so."""
    loggers = [logging.getLogger(name) for name in ("distributed.client", "distributed.core", "distributed.comm")]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)
