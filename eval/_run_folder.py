"""The folder of a sweep: its manifest, what the targets are, its trials, and one writer at most."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sloop_ppl._foreign import ForeignFault, parse_json, read_text
from sloop_ppl.errors import InputError, OutputError
from sloop_ppl.eval._driver_watch import wait_for_workers
from sloop_ppl.eval._facts import TargetFacts
from sloop_ppl.eval._manifest import changes
from sloop_ppl.eval._trial_files import read_trials
from sloop_ppl.eval.trials import Trial
from sloop_ppl.outputs import check_output_folder, written_whole

__all__ = ["FORMAT", "RunFolder", "read_run", "writing"]

FORMAT = "sloop_ppl sweep"
_VERSION = 1
_MANIFEST, _TARGETS, _PARTS, _LOCK = "manifest.json", "targets.json", "parts", ".lock"


@dataclass(frozen=True)
class RunFolder:
    """A sweep on disk.

    Parameters
    ----------
    path
        The folder.
    manifest
        What the sweep was made of.
    targets
        The described targets, with what was said of each.
    """

    path: Path
    manifest: Mapping[str, Any]
    targets: tuple[TargetFacts, ...]

    @property
    def parts(self) -> Path:
        """Where the workers write."""
        return self.path / _PARTS

    @property
    def examples(self) -> Path:
        """Where the episodes of a few example trials lie."""
        return self.path / "examples"

    @property
    def parquet(self) -> Path:
        """Where all trials lie as one table once the sweep has ended."""
        return self.path / "trials.parquet"

    def trials(self) -> list[Trial]:
        """Return the trials done so far, sorted by key."""
        return read_trials(self.parts)


def read_run(path: str | Path) -> RunFolder:
    """Return the sweep that a folder holds.

    Raises
    ------
    InputError
        When it holds none, or one of another version of the format.
    """
    folder = Path(path)
    manifest = _read(folder / _MANIFEST)
    if not isinstance(manifest, dict) or manifest.get("format") != FORMAT:
        raise InputError(
            f"'{folder / _MANIFEST}' is no manifest of a sweep; expected a folder that "
            "`sloop eval search --out` made"
        )
    if manifest.get("format_version") != _VERSION:
        raise InputError(
            f"The sweep in '{folder}' has version {manifest.get('format_version')}; this program "
            f"reads version {_VERSION}: run it again"
        )
    targets = tuple(TargetFacts.from_json(record) for record in _read(folder / _TARGETS))
    return RunFolder(folder, manifest, targets)


@contextmanager
def writing(
    path: str | Path, manifest: Mapping[str, Any], targets: Sequence[TargetFacts]
) -> Iterator[RunFolder]:
    """Give the folder of a sweep to its one writer: a new one, or one that holds this very sweep.

    Parameters
    ----------
    path
        The folder; made if need be.
    manifest
        What the sweep is made of; `FORMAT` and its version are added.

    Raises
    ------
    OutputError
        When the folder cannot be written to, holds something else, or is being written by another
        process.
    InputError
        When it holds another sweep; the message says what differs.
    """
    folder = check_output_folder(path)
    whole = {"format": FORMAT, "format_version": _VERSION, **manifest}
    held = {entry.name for entry in folder.iterdir() if not entry.name.startswith(".")}
    if held and _MANIFEST not in held and held - {_TARGETS, _PARTS}:
        raise OutputError(
            f"Output folder '{path}' holds {sorted(held)[0]} and no manifest of a sweep; expected "
            "a new or an empty folder, or one of this sweep"
        )
    with _locked(folder):
        if _MANIFEST in held:
            differing = changes(read_run(folder).manifest, whole)
            if differing:
                raise InputError(
                    f"Output folder '{path}' holds another sweep: {'; '.join(differing)}. Choose "
                    "another folder, or go back to what that sweep was made of"
                )
        else:
            _write(folder / _TARGETS, [facts.to_json() for facts in targets])
            (folder / _PARTS).mkdir(exist_ok=True)
            _write(folder / _MANIFEST, whole)  # the last, so that a folder with one is complete
        yield read_run(folder)


@contextmanager
def _locked(folder: Path) -> Iterator[None]:
    """Hold the folder; the lock goes with the process, however that ends."""
    try:
        import fcntl
    except ImportError:  # Windows: two writers would do the same trials twice, no harm else
        yield
        return
    with (folder / _LOCK).open("a") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            raise OutputError(
                f"Output folder '{folder}' is being written by another sweep; wait until it has "
                "ended, or choose another folder"
            ) from error
        wait_for_workers(folder)
        yield


def _read(path: Path) -> Any:
    text = read_text(path, "File", hint="; expected a folder that `sloop eval search --out` made")
    try:
        return parse_json(text, finite=False)
    except ForeignFault as error:
        raise InputError(f"'{path}' is not JSON: {error}") from error


def _write(path: Path, value: Any) -> None:
    try:
        with written_whole(path) as whole, whole.open("w", encoding="utf-8") as file:
            file.write(json.dumps(value, indent=1, ensure_ascii=False) + "\n")
            file.flush()
            os.fsync(file.fileno())
    except OSError as error:
        raise OutputError(f"'{path}' cannot be written: {error.strerror}") from error
