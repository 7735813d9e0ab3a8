"""Score the beliefs of models on descriptions whose targets' places are known."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.errors import BeliefCollapse, InputError
from sloop_ppl.eval._belief_scores import BeliefScore, ScoredTarget, score_belief
from sloop_ppl.eval._bootstrap import clustered_interval
from sloop_ppl.eval._breakdown import breakdown
from sloop_ppl.eval._facts import plain_word
from sloop_ppl.eval.descriptions import AnnotatedDescription
from sloop_ppl.eval.metrics import Metric, json_names, summarised
from sloop_ppl.inference import infer_description
from sloop_ppl.language import Description, parse
from sloop_ppl.maps import CityMap, load_map
from sloop_ppl.models import ObservationModel
from sloop_ppl.rng import child

__all__ = [
    "BeliefQuality",
    "ModelQuality",
    "PairedDifference",
    "beliefs_of",
    "model_for",
    "read_annotated",
    "score_beliefs",
    "to_score",
]

Relations = Literal["gold", "parsed"]


@dataclass(frozen=True)
class ModelQuality:
    """How good one model's beliefs are over all targets.

    Parameters
    ----------
    n
        Number of targets.
    mean_log_score
        Mean natural log of the belief at the true cell.
    ci95
        Interval of that mean, from a bootstrap over configurations.
    median_rank, expected_distance_m, mass_15m, hpd90_coverage
        See :class:`sloop_ppl.eval._belief_scores.BeliefScore`; the mean of each, the rank's median.
    mean_log_score_mixed, ci95_mixed
        The same with 1 % of the uniform belief mixed in.
    scores
        One per target, in the order of the descriptions.
    metrics
        Name of a metric -> its mean, the median of a rank and of ``median_*``.
    """

    n: int
    mean_log_score: float
    ci95: tuple[float, float]
    median_rank: float
    expected_distance_m: float
    mass_15m: float
    hpd90_coverage: float
    mean_log_score_mixed: float
    ci95_mixed: tuple[float, float]
    scores: tuple[ScoredTarget, ...] = ()
    metrics: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class PairedDifference:
    """By how much one model's log score beats another's on the same targets, on average."""

    mean: float
    ci95: tuple[float, float]


@dataclass(frozen=True, repr=False)
class BeliefQuality:
    """The scores of several models, and what lies between them.

    Parameters
    ----------
    relations
        ``"gold"`` when the models were given the gold relations, ``"parsed"`` when they had to make
        do with what the parser read.
    models
        Model name -> its quality.
    paired
        ``"a-b"`` -> the difference a less b, for each two models in the order they came.
    paired_mixed
        The same with 1 % of the uniform belief mixed into every model.
    cv
        ``"city"`` when models were refitted without the line's city, else None.
    sets
        Name of a file -> the same of its descriptions alone; empty when there is one file.
    """

    relations: Relations
    models: Mapping[str, ModelQuality]
    paired: Mapping[str, PairedDifference]
    paired_mixed: Mapping[str, PairedDifference]
    cv: str | None = None
    sets: Mapping[str, BeliefQuality] = field(default_factory=dict)

    def __repr__(self) -> str:
        each = (f"{name} {q.mean_log_score:.2f}" for name, q in self.models.items())
        n = next((q.n for q in self.models.values()), 0)
        return f"BeliefQuality({self.relations}, {n} targets, mean log score: {', '.join(each)})"

    def _repr_html_(self) -> str:
        from sloop_ppl._html import caption, html_table

        head = ("model", "n", "mean log score", "95 %", "median rank", "mass within 15 m")
        rows = [
            (
                name, q.n, q.mean_log_score, f"{q.ci95[0]:.2f} to {q.ci95[1]:.2f}",
                q.median_rank, q.mass_15m,
            )
            for name, q in self.models.items()
        ]  # fmt: skip
        paired = [
            (names, d.mean, f"{d.ci95[0]:.2f} to {d.ci95[1]:.2f}")
            for names, d in self.paired.items()
        ]
        parts = [caption(f"Beliefs given {self.relations} relations"), html_table(rows, head)]
        parts += [html_table(paired, ("pair", "mean difference", "95 %"))] if paired else []
        return "".join(parts)

    def to_json(self) -> dict[str, Any]:
        """Return the value that ``sloop eval quality --json`` prints."""
        return {
            "relations": self.relations,
            "models": {
                name: {
                    "n": quality.n,
                    "mean_log_score": quality.mean_log_score,
                    "ci95": list(quality.ci95),
                    "median_rank": quality.median_rank,
                    "expected_distance_m": quality.expected_distance_m,
                    "mass_15m": quality.mass_15m,
                    "hpd90_coverage": quality.hpd90_coverage,
                    "mean_log_score_1pct": quality.mean_log_score_mixed,
                    "ci95_1pct": list(quality.ci95_mixed),
                    **{
                        key: quality.metrics[metric]
                        for metric, key in json_names(quality.metrics).items()
                        if key not in _OWN_KEYS
                    },
                    **breakdown(quality.scores),
                }
                for name, quality in self.models.items()
            },
            "paired": _paired_json(self.paired),
            "paired_1pct": _paired_json(self.paired_mixed),
            "cv": self.cv,
            "metrics": list(json_names(next(iter(self.models.values())).metrics).values()),
            **(
                {"sets": {name: one.to_json() for name, one in self.sets.items()}}
                if self.sets
                else {}
            ),
        }


_OWN_KEYS = ("mean_log_score", "median_rank", "expected_distance_m")
"""Keys of the metrics that are fields of `ModelQuality` too."""


def _paired_json(paired: Mapping[str, PairedDifference]) -> dict[str, Any]:
    return {
        pair: {"mean": difference.mean, "ci95": list(difference.ci95)}
        for pair, difference in paired.items()
    }


def score_beliefs(
    descriptions: Sequence[AnnotatedDescription],
    models: Mapping[str, ObservationModel | Mapping[str, ObservationModel]],
    find_map: Callable[[str], CityMap] = load_map,
    *,
    relations: Relations = "gold",
    rng: np.random.Generator,
    progress: Callable[[str], None] | None = None,
    metrics: Mapping[str, Metric] | None = None,
) -> BeliefQuality:
    """Infer where the targets of every description are under each model, and score it.

    Parameters
    ----------
    descriptions
        The descriptions; a line that tells no place of a target is passed over, and so is one
        without gold when `relations` is ``"gold"``.
    models
        Name -> model, or the model for each map by the map's name.
    find_map
        Gives the map of a description by name.
    relations
        ``"gold"``, or ``"parsed"`` for what the rules read in the text.
    rng
        Draws the bootstrap.
    progress
        Called with a line per model, and of every collapse.
    metrics
        Name -> what is measured of each belief; those of `METRICS` when None.

    Returns
    -------
    BeliefQuality
        A target of which nothing was read, or whose belief collapses, has the uniform belief, of
        the line's area if it has one. Descriptions of several files are reported file by file, too.

    Raises
    ------
    InputError
        When no description tells a place, or none has the gold, or no model is given.
    """
    labelled = to_score(descriptions, relations, progress)
    if not models:
        raise InputError("There is no model to score; expected at least one")
    read = [
        (annotated, *read_annotated(annotated, find_map(annotated.map), relations))
        for annotated in labelled
    ]
    qualities = {}
    for name, model in models.items():
        scores = [
            ScoredTarget(
                annotated.id,
                annotated.configuration,
                target,
                annotated.map,
                tuple(plain_word(relation.relation) for relation in annotated.about(target)),
                score_belief(belief, city.grid, place, metrics),
                annotated.source,
            )
            for annotated, city, utterance in read
            for (target, place), belief in zip(
                annotated.places(city.grid).items(),
                beliefs_of(
                    annotated, utterance, city, model_for(model, annotated.map), progress
                ).values(),
                strict=True,
            )
        ]
        qualities[name] = summarise(scores, rng=rng)
        if progress:
            progress(f"{name}: {len(scores)} targets scored")
    found = _compared(relations, qualities, rng)
    sources = tuple(dict.fromkeys(annotated.source for annotated in labelled))
    if len(sources) < 2:
        return found
    return replace(
        found,
        sets={
            source: _compared(
                relations,
                {
                    name: summarise([s for s in one.scores if s.source == source], rng=rng)
                    for name, one in qualities.items()
                },
                rng,
            )
            for source in sources
        },
    )


def _compared(
    relations: Relations, qualities: Mapping[str, ModelQuality], rng: np.random.Generator
) -> BeliefQuality:
    return BeliefQuality(
        relations,
        qualities,
        paired_differences(qualities, lambda score: score.log_score, rng=rng),
        paired_differences(qualities, lambda score: score.log_score_mixed, rng=rng),
    )


def to_score(
    descriptions: Sequence[AnnotatedDescription],
    relations: Relations,
    progress: Callable[[str], None] | None = None,
) -> list[AnnotatedDescription]:
    """Return the descriptions that can be scored: those that tell a place, and have the gold.

    Raises
    ------
    InputError
        When there is none.
    """
    labelled = [annotated for annotated in descriptions if annotated.targets]
    if not labelled:
        raise InputError(
            "No description says where its targets are; expected 'targets' with their places"
        )
    if relations == "parsed":
        return labelled
    with_gold = [annotated for annotated in labelled if annotated.has_gold]
    if not with_gold:
        raise InputError(
            "No description has gold 'relations'; score what the parser reads with --parsed"
        )
    if progress and len(with_gold) < len(labelled):
        progress(f"{len(labelled) - len(with_gold)} lines without gold relations passed over")
    return with_gold


def model_for(
    model: ObservationModel | Mapping[str, ObservationModel], name: str
) -> ObservationModel:
    """Return the model for the map of a name."""
    return model if isinstance(model, ObservationModel) else model[name]


def read_annotated(
    annotated: AnnotatedDescription, city: CityMap, relations: Relations
) -> tuple[CityMap, Description]:
    """Return the map and what a model is told: the gold relations, or what the rules read."""
    if relations == "parsed":
        read = parse(
            annotated.text,
            city,
            annotated.objects,
            viewpoint=annotated.viewpoint,
            hearer=annotated.hearer,
        )
        return city, read
    return city, annotated.description(city)


def beliefs_of(
    annotated: AnnotatedDescription,
    description: Description,
    city: CityMap,
    model: ObservationModel,
    progress: Callable[[str], None] | None = None,
) -> dict[str, NDArray[np.float64]]:
    """Return target -> belief of each target of a description, in its order, shape (H, W).

    It is that of the line's area, and 0 outside.
    """
    area = annotated.search_area(city.grid)
    inside = np.ones(city.grid.shape, dtype=bool) if area is None else area.cells
    uniform = np.where(inside, 1 / inside.sum(), 0.0)
    beliefs = dict.fromkeys(annotated.targets, uniform)
    places = {target: (place.x_m, place.y_m) for target, place in annotated.targets.items()}
    if model.needs_truth:  # it is told the place, whatever was read
        description = replace(description, targets=annotated.objects)
    elif not description.relations:
        return beliefs
    try:
        posterior, _ = infer_description(description, city, model, truth=places, area=area)
    except BeliefCollapse as error:
        if progress:
            progress(f"{annotated.id}: {error}; scored as uniform")
        return beliefs
    return {
        t: posterior.belief(t) if t in posterior.targets else uniform for t in annotated.targets
    }


def summarise(scores: Sequence[ScoredTarget], *, rng: np.random.Generator) -> ModelQuality:
    """Return the means over targets, and the interval of the log score's."""
    each = [scored.score for scored in scores]
    log_scores = np.array([score.log_score for score in each])
    mixed = np.array([score.log_score_mixed for score in each])
    return ModelQuality(
        n=len(each),
        mean_log_score=float(log_scores.mean()),
        ci95=_interval(log_scores, scores, rng),
        median_rank=float(np.median([score.rank for score in each])),
        expected_distance_m=float(np.mean([score.expected_distance_m for score in each])),
        mass_15m=float(np.mean([score.mass_15m for score in each])),
        hpd90_coverage=float(np.mean([score.in_hpd90 for score in each])),
        mean_log_score_mixed=float(mixed.mean()),
        ci95_mixed=_interval(mixed, scores, rng),
        scores=tuple(scores),
        metrics={
            name: summarised(name, [score.metrics[name] for score in each])
            for name in each[0].metrics
        },
    )


def paired_differences(
    qualities: Mapping[str, ModelQuality],
    value: Callable[[BeliefScore], float],
    *,
    rng: np.random.Generator,
) -> dict[str, PairedDifference]:
    """Return ``"a-b"`` -> mean of a value of a less that of b on the same targets."""
    paired = {}
    for (one, a), (other, b) in itertools.combinations(qualities.items(), 2):
        differences = np.array(
            [value(x.score) - value(y.score) for x, y in zip(a.scores, b.scores, strict=True)]
        )
        paired[f"{one}-{other}"] = PairedDifference(
            float(differences.mean()), _interval(differences, a.scores, rng)
        )
    return paired


def _interval(
    values: NDArray[np.float64], scores: Sequence[ScoredTarget], rng: np.random.Generator
) -> tuple[float, float]:
    """Return the bootstrap interval; every one draws the same configurations."""
    clusters = [scored.configuration for scored in scores]
    return clustered_interval(values, clusters, rng=child(rng, "bootstrap"))
