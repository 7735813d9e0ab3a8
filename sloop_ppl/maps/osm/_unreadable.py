"""Say in one line why libosmium refuses a file, and which node is at fault."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from sloop_ppl.errors import MapError

__all__ = ["unreadable"]

_COORDINATE = re.compile(r"coordinate: '([^']*)'|lon/lat: '?([^'\s]*)")


def unreadable(path: Path, error: Exception) -> MapError:
    """Return the one line for a file that libosmium refuses; it names the node at fault."""
    message = " ".join(str(error).split()) or type(error).__name__
    feature = name = None
    if found := _COORDINATE.search(message):
        value = found[2] if found[1] is None else found[1]
        if bearer := next(_bearers(path, value), None):
            feature, name = bearer
            message = f"{feature}: field '{name}' is {value!r}"
    return MapError(
        f"File '{path}' cannot be read as OpenStreetMap: {message}; expected .osm XML or .osm.pbf, "
        "whole",
        feature=feature,
        field=name,
    )


def _bearers(path: Path, value: str) -> Iterator[tuple[str, str]]:
    """Yield the nodes of an XML file that have a coordinate of this text, to name them."""
    node = re.compile(rb"<node\b[^>]*>")
    try:
        # 256 MiB: larger files are not read a second time only to name the node.
        content = path.read_bytes() if path.stat().st_size < 1 << 28 else b""
    except OSError:
        return
    for found in node.finditer(content):
        text = found[0].decode("utf-8", "replace")
        number = re.search(r"\bid=[\"'](-?\d+)", text)
        for name in ("lat", "lon"):
            if number and re.search(rf"\b{name}=[\"']{re.escape(value)}[\"']", text):
                yield f"node/{number[1]}", name
