"""Show on stderr how far a sweep is."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

from sloop_ppl.cli._output import progress

if TYPE_CHECKING:
    from sloop_ppl.eval._sweep import SweepProgress

__all__ = ["sweep_progress"]

# Seconds between lines where no terminal can show a bar.
_EVERY_S = 20.0


@contextmanager
def sweep_progress() -> Iterator[Callable[[SweepProgress], None]]:
    """Give what shows how far a sweep is: a bar on a terminal, else a line now and then."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield _lines()
        return
    columns = (BarColumn(), MofNCompleteColumn(), TextColumn("{task.description}"))
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task("")

        def show(now: SweepProgress) -> None:
            bar.update(task, total=now.total, completed=now.done, description=_left(now))

        yield show


def _lines() -> Callable[[SweepProgress], None]:
    last = -_EVERY_S

    def show(now: SweepProgress) -> None:
        nonlocal last
        if time.monotonic() - last >= _EVERY_S or now.done == now.total:
            last = time.monotonic()
            progress(f"{now.done} of {now.total} trials{_left(now) and f', {_left(now)}'}")

    return show


def _left(now: SweepProgress) -> str:
    """Return the time left in words; nothing while it is not known."""
    if now.seconds_left is None:
        return ""
    minutes, seconds = divmod(round(now.seconds_left), 60)
    hours, minutes = divmod(minutes, 60)
    duration = f"{hours} h {minutes} min" if hours else f"{minutes} min {seconds} s"
    return f"{duration if hours or minutes else f'{seconds} s'} left"
