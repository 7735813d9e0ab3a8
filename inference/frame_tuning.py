"""Tune how far a speaker's frame follows the prediction, on descriptions of known places."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from sloop_ppl.errors import InputError
from sloop_ppl.inference.known_cells import Example
from sloop_ppl.inference.learning import Fitted, log_scores
from sloop_ppl.language import FRAME_RELATIONS, RELATIONS
from sloop_ppl.models import PredictedSpread, Preset
from sloop_ppl.models.frames import FramePredictor

__all__ = ["framed_examples", "tune_frames"]

_PRIOR = {"kappa": (math.log(4.0), 0.7), "lapse": (-1.7, 1.0), "absolute": (1.4, 1.0)}
"""Name -> mean and standard deviation of its log (kappa) or log odds (the others)."""

_EVALUATIONS = 120


def framed_examples(examples: Sequence[Example]) -> list[Example]:
    """Return the examples in which front, behind, left or right is said, of those targets."""
    kept = []
    for example in examples:
        said = example.description.relations
        framed = {r.figure for r in said if RELATIONS[r.relation] in FRAME_RELATIONS}
        cells = {target: cell for target, cell in example.cells.items() if target in framed}
        if cells:
            kept.append(replace(example, cells=cells))
    return kept


def tune_frames(
    examples: Sequence[Example],
    model: Preset,
    predictor: FramePredictor,
    *,
    progress: Callable[[str], None] | None = None,
) -> Fitted:
    """Maximise the marginal likelihood of known cells over three numbers of the frame prior.

    Parameters
    ----------
    examples : descriptions with the cells of their targets.
    model : the observation model; its frame prior is a
        :class:`sloop_ppl.models.PredictedSpread`.
    predictor : predicts the fronts; its own weights stay as they are.
    progress : told a line whenever the score has risen.

    Returns
    -------
    Fitted
        Section ``frames``: ``kappa`` of the speaker's scatter, ``lapse``, and the weight
        ``absolute`` of the map's frame for left and right; ``--params`` reads it.

    Raises
    ------
    InputError : when the model's frame prior takes no predictor, or no example says front, behind,
        left or right of a target whose cell is known.

    Notes
    -----
    The frame is summed out in closed form, so the score is p(true cell | what was said). A weak
    prior keeps each number near its default when descriptions are few; the search is that of
    Nelder and Mead (1965), which draws nothing.
    """
    prior = model.frame_prior
    if not isinstance(prior, PredictedSpread):
        raise InputError(
            f"Model '{model.name}' has a frame prior without numbers to tune; expected one that "
            "spreads a prediction, such as that of bayes"
        )
    used = framed_examples(examples)
    if not used:
        raise InputError(
            "No description says front, behind, left or right of a target whose place is known"
        )
    start = replace(prior, predictor=predictor)
    best = -math.inf

    def at(z: NDArray[np.float64]) -> PredictedSpread:
        kappa, lapse, absolute = z
        return replace(start, kappa=math.exp(kappa), lapse=_share(lapse), absolute=_share(absolute))

    def loss(z: NDArray[np.float64]) -> float:
        nonlocal best
        score = float(log_scores(used, replace(model, frame_prior=at(z))).sum())
        if progress and score > best + 0.01:
            progress(f"mean log score {score / count:.4f} with {_told(at(z))}")
        best = max(best, score)
        away = [(v - mean) / sd for v, (mean, sd) in zip(z, _PRIOR.values(), strict=True)]
        return -score + 0.5 * float(np.square(away).sum())

    count = sum(len(example.cells) for example in used)
    first = np.array([mean for mean, _ in _PRIOR.values()])
    before = float(log_scores(used, replace(model, frame_prior=start)).mean())
    found = minimize(
        loss, first, method="Nelder-Mead", options={"maxfev": _EVALUATIONS, "xatol": 1e-2}
    )
    tuned = at(found.x)
    after = float(log_scores(used, replace(model, frame_prior=tuned)).mean())
    numbers = {name: float(getattr(tuned, name)) for name in _PRIOR}
    provenance = {
        "objective": "log score of known cells, the frame summed out, plus log prior",
        "examples": len(used),
        "targets": count,
        "evaluations": int(found.nfev),
        "mean_log_score_before": before,
        "mean_log_score_after": after,
    }
    return Fitted(model.name, {"frames": numbers}, provenance=provenance)


def _share(log_odds: float) -> float:
    return 1 / (1 + math.exp(-log_odds))


def _told(prior: PredictedSpread) -> str:
    return f"kappa {prior.kappa:.2f}, lapse {prior.lapse:.2f}, absolute {prior.absolute:.2f}"
