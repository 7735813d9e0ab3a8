"""Fit a model to description files, choose among several, and keep how that was done."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from sloop_ppl import __version__
from sloop_ppl.errors import InputError
from sloop_ppl.eval._candidates import CANDIDATES, FAMILIES
from sloop_ppl.eval._inventory import map_finder
from sloop_ppl.eval._kept_fits import KeptFits
from sloop_ppl.eval._manifest import file_digest, git_state, model_digest, packages
from sloop_ppl.eval._quality_files import models_named
from sloop_ppl.eval._quality_report import quality_tables
from sloop_ppl.eval._selection import Selection, select_model
from sloop_ppl.eval._tables import Estimate, Table
from sloop_ppl.eval.descriptions import annotation_files, read_descriptions
from sloop_ppl.inference.learning import Fitted
from sloop_ppl.models import PRESETS, ObservationModel, unfitted
from sloop_ppl.outputs import check_output

__all__ = ["candidates_named", "fit_files", "fit_tables"]

_REFERENCE = "sloop-m4"


def fit_files(
    files: Sequence[str | Path],
    *,
    out: str | Path,
    models: str | None = None,
    maps: str | Path | None = None,
    annotations: str | Path | Sequence[str | Path] | None = None,
    progress: Callable[[str], None] | None = None,
) -> tuple[Selection, Fitted]:
    """Fit models to files, each map left out in turn; keep the best one's numbers.

    Parameters
    ----------
    files
        Description files, of at least three maps (two for a single model).
    out
        JSON file of the numbers, which ``--params`` reads.
    models
        Candidates, separated by commas; the likelihood families when None.
    maps
        Folder of map files; None for the bundled maps.
    annotations
        Files of gold for lines that have none; see :func:`read_descriptions`.
    progress
        Called with a line per fit, and one per round of it.

    Returns
    -------
    tuple
        How the model was chosen, and what was written.

    Raises
    ------
    SloopError
        When a file or a name cannot be used; before the work.

    Notes
    -----
    Each finished fit is kept in a folder beside `out` that ends in ``.fits``, until the numbers
    are written. Asked again, it takes those that were made of the same descriptions, maps,
    models, code and packages; others are made anew.
    """
    chosen = candidates_named(models)
    check_output(out, (".json",))
    find = map_finder(maps)
    descriptions = read_descriptions(files, find, annotations)
    extra = [] if annotations is None else annotation_files(annotations)
    read = [*files, *extra]
    names = [Path(file).name for file in read]
    digests = {
        name if names.count(name) == 1 else str(file): file_digest(file)
        for name, file in zip(names, read, strict=True)
    }
    made_of = {
        "sloop_ppl": __version__,
        "git": git_state(),
        "packages": packages(),
        "descriptions": digests,
        "maps": {name: find(name).digest for name in dict.fromkeys(s.map for s in descriptions)},
        "models": {name: model_digest(name, model) for name, model in chosen.items()},
    }
    kept = KeptFits(Path(out).with_suffix(".fits"), made_of, progress)
    try:
        selection = select_model(
            descriptions,
            chosen,
            find,
            references={_REFERENCE: PRESETS[_REFERENCE]},
            kept=kept,
            progress=progress,
        )
    except KeyboardInterrupt:
        if progress and kept.count:
            progress(f"finished fits kept in {kept.path}: {kept.count}; the same command goes on")
        raise
    fitted = replace(
        selection.fitted,
        provenance={
            **selection.fitted.provenance,
            "sloop_ppl": __version__,
            "descriptions": digests,
            "selection": selection.to_json(),
        },
    )
    fitted.save(out)
    kept.remove()
    return selection, fitted


def candidates_named(names: str | None) -> dict[str, ObservationModel]:
    """Return name -> model to fit: candidates, registered models, or ``FILE.py:NAME``.

    Parameters
    ----------
    names
        Separated by commas; the likelihood families when None.

    Raises
    ------
    SloopError
        For a name that there is none of, given twice, or empty.
    """
    asked = list(FAMILIES) if names is None else [name.strip() for name in names.split(",")]
    if len(set(asked)) < len(asked):
        raise InputError(f"Models '{names}' name one twice; give each once")
    return {
        name: CANDIDATES[name] if name in CANDIDATES else unfitted(models_named(name)[name])
        for name in asked
    }


def fit_tables(selection: Selection, fitted: Fitted) -> list[Table]:
    """Return the scores with each map left out, what was chosen where, and the numbers."""
    scores, *_ = quality_tables(selection.quality.to_json())
    tables = [replace(scores, title="Scores with the map left out")]
    if selection.inner:
        tables.append(_choice(selection))
    moved: Mapping[str, float] = fitted.provenance["moved"]
    rows = []
    for section, numbers in fitted.parameters.items():
        for name, value in numbers.items():
            ends = fitted.intervals.get(section, {}).get(name, (math.nan, math.nan))
            away = moved[f"weights:{name}" if section == "weights" else name]
            estimate = Estimate(value, *ends, digits=2)
            rows.append((section, name, estimate, Estimate(away, digits=2)))
    tables.append(
        Table(
            name="parameters",
            title=f"Numbers of {selection.winner}, fitted to all maps",
            head=("section", "name", "value", "moved (prior sd)"),
            rows=tuple(rows),
            notes=("An interval as wide as the prior, and no move: the data do not tell.",),
        )
    )
    return tables


def _choice(selection: Selection) -> Table:
    names = tuple(next(iter(selection.inner.values())))
    return Table(
        name="choice",
        title="Mean log score inside the folds, which chooses",
        head=("map left out", *names, "chosen"),
        rows=tuple(
            (left_out, *(scores[name] for name in names), selection.chosen[left_out])
            for left_out, scores in selection.inner.items()
        ),
    )
