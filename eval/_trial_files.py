"""The trials of a sweep on disk: one file of lines per worker, read back as one table."""

from __future__ import annotations

import json
import os
import secrets
import socket
from collections.abc import Callable, Iterator
from pathlib import Path

from sloop_ppl._foreign import parse_json
from sloop_ppl.errors import InputError, OutputError
from sloop_ppl.eval.trials import Trial

__all__ = ["append_trial", "read_trials", "write_parquet"]

_TOKEN = secrets.token_hex(4)
# Tells this process from any other that had its number before.


def append_trial(folder: str | Path, trial: Trial) -> None:
    """Write a trial to the part of this process, before anything else is done.

    Parameters
    ----------
    folder
        Where the parts lie; it exists.

    Raises
    ------
    OutputError
        When it cannot be written, as on a full disk; the part is as it was before.

    Notes
    -----
    The line is handed to the operating system whole, so that it outlives the process, however
    that ends.
    """
    name = f"part-{socket.gethostname()}-{os.getpid()}-{_TOKEN}.jsonl"
    path = Path(folder) / name
    line = (json.dumps(trial.to_json(), allow_nan=False) + "\n").encode()
    try:
        handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o666)
        try:
            _write_whole(handle, line)
        finally:
            os.close(handle)
    except OSError as error:
        raise OutputError(
            f"Trial cannot be written to '{path}': {error.strerror}; what is done stays valid: "
            "make room and give the same command again"
        ) from error


def _write_whole(handle: int, line: bytes) -> None:
    """Append a line, or nothing of it."""
    before = os.fstat(handle).st_size
    left = memoryview(line)
    try:
        while left:
            left = left[os.write(handle, left) :]
    except OSError:
        os.ftruncate(handle, before)
        raise


def read_trials(folder: str | Path, belongs: Callable[[Trial], bool] | None = None) -> list[Trial]:
    """Return the trials of all parts, each once, sorted by key.

    Parameters
    ----------
    folder
        Where the parts lie; nothing there is no trial.
    belongs
        Tells whether a trial is one of the sweep; all are when None.

    Raises
    ------
    InputError
        When a whole line is no trial, or one of another sweep.

    Notes
    -----
    A last line without its end was torn when the worker was killed; it is passed over. A trial
    that was done twice, by a worker that outlived its driver, is the same but for the time; the
    first is kept.
    """
    found: dict[object, Trial] = {}
    for path in sorted(Path(folder).glob("part-*.jsonl")):
        for number, line in _whole_lines(path):
            try:
                trial = Trial.from_json(parse_json(line.decode()))
                if belongs is not None and not belongs(trial):
                    raise InputError("is a trial of another sweep")
            except ValueError as error:  # InputError, ForeignFault and UnicodeDecodeError are such
                raise InputError(
                    f"'{path}', line {number}: {error}; delete the line or the file, and give the "
                    "same command again to do its trials anew"
                ) from error
            found.setdefault(trial.key, trial)
    return sorted(found.values(), key=lambda trial: trial.key)


def _whole_lines(path: Path) -> Iterator[tuple[int, bytes]]:
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InputError(f"'{path}' cannot be read: {error.strerror}") from error
    for number, line in enumerate(content.split(b"\n")[:-1], start=1):
        if line.strip():
            yield number, line


def write_parquet(trials: list[Trial], path: str | Path) -> None:
    """Write trials as one Parquet table, a column per member of `Trial.to_json`.

    Raises
    ------
    OutputError
        When the file cannot be written.
    """
    import pyarrow
    import pyarrow.parquet

    from sloop_ppl.outputs import written_whole

    table = pyarrow.Table.from_pylist([trial.to_json() for trial in trials])
    try:
        with written_whole(path) as whole:
            pyarrow.parquet.write_table(table, whole)
    except OSError as error:
        raise OutputError(f"'{path}' cannot be written: {error.strerror or error}") from error
