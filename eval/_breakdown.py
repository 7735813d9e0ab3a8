"""Calibration of a model's beliefs, and their scores by relations, by how many, and by city."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from sloop_ppl.eval._belief_scores import LEVELS, ScoredTarget
from sloop_ppl.eval._bootstrap import clustered_interval

__all__ = ["breakdown"]

_DRAWS = 2000


def breakdown(scores: Sequence[ScoredTarget]) -> dict[str, Any]:
    """Return what ``sloop eval quality --json`` tells of a model beside the means.

    Parameters
    ----------
    scores
        Scores of one model, at least one.

    Returns
    -------
    dict
        ``calibration``: per cent of the belief -> ``coverage`` (how often the region that holds
        it has the target in it, randomised) and ``area_m2`` (mean area of that region).
        ``by_relations`` (1, 2, 3+; 0 where nothing was said), ``by_relation`` (a target counts
        once for each of its relations) and ``by_city``: group -> ``n``, mean log scores with
        interval, and the calibration.
    """
    by_count: dict[str, list[ScoredTarget]] = {}
    by_word: dict[str, list[ScoredTarget]] = {}
    by_city: dict[str, list[ScoredTarget]] = {}
    for scored in scores:
        count = len(scored.relations)
        by_count.setdefault("3+" if count > 2 else str(count), []).append(scored)
        by_city.setdefault(scored.map, []).append(scored)
        for word in dict.fromkeys(scored.relations):
            by_word.setdefault(word, []).append(scored)
    words = sorted(by_word, key=lambda word: (-len(by_word[word]), word))
    return {
        "calibration": _calibration(scores),
        "by_relations": {count: _group(by_count[count]) for count in sorted(by_count)},
        "by_relation": {word: _group(by_word[word]) for word in words},
        "by_city": {city: _group(by_city[city]) for city in sorted(by_city)},
    }


def _group(scores: Sequence[ScoredTarget]) -> dict[str, Any]:
    values = [scored.score.log_score for scored in scores]
    mixed = [scored.score.log_score_mixed for scored in scores]
    clusters = [scored.configuration for scored in scores]
    ends = clustered_interval(values, clusters, rng=np.random.default_rng(0), draws=_DRAWS)
    return {
        "n": len(scores),
        "mean_log_score": float(np.mean(values)),
        "ci95": list(ends),
        "mean_log_score_1pct": float(np.mean(mixed)),
        "calibration": _calibration(scores),
    }


def _calibration(scores: Sequence[ScoredTarget]) -> dict[str, dict[str, float]]:
    return {
        f"{100 * level:g}": {
            "coverage": float(np.mean([scored.score.regions[i].covers for scored in scores])),
            "area_m2": float(np.mean([scored.score.regions[i].area_m2 for scored in scores])),
        }
        for i, level in enumerate(LEVELS)
    }
