"""Damage files in ways that happen, and in ways that only an attacker thinks of; from a seed."""

from __future__ import annotations

import copy
import json
import random
from typing import Any

ODD: tuple[Any, ...] = (
    *(None, True, False, 0, -1, 1, 0.5, -0.0, 1e308, -1e308, 1e-320, 10**19, -(10**40), 10**400),
    *(float("nan"), float("inf"), float("-inf"), "", " ", "NaN", "1", "x" * 3000, "\ud800", "a\nb"),
    *("<img src=x>", "=1+1", "../../x", "\0", [], {}, [[]], [{}], {"": {}}, [None] * 50),
    [0.5, 1.5],
)


def deep(levels: int) -> Any:
    """Return a list in a list, and so on."""
    value: Any = []
    for _ in range(levels):
        value = [value]
    return value


def damaged_value(value: Any, rng: random.Random) -> Any:
    """Return JSON data with one to three of its parts replaced, removed or repeated."""
    whole = [copy.deepcopy(value)]
    for _ in range(rng.randint(1, 3)):
        holder, key = rng.choice(_places(whole))
        what = rng.random()
        if what < 0.6:
            holder[key] = copy.deepcopy(rng.choice(ODD))
        elif what < 0.65:
            holder[key] = deep(rng.choice([70, 300]))
        elif what < 0.8 and holder is not whole:
            del holder[key]
        elif isinstance(holder, list) and holder is not whole:
            holder.insert(key, copy.deepcopy(holder[key]))
        elif isinstance(holder, dict):
            holder[rng.choice(["", "extra", "id", key + "s"])] = holder[key]
    return whole[0]


def _places(value: Any) -> list[tuple[Any, Any]]:
    """Return every place of a value; shallow ones come as often as deep ones together."""
    levels: list[list[tuple[Any, Any]]] = []
    level = [value]
    while level:
        keys = [
            (one, key)
            for one in level
            for key in (one if isinstance(one, dict) else range(len(one)))
        ]
        if keys:
            levels.append(keys)
        level = [one[key] for one, key in keys if isinstance(one[key], dict | list)]
    most = max(map(len, levels))
    return [place for keys in levels for place in keys * max(1, most // len(keys) // 4)]


def damaged_bytes(data: bytes, rng: random.Random) -> bytes:
    """Return bytes cut, changed, removed or repeated in one to four places."""
    changed = bytearray(data)
    for _ in range(rng.randint(1, 4)):
        at = rng.randrange(len(changed) or 1)
        length = min(rng.choice([1, 1, 2, 8, 200]), len(changed) - at)
        what = rng.random()
        if what < 0.15:
            del changed[at:]
        elif what < 0.4:
            del changed[at : at + length]
        elif what < 0.7:
            changed[at : at + length] = rng.randbytes(length)
        elif what < 0.85:
            changed[at:at] = changed[at : at + length] * rng.choice([1, 3, 400])
        else:
            changed[at:at] = rng.choice([b"[" * 200, b'{"a":' * 80, b"\xff", b"\0", b"1" * 500])
    return bytes(changed)


def damaged_json(text: str, rng: random.Random) -> bytes:
    """Return a JSON text damaged as data, as text, or both."""
    data = text.encode()
    if rng.random() < 0.7:
        written = json.dumps(damaged_value(json.loads(text), rng))
        data = written.encode("utf-8", "surrogatepass")
    if rng.random() < 0.4:
        data = damaged_bytes(data, rng)
    return data
