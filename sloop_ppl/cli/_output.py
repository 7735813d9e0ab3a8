"""Print data to stdout and progress to stderr."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import typer
from rich.console import Console

__all__ = ["print_data", "print_json", "progress"]


def print_json(value: Any) -> None:
    """Print a value as JSON on stdout, keys in their own order, one line."""
    with _reader_may_leave():
        typer.echo(json.dumps(value, ensure_ascii=False, allow_nan=False))


def print_data(*lines: Any) -> None:
    """Print text or rich renderables on stdout."""
    console = Console(highlight=False)
    with _reader_may_leave():
        for line in lines:
            if isinstance(line, str):
                typer.echo(line)
            else:
                console.print(line)


def progress(line: str) -> None:
    """Print a line of progress on stderr."""
    typer.echo(line, err=True)


@contextmanager
def _reader_may_leave() -> Iterator[None]:
    """End the command quietly when whoever reads stdout has closed it, as `head` does."""
    try:
        yield
    except BrokenPipeError:
        # Python flushes stdout at exit, which would raise again: what is left goes nowhere.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise typer.Exit from None
