"""Choose among models inside the folds, so that the reported score is not the selected one."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from sloop_ppl.errors import InputError
from sloop_ppl.eval._kept_fits import KeptFits
from sloop_ppl.eval.crossval import examples_of
from sloop_ppl.eval.descriptions import AnnotatedDescription
from sloop_ppl.eval.quality import BeliefQuality, score_beliefs
from sloop_ppl.inference.learning import Fitted, fit, log_scores
from sloop_ppl.maps import CityMap, load_map
from sloop_ppl.models import ObservationModel

__all__ = ["NESTED", "Selection", "select_model"]

NESTED = "chosen in the folds"
"""Name of the score that no choice has touched, among the scores of the candidates."""


@dataclass(frozen=True, eq=False)
class Selection:
    """Which of some models is best by leave-one-map-out cross-validation, and how good that is.

    Parameters
    ----------
    inner
        Map left out -> candidate -> its mean log score on the other maps, each scored by a fit to
        the rest of them.
    chosen
        Map left out -> the candidate that did best on the others; it scores this map.
    winner
        The candidate that does best with each map left out, fitted to all.
    fitted
        The winner's numbers.
    quality
        Scores with each map left out: of `NESTED`, of every candidate, and of the references, in
        this order.
    """

    inner: Mapping[str, Mapping[str, float]]
    chosen: Mapping[str, str]
    winner: str
    fitted: Fitted
    quality: BeliefQuality

    def to_json(self) -> dict[str, Any]:
        """Return how the choice was made, as is kept with the fitted numbers."""
        scored = self.quality.to_json()
        kept = ("n", "mean_log_score", "ci95", "mean_log_score_1pct", "hpd90_coverage")
        return {
            "winner": self.winner,
            "chosen": dict(self.chosen),
            "inner": {left_out: dict(scores) for left_out, scores in self.inner.items()},
            "left_out": {
                name: {key: one[key] for key in kept} for name, one in scored["models"].items()
            },
            "paired": {
                pair: difference
                for pair, difference in scored["paired"].items()
                if pair.startswith(NESTED)
            },
        }


def select_model(
    descriptions: Sequence[AnnotatedDescription],
    candidates: Mapping[str, ObservationModel],
    find_map: Callable[[str], CityMap] = load_map,
    *,
    references: Mapping[str, ObservationModel] | None = None,
    learn: Sequence[str] | None = None,
    iterations: int = 40,
    kept: KeptFits | None = None,
    progress: Callable[[str], None] | None = None,
) -> Selection:
    """Fit every candidate with each map left out, choose, and fit the choice to all maps.

    Parameters
    ----------
    descriptions
        Descriptions with known places, of at least three maps; two when there is only one
        candidate, for then nothing is chosen. Maps cut from one city count as one: see
        :class:`AnnotatedDescription`.
    candidates
        Name -> model, at the medians of its priors.
    find_map
        Gives the map of a description by name.
    references
        Name -> model that is scored beside the candidates as it is.
    learn
        What is learnt; see :func:`sloop_ppl.inference.fit`.
    iterations
        At most this many of L-BFGS per fit.
    kept
        Fits that were made before, and where those made now are kept.
    progress
        Called with a line per fit, and one per round of it.

    Raises
    ------
    InputError
        When there are too few maps, or no candidate.

    Notes
    -----
    Nested cross-validation (Varma and Simon 2006): for each map left out, candidates are compared
    by fits to all but one of the other maps, scored on that one; the best is refitted to all of
    the others and scored on the map left out. The choice never sees the map that it is scored on.
    """
    maps = list(dict.fromkeys(annotated.city for annotated in descriptions if annotated.targets))
    need = 3 if len(candidates) > 1 else 2
    if not candidates or len(maps) < need:
        raise InputError(
            f"There are {len(candidates)} models to fit and descriptions of {len(maps)} maps; "
            f"expected at least one model, and {need} maps, so that they can be left out in turn"
        )
    examples = {
        name: examples_of(
            [annotated for annotated in descriptions if annotated.city == name], find_map
        )
        for name in maps
    }
    fits: dict[tuple[str, frozenset[str]], ObservationModel] = {}
    total, notify = _number_of_fits(len(candidates), len(maps)), progress or _ignore

    def fitted_to(candidate: str, used: Sequence[str], *, intervals: bool) -> Fitted:
        found = kept.get(candidate, used) if kept is not None else None
        if found is None:
            which = f"fit {len(fits) + 1} of {total}, {candidate} to {', '.join(used)}"
            found = fit(
                [example for name in used for example in examples[name]],
                candidates[candidate],
                learn=learn,
                iterations=iterations,
                intervals=intervals,
                progress=lambda line: notify(f"{which}: {line}"),
            )
            if kept is not None:
                kept.keep(candidate, used, found)
            notify(f"{which}: done, {found.provenance['mean_log_score_after']:.3f} there")
        return found

    def without(candidate: str, *left_out: str) -> ObservationModel:
        used = [name for name in maps if name not in left_out]
        key = (candidate, frozenset(used))
        if key not in fits:
            fitted = fitted_to(candidate, used, intervals=False)
            fits[key] = fitted.apply(candidates[candidate])
        return fits[key]

    def mean_score(candidate: str, scored: Sequence[str], *left_out: str) -> float:
        found = [log_scores(examples[m], without(candidate, m, *left_out)) for m in scored]
        return float(np.mean(np.concatenate([scores.numpy() for scores in found])))

    def by_map(candidate_of: Mapping[str, str]) -> dict[str, ObservationModel]:
        known = (one for one in descriptions if one.city in maps)
        return {one.map: without(candidate_of[one.city], one.city) for one in known}

    inner: dict[str, dict[str, float]] = {}
    if len(candidates) > 1:
        for left_out in maps:
            others = [name for name in maps if name != left_out]
            inner[left_out] = {c: mean_score(c, others, left_out) for c in candidates}
    only = next(iter(candidates))
    chosen = {name: _best(inner[name]) if inner else only for name in maps}
    outer = {c: mean_score(c, maps) for c in candidates}
    winner = _best(outer)
    scored: dict[str, ObservationModel | Mapping[str, ObservationModel]] = {
        NESTED: by_map(chosen),
        **{c: by_map(dict.fromkeys(maps, c)) for c in candidates},
        **(references or {}),
    }
    fitted = fitted_to(winner, maps, intervals=True)
    quality = score_beliefs(descriptions, scored, find_map, rng=np.random.default_rng(0))
    return Selection(inner, chosen, winner, fitted, quality)


def _best(scores: Mapping[str, float]) -> str:
    return max(scores, key=lambda name: scores[name])


def _number_of_fits(candidates: int, maps: int) -> int:
    """Return how many fits a choice takes: all candidates without each one and two maps, and one.

    A single candidate is not chosen, so it is never fitted without two.
    """
    pairs = maps * (maps - 1) // 2 if candidates > 1 else 0
    return candidates * (maps + pairs) + 1


def _ignore(line: str) -> None:
    del line
