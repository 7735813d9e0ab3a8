"""An extension of griffe: of parameters described together, each has its own type and default."""

from __future__ import annotations

from typing import Any

import griffe

__all__ = ["OwnTypes"]


class OwnTypes(griffe.Extension):
    """Give each of ``a, b`` in a docstring its own type; griffe gives all that of the first."""

    def on_package(self, *, pkg: griffe.Module, **_: Any) -> None:
        """Mend the parsed docstrings of a package."""
        _mend(pkg)


def _mend(parent: griffe.Module | griffe.Class) -> None:
    for member in parent.members.values():
        if member.is_alias or not isinstance(member, griffe.Object):
            continue
        if isinstance(member, griffe.Class | griffe.Function) and member.docstring is not None:
            _mend_parameters(member)
        if isinstance(member, griffe.Module | griffe.Class):
            _mend(member)


def _mend_parameters(owner: griffe.Class | griffe.Function) -> None:
    assert owner.docstring is not None
    known = {parameter.name: parameter for parameter in owner.parameters}
    for section in owner.docstring.parsed:
        if section.kind is not griffe.DocstringSectionKind.parameters:
            continue
        for described in section.value:
            own = known.get(described.name.lstrip("*"))
            if own is not None:
                described.annotation, described.value = own.annotation, own.default
