"""Take typed fields out of parsed JSON, naming the field at fault by its path."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

__all__ = ["Fault", "Record"]


class Fault(Exception):
    """What is wrong with one field of one line; the reader turns it into an InputError.

    Attributes
    ----------
    field
        Path of the field, such as ``"targets.RedBike.east_m"``.
    what
        What was found and what was expected, to be read after the field.
    """

    def __init__(self, field: str, what: str) -> None:
        self.field, self.what = field, what
        super().__init__(f"field '{field}' {what}")


class Record:
    """A JSON object whose fields are taken out by type.

    Parameters
    ----------
    data
        The parsed object.
    path
        What stands before its fields' names in messages.
    """

    def __init__(self, data: Mapping[str, Any], path: str = "") -> None:
        self._data, self.path = data, path

    def __contains__(self, name: str) -> bool:
        return name in self._data

    def fault(self, name: str, what: str) -> Fault:
        """Return the fault of one field, for the caller to raise."""
        return Fault(self.path + name, what)

    def text(self, name: str, default: str | None = None) -> str:
        """Return a non-empty string, or `default` where the field is absent and one is given."""
        if name not in self._data and default is not None:
            return default
        value = self._get(name, "a text")
        if not isinstance(value, str) or not value.strip():
            raise self.fault(name, f"is {value!r}; expected a text")
        return value

    def optional_text(self, name: str) -> str | None:
        """Return a non-empty string, or None where the field is absent or null."""
        return None if self._data.get(name) is None else self.text(name)

    def number(self, name: str) -> float:
        """Return a finite number."""
        return self._finite(name, self._get(name, "a number"))

    def pair(self, name: str) -> tuple[float, float]:
        """Return two finite numbers."""
        value = self._get(name, "two numbers")
        if not isinstance(value, list) or len(value) != 2:
            raise self.fault(name, f"is {value!r}; expected two numbers")
        return self._finite(name, value[0]), self._finite(name, value[1])

    def optional_numbers(self, name: str, count: int) -> tuple[float, ...] | None:
        """Return so many finite numbers, None where the field is absent or null."""
        value = self._data.get(name)
        if value is None:
            return None
        if not isinstance(value, list) or len(value) != count:
            raise self.fault(name, f"is {value!r}; expected {count} numbers")
        return tuple(self._finite(name, number) for number in value)

    def optional_record(self, name: str) -> Record | None:
        """Return an object, None where the field is absent or null."""
        value = self._data.get(name)
        return None if value is None else self._child(name, value)

    def flag(self, name: str) -> bool:
        """Return a truth value, False where the field is absent."""
        value = self._data.get(name, False)
        if not isinstance(value, bool):
            raise self.fault(name, f"is {value!r}; expected true or false")
        return value

    def group(self) -> int | str | None:
        """Return the name or number in the field ``group``, None where it is absent or null."""
        value = self._data.get("group")
        if value is not None and (isinstance(value, bool) or not isinstance(value, int | str)):
            raise self.fault("group", f"is {value!r}; expected a number or a text")
        return value

    def members(self, name: str) -> Iterator[tuple[str, Record]]:
        """Yield the members of an object of objects; nothing where the field is absent."""
        value = self._data.get(name, {})
        if not isinstance(value, Mapping):
            raise self.fault(name, f"is a {type(value).__name__}; expected an object")
        for key, member in value.items():
            yield key, self._child(f"{name}.{key}", member)

    def entries(self, name: str, *, required: bool = True) -> Iterator[Record]:
        """Yield the objects of a list; nothing where the field is absent and not required."""
        value = self._get(name, "a list") if required else self._data.get(name, [])
        if not isinstance(value, list):
            raise self.fault(name, f"is a {type(value).__name__}; expected a list")
        for index, entry in enumerate(value):
            yield self._child(f"{name}[{index}]", entry)

    def _child(self, path: str, value: Any) -> Record:
        if not isinstance(value, Mapping):
            raise self.fault(path, f"is a {type(value).__name__}; expected an object")
        return Record(value, f"{self.path}{path}.")

    def _get(self, name: str, expected: str) -> Any:
        if name not in self._data:
            raise self.fault(name, f"is missing; expected {expected}")
        return self._data[name]

    def _finite(self, name: str, value: Any) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self.fault(name, f"is {value!r}; expected a finite number")
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            raise self.fault(name, f"is {value!r}; expected a finite number")
        return number
