"""Refit models without a line's city, and keep the fits for the next command."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import cloudpickle

import sloop_ppl
from sloop_ppl.errors import OutputError
from sloop_ppl.eval._manifest import git_state, model_digest, packages
from sloop_ppl.eval.crossval import refitted
from sloop_ppl.eval.descriptions import AnnotatedDescription
from sloop_ppl.maps import CityMap
from sloop_ppl.models import ObservationModel
from sloop_ppl.outputs import written_whole

__all__ = ["cross_validated"]

Fits = dict[str, dict[str, ObservationModel]]


def cross_validated(
    descriptions: Sequence[AnnotatedDescription],
    models: Mapping[str, ObservationModel],
    find_map: Callable[[str], CityMap],
    *,
    kept: str | Path | None = None,
    progress: Callable[[str], None] | None = None,
) -> Fits:
    """Return name -> map -> the model fitted to the descriptions of all other maps.

    Parameters
    ----------
    descriptions
        Scenes of at least two maps.
    models
        Name -> where its fit starts.
    find_map
        Gives the map of a description by name.
    kept
        File of fits. Those of the same descriptions, maps, models, code and packages are taken from
        it; others are made and written to it. It is a pickle: read only files of your own.
    progress
        Called with a line at a time on how it goes.

    Raises
    ------
    InputError
        When all descriptions are of one map.
    OutputError
        When the file cannot be written.
    """
    key = _key(descriptions, models, find_map)
    found = _read(kept, key)
    if found is not None:
        if progress:
            progress(f"fits taken from {kept}")
        return found
    fits = {
        name: refitted(descriptions, model, find_map, progress=progress)
        for name, model in models.items()
    }
    if kept is not None and fits:
        try:
            with written_whole(kept) as whole:
                whole.write_bytes(cloudpickle.dumps((key, fits)))
        except OSError as error:
            raise OutputError(f"'{kept}' cannot be written: {error.strerror}") from error
    return fits


def _key(
    descriptions: Sequence[AnnotatedDescription],
    models: Mapping[str, ObservationModel],
    find_map: Callable[[str], CityMap],
) -> dict[str, Any]:
    """Return all that the fits depend on."""
    return {
        "descriptions": [repr(annotated) for annotated in descriptions],
        "maps": {annotated.map: find_map(annotated.map).digest for annotated in descriptions},
        "models": {name: model_digest(name, model) for name, model in models.items()},
        "code": (sloop_ppl.__version__, git_state(), packages()),
    }


def _read(kept: str | Path | None, key: dict[str, Any]) -> Fits | None:
    if kept is None or not Path(kept).is_file():
        return None
    try:
        of, fits = pickle.loads(Path(kept).read_bytes())
    except Exception:  # of another program or version: made anew
        return None
    made: Fits = fits
    return made if of == key else None
