"""A file of JSON lines that is only added to: one writer at a time, nothing lost that was saved."""

from __future__ import annotations

import codecs
import json
import os
import sys
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

from sloop_ppl._foreign import ForeignFault, parse_json
from sloop_ppl.errors import InputError, OutputError

__all__ = ["Journal"]


class Journal:
    """A file of JSON lines.

    Parameters
    ----------
    path
        The file; it and its folder are made with the first line.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._lock = threading.Lock()

    @property
    def shown(self) -> str:
        """What the file is called on a page: its name and folder, not the way there."""
        return f"{self.path.parent.name}/{self.path.name}"

    def append(self, record: Mapping[str, Any]) -> None:
        """Add a line; it is on the disk when this returns.

        What a crash left of a line that was never whole is removed.

        Raises
        ------
        OutputError
            When it cannot be written.
        """
        line = json.dumps(dict(record), ensure_ascii=False, allow_nan=False).encode() + b"\n"
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            with self._lock, self.path.open("a+b") as file, _locked(file):
                file.truncate(_whole_bytes(file))
                file.write(line)
                file.flush()
                os.fsync(file.fileno())
        except OSError as error:
            raise OutputError(f"'{self.path}' cannot be written: {error.strerror}") from error

    def records(self) -> list[dict[str, Any]]:
        """Return what was saved, in order; none when there is no file.

        Raises
        ------
        InputError
            When a line is no JSON object.
        """
        try:
            with self._lock, self.path.open("rb") as file:
                data = file.read(_whole_bytes(file))
        except FileNotFoundError:
            return []
        except OSError as error:
            raise InputError(f"'{self.path}' cannot be read: {error.strerror}") from error
        found = []
        for number, line in enumerate(data.removeprefix(codecs.BOM_UTF8).split(b"\n"), start=1):
            if not line.strip():
                continue
            try:
                record = parse_json(line.decode())
            except (ForeignFault, UnicodeDecodeError) as error:
                raise InputError(f"{self.path}:{number}: is not JSON: {error}") from error
            if not isinstance(record, dict):
                raise InputError(f"{self.path}:{number}: is no JSON object")
            found.append(record)
        return found


def _whole_bytes(file: IO[bytes]) -> int:
    """Return where the last whole line ends; the file is then at its start."""
    size = end = file.seek(0, os.SEEK_END)
    while end:
        start = max(0, end - 4096)
        file.seek(start)
        at = file.read(end - start).rfind(b"\n")
        if at >= 0:
            size = start + at + 1
            break
        end = size = start
    file.seek(0)
    return size


@contextmanager
def _locked(file: IO[bytes]) -> Iterator[None]:
    """Keep other processes from writing meanwhile."""
    if sys.platform == "win32":
        import msvcrt

        file.seek(0)
        msvcrt.locking(file.fileno(), msvcrt.LK_LOCK, 1)
        try:
            yield
        finally:
            file.seek(0)
            msvcrt.locking(file.fileno(), msvcrt.LK_UNLCK, 1)
    else:
        import fcntl

        fcntl.flock(file, fcntl.LOCK_EX)  # freed when the file is closed
        yield
