"""The folder of a sweep: its manifest, what the targets are, its trials, and one writer at most."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sloop_ppl._foreign import ForeignFault, is_file, parse_json, read_text
from sloop_ppl._records import Fault, checked
from sloop_ppl.errors import InputError, OutputError
from sloop_ppl.eval._driver_watch import wait_for_workers
from sloop_ppl.eval._facts import TargetFacts
from sloop_ppl.eval._manifest import changes
from sloop_ppl.eval._run_records import ManifestRecord
from sloop_ppl.eval._trial_files import read_trials
from sloop_ppl.eval.trials import Trial
from sloop_ppl.outputs import check_output_folder, written_whole

__all__ = ["FORMAT", "RunFolder", "read_run", "writing"]

FORMAT = "sloop_ppl sweep"
_VERSION = 1
_MANIFEST, _TARGETS, _PARTS, _LOCK = "manifest.json", "targets.json", "parts", ".lock"
_TARGETS_DIGEST = "targets"  # in the manifest


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
        """Return the trials done so far, sorted by key.

        Raises
        ------
        InputError
            When a line is no trial, or one of another sweep.
        """
        places = {(t.description, t.target): (t.map, t.configuration) for t in self.targets}
        models, ranges = set(self.manifest["model_names"]), set(self.manifest["ranges_cells"])

        def belongs(trial: Trial) -> bool:
            key = trial.key
            return (
                places.get((key.description, key.target)) == (trial.map, trial.configuration)
                and key.model in models
                and key.range_cells in ranges
                and key.start < self.manifest["starts"]
            )

        return read_trials(self.parts, belongs)


def read_run(path: str | Path) -> RunFolder:
    """Return the sweep that a folder holds.

    Raises
    ------
    InputError
        When it holds none, one of another version of the format, or one that was changed.
    """
    folder = Path(path)
    manifest = _manifest(folder)
    try:
        checked(manifest, ManifestRecord)
    except Fault as fault:
        raise InputError(
            f"'{folder / _MANIFEST}' was changed: {fault}; give the same `sloop eval search` "
            "command with another --out to run the sweep anew"
        ) from fault
    records = _read(folder / _TARGETS)
    known = _digest(records)
    if manifest.get(_TARGETS_DIGEST, known) != known:  # earlier sweeps have none
        raise InputError(
            f"'{folder / _TARGETS}' is not what this sweep wrote; give the same `sloop eval "
            "search` command again to restore it"
        )
    if not isinstance(records, list):
        raise InputError(f"'{folder / _TARGETS}' is a {type(records).__name__}; expected a list")
    return RunFolder(folder, manifest, tuple(map(TargetFacts.from_json, records)))


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
    records = [facts.to_json() for facts in targets]
    whole = {
        "format": FORMAT,
        "format_version": _VERSION,
        **manifest,
        _TARGETS_DIGEST: _digest(records),
    }
    held = {entry.name for entry in folder.iterdir() if not entry.name.startswith(".")}
    if held and _MANIFEST not in held and held - {_TARGETS, _PARTS}:
        raise OutputError(
            f"Output folder '{path}' holds {sorted(held)[0]} and no manifest of a sweep; expected "
            "a new or an empty folder, or one of this sweep"
        )
    if _MANIFEST not in held and any((folder / _PARTS).glob("*")):
        raise OutputError(
            f"Output folder '{path}' holds trials and no manifest, so that they may be of another "
            "sweep; put the manifest back, or choose another folder"
        )
    with _locked(folder):
        if _MANIFEST in held:
            differing = changes(_manifest(folder), whole)
            if differing:
                raise InputError(
                    f"Output folder '{path}' holds another sweep: {'; '.join(differing)}. Choose "
                    "another folder, or go back to what that sweep was made of"
                )
        if not _is_whole(folder / _TARGETS, records):
            _write(folder / _TARGETS, records)
        if not (folder / _PARTS).is_dir():
            _make(folder / _PARTS)
        if _MANIFEST not in held:
            _write(folder / _MANIFEST, whole)  # the last, so that a folder with one is complete
        yield RunFolder(folder, _manifest(folder), tuple(targets))


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


def _manifest(folder: Path) -> Mapping[str, Any]:
    """Return the manifest of a sweep's folder, of this version of the format."""
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
    return manifest


def _digest(value: Any) -> str:
    return hashlib.sha256(json.dumps(value, sort_keys=True).encode()).hexdigest()


def _is_whole(path: Path, value: Any) -> bool:
    """Tell whether a file holds a value."""
    try:
        return is_file(path) and _digest(_read(path)) == _digest(value)
    except InputError:  # damaged
        return False


def _make(folder: Path) -> None:
    try:
        folder.mkdir()
    except OSError as error:
        raise OutputError(f"'{folder}' cannot be made: {error.strerror}") from error


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
