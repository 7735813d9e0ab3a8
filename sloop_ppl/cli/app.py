"""Run a `sloop` command and turn what goes wrong into one line and an exit code."""

from __future__ import annotations

import atexit
import gc
import io
import os
import signal
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from types import FrameType

import typer
from typer.exceptions import TyperException

from sloop_ppl import __version__
from sloop_ppl._figure_backend import forget_missing_backend
from sloop_ppl.cli import (
    _asking,
    _belief,
    _evaluation,
    _fly,
    _frames,
    _language,
    _maps,
    _search,
    _short_commands,
    _web,
)
from sloop_ppl.errors import SloopError

__all__ = ["app", "main"]

# 128 + the number of the signal, as shells report it.
_STOPPED, _TERMINATED = 130, 143

app = typer.Typer(
    help="From what a person says about where something is to a belief over a city map, and to "
    "the search for it.",
    add_completion=False,
    no_args_is_help=True,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
)


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"sloop_ppl {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    _version: bool = typer.Option(
        False, "--version", callback=_print_version, is_eager=True, help="Print the version."
    ),
) -> None:
    pass


app.command("parse")(_language.parse)
app.command("infer")(_belief.infer)
app.command("ask")(_asking.ask)
app.command("search")(_search.search)
app.command("fly")(_fly.fly)
app.add_typer(_maps.app, name="map")
app.add_typer(_frames.app, name="frames")
app.add_typer(_evaluation.app, name="eval")
app.command("serve")(_web.serve)
app.add_typer(_web.collect_app, name="collect")
app.command("list")(_short_commands.list_names)
app.command("demo")(_short_commands.demo)
app.command("warmup")(_short_commands.warmup)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line and exit: 0 well, 2 a mistake, 1 a crash, 130 Ctrl-C, 143 SIGTERM."""
    # Tables of a city are too small to share out: more threads spin while they wait for each other.
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    command = typer.main.get_command(app)
    forget_missing_backend()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without curly quotes shows ?
    stops: list[int] = []
    try:
        with _seldom_collecting(), _stopped_by_sigterm(stops):
            code = command.main(arguments, prog_name="sloop", standalone_mode=False)
    except TyperException as error:
        _refuse(error.format_message() if hasattr(error, "format_message") else str(error))
    except SloopError as error:
        _refuse(str(error))
    except (typer.Abort, KeyboardInterrupt):
        code = _STOPPED
    if code == _STOPPED:  # typer itself answers Ctrl-C with this code
        sys.stderr.write("sloop: stopped\n")
        code = _TERMINATED if stops else _STOPPED
    sys.exit(code or 0)


@contextmanager
def _stopped_by_sigterm(stops: list[int]) -> Iterator[None]:
    """Treat SIGTERM as Ctrl-C, which keeps what was done; note in `stops` that it came."""
    if threading.current_thread() is not threading.main_thread():  # signals are the main one's
        yield
        return

    def stop(number: int, _frame: FrameType | None) -> None:
        stops.append(number)
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, stop)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


@contextmanager
def _seldom_collecting() -> Iterator[None]:
    """Collect garbage less often, and none at exit.

    A command spends most of its time loading modules, of which none is ever garbage: to walk
    through them again and again, and once more at the end, would take up to a second.
    """
    before = gc.get_threshold()
    # Allocations between collections of the three generations; Python has 700, 10, 10.
    gc.set_threshold(50_000, 20, 100)
    # Frozen objects are not walked at exit; unregistered first, for main may run more than once.
    atexit.unregister(gc.freeze)
    atexit.register(gc.freeze)
    try:
        yield
    finally:
        gc.set_threshold(*before)


def _refuse(message: str) -> None:
    """Print one line on stderr and exit with code 2; without a message, help was shown: 0."""
    if not message:
        sys.exit(0)
    sys.stderr.write(f"sloop: {' '.join(message.split())}\n")
    sys.exit(2)
