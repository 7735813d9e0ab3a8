"""The `sloop` command: each command is a thin shell over one library function."""

from sloop_ppl.cli.app import main

__all__ = ["main"]
