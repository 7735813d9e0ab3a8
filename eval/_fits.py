"""Refit models without a line's city, and keep the numbers for the next command."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import msgspec

import sloop_ppl
from sloop_ppl._foreign import ForeignFault, parse_json, read_text
from sloop_ppl.errors import InputError, OutputError
from sloop_ppl.eval._manifest import git_state, model_digest, packages
from sloop_ppl.eval.crossval import refits
from sloop_ppl.eval.descriptions import AnnotatedDescription
from sloop_ppl.maps import CityMap
from sloop_ppl.models import ObservationModel, unfitted
from sloop_ppl.models.tuning import with_parameters
from sloop_ppl.outputs import check_output, written_whole

__all__ = ["cross_validated"]

Fits = dict[str, dict[str, ObservationModel]]
Numbers = dict[str, dict[str, dict[str, dict[str, float]]]]  # model -> map -> section -> name

_FORMAT = "sloop_ppl refitted models"
_REMEDY = "remove it, or give another file with --fits"


class _Kept(msgspec.Struct, forbid_unknown_fields=True):
    """What a file of fits holds: what they were made of, and their numbers."""

    format: str
    key: dict[str, Any]
    fits: Numbers


def cross_validated(
    descriptions: Sequence[AnnotatedDescription],
    models: Mapping[str, ObservationModel],
    find_map: Callable[[str], CityMap],
    *,
    learn_from: Sequence[AnnotatedDescription] = (),
    kept: str | Path | None = None,
    progress: Callable[[str], None] | None = None,
) -> Fits:
    """Return name -> map -> the model fitted to the descriptions of all other cities.

    Parameters
    ----------
    descriptions
        Scenes of at least two maps.
    models
        Name -> where its fit starts.
    find_map
        Gives the map of a description by name.
    learn_from
        Further descriptions to learn from, of other cities or of the same; those that are among
        `descriptions` count once.
    kept
        JSON file of the fitted numbers. Those of the same descriptions, maps, models, code and
        packages are taken from it; others are made and written to it.
    progress
        Called with a line at a time on how it goes.

    Raises
    ------
    InputError
        When all descriptions are of one map, or the file is no file of fits.
    OutputError
        When the file cannot be written.
    """
    by_id = {one.id: one for one in (*learn_from, *descriptions)}
    descriptions = [by_id[name] for name in sorted(by_id)]  # one order, whichever are scored
    key = _key(descriptions, models, find_map)
    numbers = None if kept is None else _read(Path(kept), key)
    if numbers is not None:
        try:
            found = _applied(models, numbers)
        except InputError as error:
            raise InputError(f"Fits '{kept}' cannot be used: {error}; {_REMEDY}") from error
        if progress:
            progress(f"fits taken from {kept}")
        return found
    if kept is not None:
        check_output(kept, (Path(kept).suffix.lower(),))  # before the work
    numbers = {
        name: {
            left_out: {section: dict(values) for section, values in fitted.parameters.items()}
            for left_out, fitted in refits(descriptions, model, find_map, progress=progress).items()
        }
        for name, model in models.items()
    }
    if kept is not None and numbers:
        record = {"format": _FORMAT, "key": key, "fits": numbers}
        try:
            with written_whole(kept) as whole:
                whole.write_text(json.dumps(record, indent=1, allow_nan=False) + "\n", "utf-8")
        except OSError as error:
            raise OutputError(f"'{kept}' cannot be written: {error.strerror}") from error
    return _applied(models, numbers)


def _applied(models: Mapping[str, ObservationModel], numbers: Numbers) -> Fits:
    """Return the models with their numbers; a fit starts from the model before its own fit."""
    return {
        name: {
            left_out: with_parameters(unfitted(model), values)
            for left_out, values in numbers[name].items()
        }
        for name, model in models.items()
    }


def _key(
    descriptions: Sequence[AnnotatedDescription],
    models: Mapping[str, ObservationModel],
    find_map: Callable[[str], CityMap],
) -> dict[str, Any]:
    """Return all that the fits depend on, as JSON gives it back."""
    record = "\n".join(repr(annotated) for annotated in descriptions)
    return {
        "descriptions": hashlib.sha256(record.encode()).hexdigest(),
        "maps": {annotated.map: find_map(annotated.map).digest for annotated in descriptions},
        "models": {name: model_digest(name, model) for name, model in models.items()},
        "sloop_ppl": sloop_ppl.__version__,
        "git": git_state(),
        "packages": packages(),
    }


def _read(kept: Path, key: Mapping[str, Any]) -> Numbers | None:
    """Return the numbers of a file when they are of this key; none when they are of another.

    Raises
    ------
    InputError
        When there is a file that holds no fits, such as the pickle of an earlier version.
    """
    if not os.path.lexists(kept):
        return None
    try:
        made = msgspec.convert(parse_json(read_text(kept, "Fits")), _Kept)
    except (InputError, ForeignFault, msgspec.ValidationError) as error:
        raise _no_fits(kept) from error
    if made.format != _FORMAT:
        raise _no_fits(kept)
    if made.key != key:
        return None
    maps = set(key["maps"])
    if set(made.fits) != set(key["models"]) or any(set(of) != maps for of in made.fits.values()):
        raise InputError(f"Fits '{kept}' lack a model or a map of their key; {_REMEDY}")
    return made.fits


def _no_fits(kept: Path) -> InputError:
    return InputError(
        f"'{kept}' is no JSON file of fits (those of earlier versions are not read); {_REMEDY}"
    )
