"""Packages that only an extra installs: one line that says which, before they are imported."""

from __future__ import annotations

from importlib.util import find_spec

from sloop_ppl.errors import InputError

__all__ = ["need_extra"]


def need_extra(purpose: str, package: str, extra: str) -> None:
    """Refuse to go on without a package, before any work is done.

    Parameters
    ----------
    purpose
        What needs it, as the beginning of a sentence.
    package
        Name of the package, as it is imported.
    extra
        The extra of this package that installs it.

    Raises
    ------
    InputError
        When it is not installed.
    """
    if find_spec(package) is None:
        raise InputError(
            f"{purpose} needs {package}, which is not installed; run pip install "
            f"'sloop-ppl[{extra}]'"
        )
