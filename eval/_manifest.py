"""What a sweep was made of, and what of it changed since."""

from __future__ import annotations

import hashlib
import platform
import re
import subprocess
from collections.abc import Iterator, Mapping, Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import sloop_ppl
from sloop_ppl.errors import InputError
from sloop_ppl.models import ObservationModel

__all__ = ["changes", "file_digest", "git_state", "model_digest", "packages"]

_PACKAGES = (
    "numba", "numpy", "pomdp-py", "pyproj", "pyro-ppl", "scipy", "shapely", "spacy", "torch",
)  # fmt: skip
_RECORD_ONLY = frozenset({"created"})
_MOST = 6


def file_digest(path: str | Path) -> str:
    """Return the SHA-256 of a file's bytes, in hexadecimal.

    Raises
    ------
    InputError
        When it cannot be read.
    """
    try:
        return hashlib.sha256(Path(path).read_bytes()).hexdigest()
    except OSError as error:
        raise InputError(f"'{path}' cannot be read: {error.strerror}") from error


def model_digest(name: str, model: ObservationModel, params: str | Path | None = None) -> str:
    """Return a digest of a model: of its numbers, its file and its file of parameters."""
    text = re.sub(r" at 0x[0-9a-f]+", "", repr(model))
    file = Path(name.partition(".py:")[0] + ".py")
    for path in (file if ".py:" in name else None, params):
        if path is not None:
            text += file_digest(path)
    return hashlib.sha256(text.encode()).hexdigest()


def packages() -> dict[str, str]:
    """Return the versions of Python and of the packages that results depend on."""
    found = {"python": platform.python_version()}
    for name in _PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "absent"
    return found


def git_state() -> str | None:
    """Return the commit the package was run from, ``+changes`` where files of it were edited.

    None where it was not run from a checkout of its repository.
    """
    folder = Path(sloop_ppl.__file__).parent
    commit = _git(folder, "rev-parse", "HEAD")
    if commit is None or _git(folder, "ls-files", "--error-unmatch", "__init__.py") is None:
        return None
    changed = _git(folder.parent, "status", "--porcelain", "--untracked-files=no", "--", "*.py")
    return commit + ("+changes" if changed else "")


def _git(folder: Path, *arguments: str) -> str | None:
    try:
        done = subprocess.run(
            ["git", "-C", str(folder), *arguments],
            capture_output=True, text=True, check=True, timeout=20,
        )  # fmt: skip
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip()


def changes(before: Mapping[str, Any], now: Mapping[str, Any]) -> list[str]:
    """Return what differs between two manifests, a line each; times of making are passed over.

    Examples
    --------
    >>> changes({"seed": 0, "maps": {"a": "1"}}, {"seed": 1, "maps": {"a": "1"}})
    ['seed was 0 and is 1']
    """
    old, new = dict(_flat(before)), dict(_flat(now))
    lines = [
        f"{name} was {_text(old, name)} and is {_text(new, name)}"
        for name in dict.fromkeys([*old, *new])
        if old.get(name, ...) != new.get(name, ...) and name not in _RECORD_ONLY
    ]
    more = len(lines) - _MOST
    return lines if more <= 0 else [*lines[:_MOST], f"and {more} more"]


def _flat(record: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for name, value in record.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{prefix}{name}.")
        else:
            yield prefix + name, value


def _text(values: Mapping[str, Any], name: str) -> str:
    if name not in values:
        return "absent"
    value = values[name]
    if isinstance(value, Sequence) and not isinstance(value, str):
        return ",".join(f"{v:g}" if isinstance(v, float) else str(v) for v in value)
    return f"{value[:12]}…" if isinstance(value, str) and len(value) == 64 else str(value)
