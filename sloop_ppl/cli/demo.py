"""`sloop demo`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sloop_ppl.cli.output import print_data

__all__ = ["demo"]


def demo(
    out: Annotated[Path, typer.Option(help="Folder for pictures and results.")] = Path("out"),
) -> None:
    """Read a bundled description, infer, search, and draw it all."""
    from sloop_ppl.bridge.demo import run_demo

    run_demo(out, show=print_data)
