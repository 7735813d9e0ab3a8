"""End a worker whose driver has died, and hold the folder until it has ended.

A worker that outlives its driver would go on for minutes beside a driver that is started anew. It
looks for its driver twice a second, and holds a shared lock of the folder while it does a job; a
new driver waits for that lock.
"""

from __future__ import annotations

import os
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from sloop_ppl.errors import OutputError

__all__ = ["Driver", "end_with", "wait_for_workers", "working_in"]

_EVERY_S = 0.5
_PATIENCE_S = 8.0  # workers end within one or two seconds of their driver
_LOCK = ".workers.lock"
_WATCHED: set[Driver] = set()


@dataclass(frozen=True)
class Driver:
    """The process that hands out jobs: its number, and the machine that it is on."""

    pid: int
    host: str

    @staticmethod
    def this() -> Driver:
        """Return this process as a driver."""
        return Driver(os.getpid(), socket.gethostname())

    @property
    def is_this(self) -> bool:
        """Whether the driver works itself, as with one worker."""
        return self == Driver.this()

    def is_gone(self, parent: bool) -> bool:
        """Tell whether it has ended; of one on another machine that is not known.

        Parameters
        ----------
        parent
            Whether it was the parent of this process, which gets another one when it ends.
        """
        if self.host != socket.gethostname():
            return False
        if parent:
            return os.getppid() != self.pid
        try:
            os.kill(self.pid, 0)
        except ProcessLookupError:
            return True
        except OSError:
            return False
        return False


def end_with(driver: Driver, parent: bool | None = None) -> None:
    """End this process soon after its driver, once and for all; at once when it has ended.

    Parameters
    ----------
    driver
        Who handed out the job.
    parent
        Whether the driver is known to have started this process; found out when None.
    """
    if driver.is_this or os.name == "nt":
        return
    if parent is None:
        parent = os.getppid() == driver.pid
    if driver.is_gone(parent):
        os._exit(1)
    if driver not in _WATCHED:
        _WATCHED.add(driver)
        threading.Thread(target=_watch, args=(driver, parent), daemon=True).start()


def _watch(driver: Driver, parent: bool) -> None:
    while not driver.is_gone(parent):
        time.sleep(_EVERY_S)
    os._exit(1)  # a line that is half written is passed over by who reads it


@contextmanager
def working_in(folder: Path, driver: Driver) -> Iterator[None]:
    """Hold the folder of a sweep while a worker does a job; end when the driver has."""
    if driver.is_this:
        yield
        return
    with _opened(folder) as lock:
        _flock(lock, shared=True)
        end_with(driver)  # after the lock: a new driver has it, or waits for this process
        yield


def wait_for_workers(folder: Path) -> None:
    """Wait until the workers of a driver that died have ended.

    Raises
    ------
    OutputError
        When they have not after some seconds, as on a cluster of which the driver was no part.
    """
    end = time.monotonic() + _PATIENCE_S
    with _opened(folder) as lock:
        while not _flock(lock, shared=False):
            if time.monotonic() > end:
                raise OutputError(
                    f"Workers of a sweep that was stopped still write to '{folder}'; wait until "
                    "they have ended, or choose another folder"
                )
            time.sleep(0.1)


@contextmanager
def _opened(folder: Path) -> Iterator[int]:
    handle = os.open(folder / _LOCK, os.O_RDWR | os.O_CREAT, 0o666)
    try:
        yield handle
    finally:
        os.close(handle)


def _flock(handle: int, *, shared: bool) -> bool:
    """Take the lock if nobody holds it otherwise; True where files cannot be locked."""
    try:
        import fcntl
    except ImportError:  # Windows
        return True
    try:
        fcntl.flock(handle, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:  # a file system without locks
        return True
    return True
