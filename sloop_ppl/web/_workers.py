"""Processes that search and read maps beside the server, forked from one that is warm."""

from __future__ import annotations

import multiprocessing
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing.connection import Connection
from types import ModuleType
from typing import Any

__all__ = ["Worker", "warm_workers"]

_START = "forkserver" if "forkserver" in multiprocessing.get_all_start_methods() else "spawn"
_CONTEXT: Any = multiprocessing.get_context(_START)
_CONTEXT_LOCK = threading.Lock()


def warm_workers() -> None:
    """Start the process that workers are forked from; it loads all that they need."""
    with _CONTEXT_LOCK:
        if _START == "forkserver":
            _CONTEXT.set_forkserver_preload(["sloop_ppl.web._preload"])
    worker = Worker(_say_ready)
    worker.receive(None)
    worker.stop()


def _say_ready(connection: Connection) -> None:
    connection.send_bytes(b"ready")


class Worker:
    """A process that sends messages until it is done or stopped.

    Parameters
    ----------
    work
        Runs in the process; its last argument is the connection it sends its messages over.
    *arguments
        What else it is given; picklable.
    """

    def __init__(self, work: Callable[..., None], *arguments: Any) -> None:
        self._receiving, sending = _CONTEXT.Pipe(duplex=False)
        with _CONTEXT_LOCK, _without_main():
            self._process = _CONTEXT.Process(target=work, args=(*arguments, sending), daemon=True)
            self._process.start()
        sending.close()
        self._is_drained = False

    @property
    def may_send(self) -> bool:
        """Whether there may be another message."""
        return not self._is_drained

    def receive(self, timeout_s: float | None) -> bytes | None:
        """Return the next message; None when there is no more, or none came in time."""
        try:
            if timeout_s is None or self._receiving.poll(timeout_s):
                message: bytes = self._receiving.recv_bytes()
                return message
        except (EOFError, OSError):
            self._is_drained = True
        return None

    def stop(self) -> None:
        """End the process, whatever it does."""
        self._process.kill()
        self._process.join()
        self._receiving.close()


@contextmanager
def _without_main() -> Iterator[None]:
    """Start a process that does not run the program's main module once more.

    Nothing that workers do is defined there, and a script without a guard would serve again.
    """
    before = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = before
