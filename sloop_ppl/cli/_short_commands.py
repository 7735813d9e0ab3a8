"""`sloop demo`, `sloop list` and `sloop warmup`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sloop_ppl.cli._options import Json
from sloop_ppl.cli._output import print_data, print_json, progress

__all__ = ["demo", "list_names", "warmup"]


def demo(
    out: Annotated[Path, typer.Option(help="Folder for pictures and results.")] = Path("out"),
) -> None:
    """Read a bundled description, infer, search, and draw it all."""
    from sloop_ppl.bridge._demo import run_demo

    run_demo(out, show=print_data)


def list_names(
    what: Annotated[
        str,
        typer.Argument(
            help="models, likelihoods, engines, planners, frames, priors, questions or maps."
        ),
    ],
    json: Json = False,
) -> None:
    """List what can be chosen."""
    from sloop_ppl.bridge._catalogue import names_of

    names = names_of(what)
    if json:
        print_json(names)
    else:
        print_data(*names)


def warmup() -> None:
    """Compile the planner ahead of its first search; what it makes is kept.

    Where no cache folder can be written, nothing is kept, and each process compiles anew.
    """
    from sloop_ppl.planning import notify_compiling, warm_up
    from sloop_ppl.planning._compile import COMPILING

    with notify_compiling(lambda: progress(COMPILING)):
        done = warm_up()
    where = f"kept in {done.folder}" if done.folder else "no cache folder can be written: not kept"
    progress(f"the planner's machine code: {done.seconds:.1f} s, {where}")
