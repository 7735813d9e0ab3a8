"""Run the experiment on description files into a folder."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import joblib

import sloop_ppl
from sloop_ppl._extras import need_extra
from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.eval._answerers import AskingSettings
from sloop_ppl.eval._backends import check_backend
from sloop_ppl.eval._examples import has_examples, write_examples
from sloop_ppl.eval._facts import facts_of
from sloop_ppl.eval._fits import cross_validated
from sloop_ppl.eval._inventory import map_finder
from sloop_ppl.eval._manifest import file_digest, git_state, model_digest, packages
from sloop_ppl.eval._quality_files import PAPER_METHODS, models_named
from sloop_ppl.eval._run_folder import RunFolder, writing
from sloop_ppl.eval._sweep import SearchedDescription, Sweep, SweepProgress, run_sweep
from sloop_ppl.eval._trial_files import write_parquet
from sloop_ppl.eval.descriptions import (
    AnnotatedDescription,
    read_to_score,
)
from sloop_ppl.eval.quality import read_annotated, to_score
from sloop_ppl.eval.trials import Searching
from sloop_ppl.maps import CityMap
from sloop_ppl.models import ObservationModel, fitting_note
from sloop_ppl.planning.space import SearchSpace

__all__ = ["SweepRequest", "sweep_files"]


@dataclass(frozen=True)
class SweepRequest:
    """What ``sloop eval search`` is asked for.

    Parameters
    ----------
    files
        Description files.
    out
        Folder of the run.
    maps
        Folder of map files; None for the bundled maps.
    gold
        True for the gold relations, False for what the parser reads.
    models
        Names, separated by commas; all registered ones when None.
    params, cv, fits, annotations, learn_from
        As in :func:`sloop_ppl.eval._quality_files.score_quality`; the fits are kept in the folder
        of the run when no file is given.
    ranges
        Ranges of the sensor in cells, separated by commas.
    starts
        Starts per target, > 0.
    searching
        Planner, simulations and the like.
    primary
        The two models whose comparison, at the first range, is named before the run, as ``"a,b"``;
        by default ``bayes,sloop-m4`` where both are run, else the last and the first. One model
        alone is compared with nothing.
    skip_bad
        Pass over the lines that have a fault instead of refusing them.
    workers
        Processes; as many as there are processors when None.
    backend, address
        Where the trials run.
    questions
        How many questions may be asked, separated by commas; none when None.
    question_costs
        What a question costs, separated by commas.
    asking
        How it is asked, where `questions` is given.
    """

    files: Sequence[str | Path]
    out: str | Path
    maps: str | Path | None = None
    gold: bool = True
    models: str | None = None
    params: str | Path | None = None
    cv: str | None = None
    fits: str | Path | None = None
    annotations: Sequence[str | Path] = ()
    learn_from: Sequence[str | Path] = ()
    ranges: str = "3,4,5"
    starts: int = 1
    searching: Searching = Searching()  # noqa: RUF009 - frozen
    primary: str | None = None
    skip_bad: bool = False
    workers: int | None = None
    backend: str = "joblib"
    address: str | None = None
    questions: str | None = None
    question_costs: str = "10"
    asking: AskingSettings = AskingSettings()  # noqa: RUF009 - frozen


def sweep_files(
    request: SweepRequest,
    *,
    notify: Callable[[str], None] | None = None,
    progress: Callable[[SweepProgress], None] | None = None,
) -> RunFolder:
    """Run what is asked for and was not run yet; return the folder, which holds all trials then.

    Parameters
    ----------
    notify
        Called with a line of every fault that is passed over, and how a refitting goes.
    progress
        Called with how far the trials are.

    Raises
    ------
    SloopError
        When something cannot be used; before any work, as far as it can be known then.
    """
    notify = notify or _ignore
    workers = joblib.cpu_count() if request.workers is None else request.workers
    for name, count in (("workers", workers), ("starts", request.starts)):
        if count < 1:
            raise InputError(f"The number of {name} is {count}; expected at least 1")
    need_extra("The table of trials of a sweep", "pyarrow", "sweep")
    check_backend(request.backend, request.address)
    if request.cv not in (None, "city"):
        raise UnknownName("cross-validation", str(request.cv), ["city"])
    models = models_named(request.models, request.params)
    if not request.cv:  # else they are fitted below
        for note in filter(None, map(fitting_note, models.values())):
            notify(note)
    ranges = _ranges(request.ranges)
    find = map_finder(request.maps)
    descriptions, others = _with_targets(request, find, notify)
    for name in dict.fromkeys(annotated.map for annotated in descriptions):
        for range_cells in ranges:
            SearchSpace(find(name).grid.shape, ("T",), request.searching.config(range_cells))
    asked = _asked(request)
    manifest = _manifest(request, models, ranges, descriptions, find)
    targets = [
        facts for annotated in descriptions for facts in facts_of(annotated, find(annotated.map))
    ]
    with writing(request.out, manifest, targets) as folder:
        used: dict[str, ObservationModel | Mapping[str, ObservationModel]] = dict(models)
        entries = tuple(
            SearchedDescription(
                annotated, *read_annotated(annotated, find(annotated.map), _relations(request))
            )
            for annotated in descriptions
        )
        sweep = Sweep(entries, used, ranges, request.starts, request.searching, *asked)
        if len(folder.trials()) < folder.manifest["n_trials"] or not (
            asked[-1] is not None or has_examples(folder)
        ):
            if request.cv:
                fitted = {name: m for name, m in models.items() if name not in PAPER_METHODS}
                kept = request.fits or folder.path / "fits.json"
                used.update(
                    cross_validated(
                        descriptions, fitted, find, learn_from=others, kept=kept, progress=notify
                    )
                )
            run_sweep(
                sweep,
                folder,
                backend=request.backend,
                workers=workers,
                address=request.address,
                progress=progress,
            )
            if asked[-1] is None:
                write_examples(sweep, folder)
        write_parquet(folder.trials(), folder.parquet)
    return folder


def _ignore(line: str) -> None:
    del line


def _relations(request: SweepRequest) -> Any:
    return "gold" if request.gold else "parsed"


def _with_targets(
    request: SweepRequest, find: Callable[[str], CityMap], notify: Callable[[str], None]
) -> tuple[tuple[AnnotatedDescription, ...], tuple[AnnotatedDescription, ...]]:
    """Return the descriptions that tell a place, and what is learnt from beside them."""
    descriptions, others, faults = read_to_score(
        request.files, request.learn_from, find, list(request.annotations) or None
    )
    if faults and not request.skip_bad:
        raise InputError(
            f"{'; '.join(faults)}. Correct these lines, or pass over them with --skip-bad"
        )
    for fault in faults:
        notify(f"passed over {fault}")
    return tuple(to_score(descriptions, _relations(request), notify)), others


def _asked(
    request: SweepRequest,
) -> tuple[tuple[int, ...], tuple[float, ...], AskingSettings | None]:
    """Return numbers of questions, their costs, and how it is asked."""
    if request.questions is None:
        return (0,), (10.0,), None
    found: list[tuple[float, ...]] = []
    for what, given in (("questions", request.questions), ("costs", request.question_costs)):
        try:
            numbers = tuple(float(word) for word in given.split(","))
        except ValueError:
            numbers = ()
        usable = all(math.isfinite(n) and n >= 0 for n in numbers)
        whole = what == "costs" or all(n == int(n) for n in numbers)
        if not numbers or not usable or not whole or len(set(numbers)) < len(numbers):
            raise InputError(
                f"The {what} '{given}' are no different numbers of at least 0 separated by commas; "
                f"expected such as {'0,1,2' if what == 'questions' else '10,30'}"
            )
        found.append(numbers)
    return tuple(int(n) for n in found[0]), found[1], request.asking


def _ranges(given: str) -> tuple[float, ...]:
    try:
        ranges = tuple(float(word) for word in given.split(","))
    except ValueError:
        ranges = ()
    usable = all(math.isfinite(r) and r > 0 for r in ranges)
    if not ranges or not usable or len(set(ranges)) < len(ranges):
        raise InputError(
            f"Ranges '{given}' are no different positive numbers separated by commas; expected "
            "such as 3,4,5"
        )
    return ranges


def _primary(request: SweepRequest, models: Sequence[str]) -> list[str]:
    """Return the two models of the comparison that is named before the run."""
    if request.primary is None:
        usual = ["bayes", "sloop-m4"]
        return usual if set(usual) <= set(models) else [models[-1], models[0]]
    named = [name.strip() for name in request.primary.split(",")]
    if len(named) != 2 or named[0] == named[1] or not set(named) <= set(models):
        raise InputError(
            f"The primary comparison '{request.primary}' is not of two of the models that are run; "
            f"expected two of {', '.join(models)}, separated by a comma"
        )
    return named


def _manifest(
    request: SweepRequest,
    models: Mapping[str, ObservationModel],
    ranges: tuple[float, ...],
    descriptions: Sequence[AnnotatedDescription],
    find: Callable[[str], CityMap],
) -> dict[str, Any]:
    """Return all that the trials depend on."""
    names = list(models)
    questions, costs, asking = _asked(request)
    n_targets = sum(
        asking is None or asking.asks_about(annotated, target)
        for annotated in descriptions
        for target in annotated.targets
    )
    each = sum(len(costs) if q else 1 for q in questions)
    asked = {"questions": list(questions), "question_costs": list(costs)}
    return {
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
        "version": sloop_ppl.__version__,
        "git": git_state(),
        "packages": packages(),
        "relations": _relations(request),
        "model_names": names,
        "ranges_cells": list(ranges),
        "starts": request.starts,
        "searching": asdict(request.searching),
        "search": asdict(request.searching.config(ranges[0])),
        "cv": request.cv,
        "primary": {
            "models": _primary(request, names),
            "range_cells": ranges[0],
            "measure": "discounted_reward",
        },
        "skip_bad": request.skip_bad,
        "n_descriptions": len(descriptions),
        "n_targets": n_targets,
        "n_trials": n_targets * len(names) * len(ranges) * request.starts * each,
        **({} if asking is None else {"asking": {**asked, **asdict(asking)}}),
        "models": {
            name: model_digest(name, model, request.params) for name, model in models.items()
        },
        "descriptions": {Path(file).name: file_digest(file) for file in request.files},
        "maps": {name: find(name).digest for name in dict.fromkeys(s.map for s in descriptions)},
    }
