"""Read a file that someone dropped into a page, in a process of its own with limits."""

from __future__ import annotations

import json
import sys
import tempfile
from collections.abc import Callable
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from sloop_ppl.errors import SloopError
from sloop_ppl.web import _limits
from sloop_ppl.web._refusal import Refusal
from sloop_ppl.web._workers import Worker

__all__ = ["FileReader", "read_dropped_file"]

FileReader = Callable[[Path, str], dict[str, Any]]
"""Reads a file by its path, with the name it is shown by; what it returns is JSON."""

_MORE_BYTES = 3 * 2**30


def read_dropped_file(reader: FileReader, content: bytes, name: str, what: str) -> dict[str, Any]:
    """Return what a reader makes of the content of a file.

    Parameters
    ----------
    reader
        A function of a module, which the process imports.
    content
        The file.
    name
        What the page calls it; it names nothing on the disk.
    what
        What the file should be, for messages.

    Raises
    ------
    Refusal
        When it cannot be read, or takes too long or too much.
    """
    with tempfile.TemporaryDirectory(prefix="sloop-") as folder:
        path = Path(folder) / "dropped"
        path.write_bytes(content)
        worker = Worker(_read_in_worker, reader, str(path), name)
        try:
            answer = worker.receive(_limits.SECONDS_FOR_A_FILE)
        finally:
            worker.stop()
    if answer is None:
        raise Refusal(422, f"{what} '{name}' takes too long or too much to read; try a smaller one")
    read: dict[str, Any] = json.loads(answer)
    if "error" in read:
        raise Refusal(422, read["error"])
    return read


def _read_in_worker(reader: FileReader, path: str, name: str, connection: Connection) -> None:
    """Send what was read, or ``{"error": ...}``, and end."""
    _limit_process()
    answer: dict[str, Any]
    try:
        answer = reader(Path(path), name)
    except SloopError as error:
        answer = {"error": str(error).replace(path, name)}
    except MemoryError:
        answer = {"error": f"'{name}' is too large to be read; try a smaller one"}
    connection.send_bytes(json.dumps(answer, allow_nan=False).encode())
    connection.close()


def _limit_process() -> None:
    """Bound memory and processor time, where the system can."""
    if sys.platform == "win32":
        return
    import resource

    pages = int(Path("/proc/self/statm").read_text().split()[0]) if _has_proc() else 0
    most = pages * resource.getpagesize() + _MORE_BYTES
    bounds: tuple[tuple[int, int], ...] = (
        (resource.RLIMIT_AS, most),
        (resource.RLIMIT_CPU, int(_limits.SECONDS_FOR_A_FILE)),
    )
    set_limit: Callable[..., None] = resource.setrlimit
    for what, value in bounds:
        set_limit(what, (value, value))


def _has_proc() -> bool:
    return Path("/proc/self/statm").exists()
