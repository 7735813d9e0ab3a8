"""Keep each fit on disk as soon as it is made, so that a command that was stopped goes on there."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import msgspec

from sloop_ppl._foreign import ForeignFault, parse_json, read_text
from sloop_ppl.errors import InputError, OutputError
from sloop_ppl.eval._manifest import changes
from sloop_ppl.inference.learning import Fitted
from sloop_ppl.outputs import check_output_folder, written_whole

__all__ = ["KeptFits"]

_FORMAT = "sloop_ppl fits"


class _Fit(msgspec.Struct, forbid_unknown_fields=True):
    """What a file of one fit holds."""

    model: str
    maps: list[str]
    fitted: Fitted


class KeptFits:
    """A folder of finished fits, a file for each, and of what they were made of.

    Parameters
    ----------
    path
        The folder; it is made with the first fit that is kept.
    made_of
        All that the fits depend on, as JSON takes it. Fits made of anything else are not used,
        and go when the first new one is kept.
    notify
        Told in one line of what is there already.

    Raises
    ------
    InputError
        When there is something else in the place of the folder.
    """

    def __init__(
        self,
        path: str | Path,
        made_of: Mapping[str, Any],
        notify: Callable[[str], None] | None = None,
    ) -> None:
        self.path = Path(path)
        self._made_of: dict[str, Any] = json.loads(json.dumps({"format": _FORMAT, **made_of}))
        self._usable = False
        if not self.path.exists() or (self.path.is_dir() and not any(self.path.iterdir())):
            return
        there = _read(self._manifest)
        if there is None or there.get("format") != _FORMAT:
            raise InputError(
                f"'{path}' is no folder of fits; finished fits are kept there: move it away, or "
                "choose another --out"
            )
        differing = changes(there, self._made_of)
        self._usable = not differing
        if notify and differing:
            notify(f"{path} holds fits of something else ({'; '.join(differing)}): starting anew")
        elif notify and self.count:
            notify(f"finished fits taken from {path}: {self.count}")

    @property
    def count(self) -> int:
        """How many fits there are."""
        return len(self._files()) if self._usable else 0

    def get(self, model: str, maps: Iterable[str]) -> Fitted | None:
        """Return the fit of a model to some maps, if it is there."""
        record = _read(self._file(model, maps)) if self._usable else None
        try:
            kept = msgspec.convert(record, _Fit)
        except msgspec.ValidationError:
            return None
        return kept.fitted if (kept.model, kept.maps) == (model, sorted(maps)) else None

    def keep(self, model: str, maps: Iterable[str], fitted: Fitted) -> None:
        """Write a fit, whole or not at all.

        Raises
        ------
        OutputError
            When it cannot be written.
        """
        check_output_folder(self.path)
        if not self._usable:
            for old in self._files():
                old.unlink(missing_ok=True)
            _write(self._manifest, self._made_of)
            self._usable = True
        record = {"model": model, "maps": sorted(maps), "fitted": fitted.to_json()}
        _write(self._file(model, maps), record)

    def remove(self) -> None:
        """Remove the folder, once what the fits were made for has been written."""
        if self._usable:
            for file in (*self._files(), self._manifest):
                file.unlink(missing_ok=True)
            if not any(self.path.iterdir()):
                self.path.rmdir()

    @property
    def _manifest(self) -> Path:
        return self.path / "manifest.json"

    def _files(self) -> list[Path]:
        return sorted(self.path.glob("fit-*.json"))

    def _file(self, model: str, maps: Iterable[str]) -> Path:
        digest = hashlib.sha256(json.dumps([model, sorted(maps)]).encode()).hexdigest()
        return self.path / f"fit-{digest[:16]}.json"


def _read(path: Path) -> dict[str, Any] | None:
    try:
        record = parse_json(read_text(path, "Fit"))
    except (ForeignFault, InputError):
        return None
    return record if isinstance(record, dict) else None


def _write(path: Path, record: Mapping[str, Any]) -> None:
    try:
        with written_whole(path) as whole:
            whole.write_text(json.dumps(record, indent=1, allow_nan=False) + "\n", "utf-8")
    except OSError as error:
        raise OutputError(f"'{path}' cannot be written: {error.strerror}") from error
