"""The page on the commands, made of what ``--help`` says."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Any

from typer.main import get_command

from sloop_ppl.cli.app import app

__all__ = ["command_line_page"]

_HEAD = """\
# Command line

`sloop COMMAND --help` says the same. Data go to stdout, as JSON with `--json`; progress goes to
stderr. A mistake of the user is one line and exit code 2, a crash is 1, Ctrl-C 130, SIGTERM 143.
"""


@cache
def command_line_page() -> str:
    """Return the page in Markdown."""
    return "\n".join([_HEAD, *(part for one in _leaves("sloop", get_command(app)) for part in one)])


def _leaves(path: str, command: Any) -> Iterator[list[str]]:
    """Yield the lines of each command that does something."""
    if hasattr(command, "commands"):
        for name in sorted(command.commands):
            if not command.commands[name].hidden:
                yield from _leaves(f"{path} {name}", command.commands[name])
        return
    yield [f"\n## {path}\n", _plain(command.help or ""), "", *_table(command)]


def _table(command: Any) -> Iterator[str]:
    yield "| option | |"
    yield "| --- | --- |"
    for one in command.params:
        if getattr(one, "hidden", False) or one.name == "help":
            continue
        argument = one.param_type_name == "argument"
        names = one.name.upper() if argument else ", ".join([*one.opts, *one.secondary_opts])
        text = _plain(getattr(one, "help", None) or "")
        yield f"| `{names}` | {text.replace('|', chr(92) + '|')} |"


def _plain(text: str) -> str:
    """Return help as one paragraph whose signs mean nothing to Markdown or HTML."""
    text = " ".join(text.replace("\b", " ").split())
    for sign in "<*_[":
        text = text.replace(sign, "&#" + str(ord(sign)) + ";") if "`" not in text else text
    return text
