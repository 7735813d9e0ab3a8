"""Score frame predictors on what people said: front, behind, left and right of something."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from sloop_ppl.errors import InputError
from sloop_ppl.eval._bootstrap import clustered_interval
from sloop_ppl.eval.crossval import examples_of
from sloop_ppl.eval.descriptions import AnnotatedDescription, read_descriptions
from sloop_ppl.inference._frame_tuning import framed_examples, tune_frames
from sloop_ppl.inference._supervised_scores import Example
from sloop_ppl.inference.learning import log_scores
from sloop_ppl.language import RELATIONS
from sloop_ppl.maps import CityMap, load_map
from sloop_ppl.models import UNFITTED_BAYES, ObservationModel, PredictedSpread, preset
from sloop_ppl.models.frames import frame_predictor
from sloop_ppl.outputs import check_output
from sloop_ppl.rng import child

__all__ = ["DescribedFrameScore", "score_described_frames", "second_stage"]


@dataclass(frozen=True)
class DescribedFrameScore:
    """The log score of true cells given only front, behind, left and right.

    Parameters
    ----------
    n
        Number of targets.
    mean_log_score, ci95
        Predictor -> mean, and its interval over configurations.
    paired
        ``"a-b"`` -> mean difference and its interval.
    """

    n: int
    mean_log_score: Mapping[str, float]
    ci95: Mapping[str, tuple[float, float]]
    paired: Mapping[str, tuple[float, tuple[float, float]]]

    def to_json(self) -> dict[str, Any]:
        """Return the member ``descriptions`` of what ``sloop eval frames --json`` prints."""
        return {
            "n": self.n,
            "predictors": {
                name: {"mean_log_score": mean, "ci95": list(self.ci95[name])}
                for name, mean in self.mean_log_score.items()
            },
            "paired": {
                pair: {"mean": mean, "ci95": list(ends)}
                for pair, (mean, ends) in self.paired.items()
            },
        }


def score_described_frames(
    descriptions: Sequence[AnnotatedDescription],
    predictors: Sequence[str] = ("ego-ctx", "nearest-street"),
    find_map: Callable[[str], CityMap] = load_map,
    *,
    model: str | ObservationModel = UNFITTED_BAYES,
    rng: np.random.Generator,
) -> DescribedFrameScore:
    """Score the true cells of targets given only the frame relations that were said of them.

    Parameters
    ----------
    descriptions
        Descriptions with gold relations and true places.
    predictors
        Names of frame predictors, or paths of weights; the first is compared with each of the
        others.
    find_map
        Gives the map of a description by name.
    model
        The observation model whose frame prior gets each predictor, its numbers unchanged; `bayes`
        before its fit, since the fit has seen descriptions with one of the predictors.
    rng
        Draws the bootstrap over configurations.

    Raises
    ------
    InputError
        When no description says any such relation of a target whose place is known, or the model's
        frame prior takes no predictor.
    """
    chosen = preset(model)
    prior = chosen.frame_prior
    if not isinstance(prior, PredictedSpread):
        raise InputError(f"Model '{chosen.name}' has a frame prior that takes no predictor")
    labelled = [one for one in descriptions if one.targets and one.has_gold]
    examples: list[tuple[str, Example]] = []
    for annotated, example in zip(labelled, examples_of(labelled, find_map), strict=True):
        for one in framed_examples([example]):
            examples += [(annotated.configuration, part) for part in _by_target(one)]
    if not examples:
        raise InputError(
            "No description says front, behind, left or right of a target whose place is known"
        )
    clusters = [configuration for configuration, _ in examples]
    scores = {}
    for name in predictors:
        used = replace(chosen, frame_prior=replace(prior, predictor=frame_predictor(name)))
        scores[name] = np.array([float(log_scores([one], used)[0]) for _, one in examples])
    first, *others = predictors
    gaps = {f"{first}-{other}": scores[first] - scores[other] for other in others}
    return DescribedFrameScore(
        len(examples),
        {name: float(found.mean()) for name, found in scores.items()},
        {name: clustered_interval(found, clusters, rng=child(rng, name))
         for name, found in scores.items()},
        {pair: (float(gap.mean()), clustered_interval(gap, clusters, rng=child(rng, pair)))
         for pair, gap in gaps.items()},
    )  # fmt: skip


def second_stage(
    descriptions: Sequence[str | Path], tuned: str | Path | None
) -> Callable[[str | Path, Callable[[str], None]], str] | None:
    """Return what tunes a model's frame prior to weights, its files checked before the work.

    Parameters
    ----------
    descriptions
        Description files with known places.
    tuned
        Where the parameters shall go, ``.json``.

    Returns
    -------
    callable or None
        Takes the weights and a progress callback; writes the parameters and returns them in
        words. None when neither files nor a path are given.

    Raises
    ------
    InputError
        When only one of the two is given, or a file cannot be used.
    """
    if not descriptions and tuned is None:
        return None
    if not descriptions or tuned is None:
        raise InputError(
            "The second stage needs both --descriptions, what it learns from, and --tuned, where "
            "its parameters go"
        )
    check_output(tuned, (".json",))
    examples = framed_examples(examples_of(read_descriptions(descriptions)))

    def tune(weights: str | Path, progress: Callable[[str], None]) -> str:
        fitted = tune_frames(examples, preset("bayes"), frame_predictor(weights), progress=progress)
        fitted.save(tuned)
        return ", ".join(f"{k} {v:.3f}" for k, v in fitted.parameters["frames"].items())

    return tune


def _by_target(example: Example) -> list[Example]:
    """Return an example a target, with nothing but its frame relations."""
    return [
        replace(
            example,
            description=replace(
                example.description,
                relations=tuple(
                    r
                    for r in example.description.relations
                    if r.figure == target and RELATIONS[r.relation].needs_frame
                ),
            ),
            cells={target: cell},
        )
        for target, cell in example.cells.items()
    ]
