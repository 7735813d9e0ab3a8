"""Tell the form of an OpenStreetMap file by its content, whatever it is called."""

from __future__ import annotations

import bz2
import gzip
import re
from pathlib import Path
from typing import Any

from sloop_ppl.errors import MapError

__all__ = ["JSON_FORM", "content", "form_of", "holds"]

JSON_FORM = "json"
"""The form of Overpass JSON and GeoJSON; the others are names of libosmium's formats."""

# Enough for a header, a licence in a comment and the start of the root element.
_HEAD_BYTES = 8192
_ROOT = re.compile(rb"<([A-Za-z][\w:.-]*)")
_COMMENT = re.compile(rb"<!--.*?-->", re.DOTALL)
_XML_ROOTS = {b"osm": "osm", b"osmChange": "osc"}
_OTHER_ROOTS = {
    b"html": "a web page, perhaps an error of the server",
    b"HTML": "a web page, perhaps an error of the server",
    b"gpx": "GPX",
    b"kml": "KML",
    b"svg": "an SVG figure",
    b"diff": "an augmented diff",
}
# 1 GiB: a JSON text takes some ten times its size once it is parsed.
_MAX_JSON_BYTES = 1 << 30
_CHUNK_BYTES = 1 << 20


def form_of(path: Path) -> str:
    """Return the form of a file: a name of libosmium's formats, `JSON_FORM`, or ``""`` if unknown.

    Raises
    ------
    MapError
        When the file cannot be read, or is plainly something else.
    """
    try:
        with path.open("rb") as file:
            head = file.read(_HEAD_BYTES)
    except OSError as error:
        raise MapError(f"File '{path}' cannot be read: {error.strerror or error}") from None
    packed = {b"\x1f\x8b": ".gz", b"BZ": ".bz2"}.get(head[:2], "")
    if packed:
        try:
            opener = gzip.open if packed == ".gz" else bz2.open
            with opener(path) as file:
                head = file.read(_HEAD_BYTES)
        except (OSError, EOFError, ValueError):
            return ""
    return _form(head, path, packed)


def content(path: Path) -> bytes:
    """Return the bytes of a file, unpacked when it is compressed.

    Raises
    ------
    MapError
        When it cannot be unpacked, or is too large to be read as text.
    """
    try:
        with _unpacked(path) as file:
            data: bytes = file.read(_MAX_JSON_BYTES + 1)
    except (OSError, EOFError, ValueError) as error:
        raise MapError(f"File '{path}' cannot be read: {error}") from None
    if len(data) > _MAX_JSON_BYTES:
        raise MapError(f"File '{path}' is over 1 GiB; expected less: take an .osm.pbf of the place")
    return data


def holds(path: Path, pattern: re.Pattern[bytes]) -> bool:
    """Tell whether a file, unpacked, has a piece of up to 4 KiB that fits a pattern."""
    before = b""
    try:
        with _unpacked(path) as file:
            while chunk := file.read(_CHUNK_BYTES):
                if pattern.search(before + chunk):
                    return True
                before = chunk[-4096:]
    except (OSError, EOFError, ValueError):
        return False
    return False


def _unpacked(path: Path) -> Any:
    with path.open("rb") as file:
        magic = file.read(2)
    openers: dict[bytes, Any] = {b"\x1f\x8b": gzip.open, b"BZ": bz2.open}
    return openers.get(magic, open)(path, "rb")


def _form(head: bytes, path: Path, packed: str) -> str:
    # A PBF file starts with the length of its first header, in four bytes, and its type.
    if head[4:6] == b"\n\t" and head[6:15] == b"OSMHeader":
        return "pbf"
    if head.startswith(b"\xff\xe0\x04o5"):
        return "o5m"
    if head.startswith(b"PK\x03\x04"):
        raise MapError(f"File '{path}' is a zip archive; unpack it and import what is in it")
    text = head.removeprefix(b"\xef\xbb\xbf").lstrip()
    # In UTF-16, as PowerShell writes, every other byte of JSON is zero.
    if text.removeprefix(b"\xff\xfe").removeprefix(b"\xfe\xff").strip(b"\0")[:1] in (b"{", b"["):
        return JSON_FORM
    if text[:1] == b"<" and (root := _ROOT.search(_COMMENT.sub(b"", text))):
        if root[1] in _OTHER_ROOTS:
            raise MapError(
                f"File '{path}' is {_OTHER_ROOTS[root[1]]}; expected OpenStreetMap data: .osm XML, "
                ".osm.pbf, Overpass JSON or GeoJSON with tags"
            )
        if root[1] in _XML_ROOTS:
            return _XML_ROOTS[root[1]] + packed
    return ""
