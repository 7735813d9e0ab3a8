"""Check that results can be written before the work, and write them whole or not at all."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from sloop_ppl.errors import OutputError, on_one_line

__all__ = ["check_output", "check_output_folder", "written_whole"]


def check_output(path: str | Path, endings: Sequence[str]) -> Path:
    """Return the path when a file with one of the endings can be written there.

    Parameters
    ----------
    path
        Where the file shall go.
    endings
        Accepted endings with their dot, such as ``(".png", ".pdf")``.

    Raises
    ------
    OutputError
        When the ending is another, the folder is missing or cannot be written to.
    """
    target = Path(path)
    if target.suffix.lower() not in endings:
        raise OutputError(
            f"Output '{path}' ends in '{target.suffix}'; expected one of {', '.join(endings)}"
        )
    folder = target.parent
    try:
        os.lstat(target)
    except (FileNotFoundError, NotADirectoryError):
        pass  # said below, where the folder is missing
    except (OSError, ValueError) as error:  # a name too long, a NUL in it, a folder that is closed
        reason = getattr(error, "strerror", None) or error
        raise OutputError(
            f"Output '{on_one_line(str(path))}' cannot be written: {reason}"
        ) from error
    if not folder.is_dir():
        raise OutputError(f"Output '{path}': folder '{folder}' does not exist; make it first")
    if target.is_dir():
        raise OutputError(f"Output '{path}' is a folder; give the name of a file")
    if target.exists() and not os.access(target, os.W_OK):
        raise OutputError(f"Output '{path}' cannot be written: permission denied")
    _try_writing(folder, path)
    return target


def check_output_folder(path: str | Path) -> Path:
    """Return the folder at `path`, made if need be.

    Raises
    ------
    OutputError
        When it cannot be made or written to.
    """
    folder = Path(path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"Output folder '{path}' cannot be made: {error.strerror}") from error
    _try_writing(folder, path)
    return folder


def _try_writing(folder: Path, path: str | Path) -> None:
    try:
        with tempfile.NamedTemporaryFile(prefix=".", dir=folder):
            pass
    except OSError as error:
        raise OutputError(f"Output '{path}' cannot be written: {error.strerror}") from error


@contextmanager
def written_whole(path: str | Path) -> Iterator[Path]:
    """Give a temporary path beside `path` that takes its place once the block ends well."""
    target = Path(path)
    handle, name = tempfile.mkstemp(prefix=".", suffix=target.suffix, dir=target.parent)
    os.close(handle)
    try:
        yield Path(name)
        umask = os.umask(0)
        os.umask(umask)
        Path(name).chmod(0o666 & ~umask)
        Path(name).replace(target)
    finally:
        Path(name).unlink(missing_ok=True)
