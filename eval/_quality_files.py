"""Score models' beliefs on description files, and word the scores."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from sloop_ppl._foreign import ForeignFault, parse_json, read_text
from sloop_ppl.bridge._requests import model_of
from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.eval._fits import cross_validated
from sloop_ppl.eval._inventory import map_finder
from sloop_ppl.eval._quality_report import quality_figure, quality_tables
from sloop_ppl.eval._table_lines import table_lines
from sloop_ppl.eval._user_metrics import metrics_with
from sloop_ppl.eval.descriptions import read_to_score
from sloop_ppl.eval.quality import BeliefQuality, score_beliefs
from sloop_ppl.models import PRESETS, ObservationModel, fitting_note

if TYPE_CHECKING:
    from rich.console import RenderableType

__all__ = ["PAPER_METHODS", "draw_quality", "models_named", "quality_lines", "score_quality"]

PAPER_METHODS = ("uniform", "keyword", "informed", "sloop", "sloop-m2", "sloop-m4")
"""The paper's methods, which a file of parameters leaves alone unless it names them."""


def score_quality(
    files: Sequence[str | Path],
    *,
    maps: str | Path | None = None,
    gold: bool = True,
    models: str | None = None,
    params: str | Path | None = None,
    cv: str | None = None,
    fits: str | Path | None = None,
    progress: Callable[[str], None] | None = None,
    metrics: Sequence[str] = (),
    annotations: str | Path | Sequence[str | Path] | None = None,
    learn_from: Sequence[str | Path] = (),
) -> BeliefQuality:
    """Score models' beliefs on some files.

    Parameters
    ----------
    files
        Description files.
    maps
        Folder of map files; None for the bundled maps.
    gold
        True for the gold relations, False for what the parser reads.
    models
        Names, separated by commas; all registered ones when None.
    params
        File of parameters; see `models_named`.
    cv
        ``"city"`` to score each line with parameters refitted, on the gold relations, to the lines
        of the other maps; the paper's methods keep theirs. None for no refitting.
    fits
        File in which the refitted models are kept for the next command; see
        :func:`sloop_ppl.eval._fits.cross_validated`.
    progress
        Called with a line at a time on how it goes.
    metrics
        ``FILE.py:NAME`` of metrics beside the registered ones.
    annotations
        Files of gold for lines that have none; see :func:`read_descriptions`.
    learn_from
        Further description files that `cv` learns from.

    Raises
    ------
    SloopError
        When a file, a name or a parameter cannot be used; before the work.
    """
    chosen, measured = models_named(models, params), metrics_with(metrics)
    if cv not in (None, "city"):
        raise UnknownName("cross-validation", str(cv), ["city"])
    find = map_finder(maps)
    descriptions, others, faults = read_to_score(files, learn_from, find, annotations)
    if faults:
        raise InputError("; ".join(faults))
    fitted = {name: model for name, model in chosen.items() if name not in PAPER_METHODS}
    if progress and not cv:  # else they are fitted below
        for note in filter(None, map(fitting_note, chosen.values())):
            progress(note)
    refits = {}
    if cv:
        refits = cross_validated(
            descriptions, fitted, find, learn_from=others, kept=fits, progress=progress
        )
    quality = score_beliefs(
        descriptions,
        {**chosen, **refits},
        find,
        relations="gold" if gold else "parsed",
        rng=np.random.default_rng(0),
        progress=progress,
        metrics=measured,
    )
    return replace(
        quality, cv=cv, sets={name: replace(one, cv=cv) for name, one in quality.sets.items()}
    )


def models_named(
    names: str | None, params: str | Path | None = None
) -> dict[str, ObservationModel]:
    """Return name -> model for names separated by commas, all registered ones for None.

    Parameters
    ----------
    names
        Registered names, or ``FILE.py:NAME``.
    params
        File of parameters. They are those of the model it names in a member ``model``, else of
        every model given that is none of the paper's methods.

    Raises
    ------
    InputError
        For an empty or repeated name, or parameters that are of none of the models.
    UnknownName
        For a name or a parameter that there is none of.
    """
    asked = list(PRESETS) if names is None else [name.strip() for name in names.split(",")]
    if "" in asked or len(set(asked)) < len(asked):
        raise InputError(f"Models '{names}' hold an empty or repeated name; give each once")
    if params is None:
        return {name: model_of(name) for name in asked}
    tuned_model = _model_of_parameters(params)
    tuned = [tuned_model] if tuned_model else [name for name in asked if name not in PAPER_METHODS]
    if not set(tuned) & set(asked):
        raise InputError(
            f"Parameters '{params}' are of none of the models {', '.join(asked)}"
            + (
                f" but of '{tuned_model}'"
                if tuned_model
                else "; the paper's methods keep their own"
            )
        )
    return {name: model_of(name, params=Path(params) if name in tuned else None) for name in asked}


def quality_lines(quality: BeliefQuality) -> list[RenderableType]:
    """Return all tables, each below its title, for printing."""
    return [line for table in quality_tables(quality.to_json()) for line in table_lines(table)]


def draw_quality(quality: BeliefQuality, path: str | Path) -> None:
    """Write the figure of the scores and of the coverage.

    Raises
    ------
    InputError
        When the ending of the path is of no known format.
    OutputError
        When the file cannot be written.
    """
    from sloop_ppl.plots import save_figure

    save_figure(quality_figure(quality.to_json()), path)


def _model_of_parameters(params: str | Path) -> str | None:
    """Return the model that a file of learnt parameters says it is of, if it says one."""
    if Path(params).suffix != ".json":
        return None
    try:
        payload = parse_json(read_text(params, "Parameter file"))
    except (InputError, ForeignFault):
        return None  # what is wrong is said by whoever reads the parameters
    tuned_model = (
        payload.get("model") if isinstance(payload, dict) and "parameters" in payload else None
    )
    return tuned_model if isinstance(tuned_model, str) else None
