"""Copy and pickle frozen values that hold read-only views of mappings."""

from __future__ import annotations

from types import MappingProxyType
from typing import Any

__all__ = ["ByValue"]


class _Viewed(dict[Any, Any]):
    """A mapping that was a view: Python neither copies nor pickles views."""


class ByValue:
    """A dataclass whose views are copied as mappings and become views again."""

    def __getstate__(self) -> dict[str, Any]:
        """Return the fields without views."""
        return {name: _plain(value) for name, value in self.__dict__.items()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Take what `__getstate__` gave."""
        for name, value in state.items():
            self.__dict__[name] = _as_view(value)


def _plain(value: Any) -> Any:
    if isinstance(value, MappingProxyType):
        return _Viewed({name: _plain(inner) for name, inner in value.items()})
    return tuple(map(_plain, value)) if type(value) is tuple else value


def _as_view(value: Any) -> Any:
    if isinstance(value, _Viewed):
        return MappingProxyType({name: _as_view(inner) for name, inner in value.items()})
    return tuple(map(_as_view, value)) if type(value) is tuple else value
