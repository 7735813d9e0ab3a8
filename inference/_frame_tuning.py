"""Tune how far a speaker's frame follows the prediction, on descriptions of known places."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from sloop_ppl.errors import InputError
from sloop_ppl.inference._supervised_scores import Example
from sloop_ppl.inference.learning import Fitted, fit
from sloop_ppl.language import RELATIONS
from sloop_ppl.models import ObservationModel, PredictedSpread
from sloop_ppl.models.frames import FramePredictor

__all__ = ["framed_examples", "tune_frames"]


def framed_examples(examples: Sequence[Example]) -> list[Example]:
    """Return the examples in which front, behind, left or right is said, of those targets."""
    kept = []
    for example in examples:
        relations = example.description.relations
        framed = {r.figure for r in relations if RELATIONS[r.relation].needs_frame}
        cells = {target: cell for target, cell in example.cells.items() if target in framed}
        if cells:
            kept.append(replace(example, cells=cells))
    return kept


def tune_frames(
    examples: Sequence[Example],
    model: ObservationModel,
    predictor: FramePredictor,
    *,
    progress: Callable[[str], None] | None = None,
) -> Fitted:
    """Maximise the marginal likelihood of known cells over the numbers of the frame prior.

    Parameters
    ----------
    examples
        Descriptions with the cells of their targets.
    model
        The observation model; its frame prior is a :class:`sloop_ppl.models.PredictedSpread`.
    predictor
        Predicts the fronts; its own weights stay as they are.
    progress
        Called with a line per round.

    Returns
    -------
    Fitted
        Section ``frames``: ``kappa`` of the speaker's scatter, and the weight ``absolute`` of the
        map's frame for left and right; ``--params`` reads it.

    Raises
    ------
    InputError
        When the model's frame prior takes no predictor, or no example says front, behind, left or
        right of a target whose cell is known.

    Notes
    -----
    This is :func:`sloop_ppl.inference.fit` of these two numbers alone: the frame is summed out,
    so the score is p(true cell | what was said), and a prior keeps each number near its middle
    when descriptions are few. The prior's `lapse` stays, since it competes with the lapse of
    phrases.
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
    start = replace(model, frame_prior=replace(prior, predictor=predictor))
    return fit(used, start, learn=("kappa", "absolute"), progress=progress)
