"""Read files that others made: bounded in size and depth, with finite numbers, or one line of why.

Every reader of a JSON or TOML file goes through here, so that no exception of a parser, and no
number that is none, gets further than the file it is in.
"""

from __future__ import annotations

import json
import math
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from sloop_ppl.errors import InputError

__all__ = [
    "MOST_BYTES",
    "MOST_DEPTH",
    "ForeignFault",
    "is_file",
    "is_folder",
    "parse_json",
    "parse_toml",
    "read_text",
]

MOST_BYTES = 256 * 2**20
"""Bytes of a file that is read at all. As JSON it takes some ten times as much memory."""

MOST_DEPTH = 64
"""Lists and objects inside one another; the deepest file of the program has 9."""

_MOST_DIGITS = 300  # more overflow a float


class ForeignFault(ValueError):
    """What is wrong with a text, to be read after the name of its file."""


def is_file(path: str | Path) -> bool:
    """Tell whether there is a file; of a name that can be none, such as one too long, False."""
    try:
        return Path(path).is_file()
    except (OSError, ValueError):
        return False


def is_folder(path: str | Path) -> bool:
    """Tell whether there is a folder; of a name that can be none, False."""
    try:
        return Path(path).is_dir()
    except (OSError, ValueError):
        return False


def read_text(
    path: str | Path,
    what: str,
    *,
    hint: str = "",
    error: type[InputError] = InputError,
    most_bytes: int = MOST_BYTES,
) -> str:
    """Return a text file, as UTF-8 with or without a byte order mark.

    Parameters
    ----------
    path
        The file; a pipe is read too, as far as `most_bytes`.
    what
        What to call it, such as ``"Targets file"``.
    hint
        What to add when it is not there, such as ``"; expected ..."``.
    error
        What to raise.
    most_bytes
        More are refused before they are read.

    Raises
    ------
    InputError
        When it is missing, is no text, or is too large; as `error`.
    """
    name = _short(path)
    try:
        with Path(path).open("rb") as file:
            data = file.read(most_bytes + 1)
    except OSError as reason:
        raise error(
            f"{what} '{name}' cannot be read: {reason.strerror or reason}{hint}"
        ) from reason
    except ValueError as reason:  # a NUL in the path
        raise error(f"{what} '{name}' cannot be read: {reason}{hint}") from reason
    if len(data) > most_bytes:
        raise error(
            f"{what} '{name}' is larger than {most_bytes / 2**20:g} MiB; expected a smaller file"
        )
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as reason:
        raise error(
            f"{what} '{name}' cannot be read: no text in UTF-8 (byte {reason.start + 1}); save it "
            "as UTF-8"
        ) from reason


def parse_json(text: str, *, finite: bool = True) -> Any:
    """Return what a JSON text holds.

    Parameters
    ----------
    text
        The text.
    finite
        Refuse NaN and infinity; False where who checks the record names their field.

    Raises
    ------
    ForeignFault
        For what is no JSON, a number that is not finite, half a character, or more than
        `MOST_DEPTH` levels.

    Examples
    --------
    >>> parse_json('{"kappa": NaN}')
    Traceback (most recent call last):
    sloop_ppl._foreign.ForeignFault: it holds the number NaN; expected finite ones
    """
    try:
        if finite:
            value = json.loads(text, parse_constant=_refused, parse_float=_float, parse_int=_int)
        else:
            value = json.loads(text, parse_int=_int)
    except RecursionError:
        raise _too_deep() from None
    except ForeignFault:
        raise
    except ValueError as reason:
        raise ForeignFault(str(reason)) from reason
    _check_depth(value)
    if re.search(r"\\u[dD][89a-fA-F]", text):  # escapes that mean a character two by two
        try:
            json.dumps(value, ensure_ascii=False).encode()
        except UnicodeEncodeError as reason:
            raise ForeignFault("it holds half a character, \\ud800 to \\udfff") from reason
    return value


def parse_toml(text: str) -> dict[str, Any]:
    """Return what a TOML text holds.

    Raises
    ------
    ForeignFault
        As in `parse_json`; numbers that are not finite are left to who knows their name.
    """
    try:
        value = tomllib.loads(text)
    except RecursionError:
        raise _too_deep() from None
    except Exception as reason:  # some versions let IndexError and the like out
        raise ForeignFault(" ".join(str(reason).split())) from reason
    _check_depth(value)
    for number in re.findall(rf"\d{{{_MOST_DIGITS + 1},}}", text.replace("_", "")):
        _refused(f"{number[:20]}...")
    return value


def _short(path: str | Path) -> str:
    text = str(path)
    return text if len(text) <= 200 else f"{text[:100]}...{text[-60:]}"


def _refused(name: str) -> Any:
    raise ForeignFault(f"it holds the number {name}; expected finite ones")


def _float(digits: str) -> float:
    number = float(digits)
    return number if math.isfinite(number) else _refused(digits[:40])


def _int(digits: str) -> int:
    return int(digits) if len(digits) <= _MOST_DIGITS else _refused(f"{digits[:20]}...")


def _too_deep() -> ForeignFault:
    return ForeignFault(f"more than {MOST_DEPTH} levels of lists and objects inside one another")


def _check_depth(value: Any) -> None:
    level = [value]
    for _ in range(MOST_DEPTH + 1):
        level = [
            inner
            for one in level
            if isinstance(one, list | Mapping)
            for inner in (one.values() if isinstance(one, Mapping) else one)
            if isinstance(inner, list | Mapping)
        ]
        if not level:
            return
    raise _too_deep()
