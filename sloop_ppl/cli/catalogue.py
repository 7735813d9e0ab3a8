"""`sloop list`."""

from __future__ import annotations

from typing import Annotated

import typer

from sloop_ppl.cli.options import Json
from sloop_ppl.cli.output import print_data, print_json

__all__ = ["list_names"]


def list_names(
    what: Annotated[
        str, typer.Argument(help="models, likelihoods, engines, planners, frames, priors or maps.")
    ],
    json: Json = False,
) -> None:
    """List what can be chosen."""
    from sloop_ppl.bridge.catalogue import names_of

    names = names_of(what)
    if json:
        print_json(names)
    else:
        print_data(*names)
