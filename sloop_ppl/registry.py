"""Look things up by the name a user types, and say what there is when the name is wrong."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import Generic, TypeVar

from sloop_ppl.errors import UnknownName

__all__ = ["Registry"]

T = TypeVar("T")


@dataclass(frozen=True)
class _Later:
    """Where an entry is found that is not loaded yet."""

    module: str
    attribute: str


class Registry(Mapping[str, T], Generic[T]):
    """Names and what they stand for, in the order they were added.

    Parameters
    ----------
    kind
        What is registered, such as ``"model"``; used in messages.

    Raises
    ------
    UnknownName
        By looking up a name that is not registered; it lists those that are.
    """

    def __init__(self, kind: str) -> None:
        self.kind = kind
        self.changes = 0  # what is derived from the entries is made anew when it grows
        self._entries: dict[str, T | _Later] = {}

    def add(self, name: str, entry: T) -> T:
        """Register `entry` as `name` and return it; a name is taken only once."""
        self._put(name, entry)
        return entry

    def remove(self, name: str) -> T:
        """Take an entry out again, such as one that is to be replaced, and return it."""
        entry = self[name]
        del self._entries[name]
        self.changes += 1
        return entry

    def add_later(self, name: str, module: str, attribute: str) -> None:
        """Register what a module holds, which is imported when the name is first looked up."""
        self._put(name, _Later(module, attribute))

    def __getitem__(self, name: str) -> T:
        if name not in self._entries:
            raise UnknownName(self.kind, name, self._entries)
        entry = self._entries[name]
        if not isinstance(entry, _Later):
            return entry
        found: T = getattr(import_module(entry.module), entry.attribute)
        self._entries[name] = found
        return found

    def __contains__(self, name: object) -> bool:
        return name in self._entries

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)

    def _put(self, name: str, entry: T | _Later) -> None:
        if name in self._entries:
            raise ValueError(f"{self.kind} '{name}' is registered already; choose another name")
        self._entries[name] = entry
        self.changes += 1
