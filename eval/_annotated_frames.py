"""Score frame predictors, and people, against the fronts that annotators gave."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from sloop_ppl.errors import InputError
from sloop_ppl.eval._frame_annotations import (
    FrameJudgement,
    angular_distance,
    circular_mean,
    consensus,
)
from sloop_ppl.eval._frame_scores import score_frame
from sloop_ppl.maps import load_map
from sloop_ppl.models import FRAME_PREDICTORS, GroundedRelation

__all__ = ["HUMAN", "AnnotatedFrames", "score_annotated"]

HUMAN = "Human"
"""The row of people: each annotator against the mean of the others."""


@dataclass(frozen=True)
class AnnotatedFrames:
    """Deviations from the mean direction that annotators gave.

    Parameters
    ----------
    phrases
        Number of phrases that were given a direction.
    boxes
        Predictor, or `HUMAN` -> deviations, degrees, 0 to 180.
    """

    phrases: int
    boxes: Mapping[str, tuple[float, ...]]

    def to_json(self) -> dict[str, Any]:
        """Return the member ``annotated`` of what ``sloop eval frames --json`` prints."""
        return {
            "phrases": self.phrases,
            "predictors": {
                name: {
                    "n": len(values),
                    "mean_deviation_deg": float(np.mean(values)),
                    "median_deviation_deg": float(np.median(values)),
                }
                for name, values in self.boxes.items()
            },
        }


def score_annotated(
    judgements: Sequence[FrameJudgement],
    predictors: Sequence[str] = ("ego-ctx", "nearest-street", "random"),
) -> AnnotatedFrames:
    """Score predictors against the mean of the annotators, and each of them against the others.

    Parameters
    ----------
    judgements
        What annotators say.
    predictors
        Names of frame predictors.

    Raises
    ------
    InputError
        When no phrase was given a direction.
    UnknownName
        When a map or ground is unknown.

    Notes
    -----
    Source: SLOOP fig. 6, whose Human box is the disagreement of annotators.
    """
    means = consensus(judgements)
    if not means:
        raise InputError("No phrase was given a direction; expected annotations of frames")
    boxes: dict[str, tuple[float, ...]] = {}
    for name in predictors:
        predictor = FRAME_PREDICTORS[name]
        boxes[name] = tuple(
            score_frame(
                predictor(GroundedRelation(relation, (ground,), load_map(city))), mean
            ).deviation_deg
            for (city, _, ground, relation), mean in means.items()
        )
    people = _of_people(judgements)
    return AnnotatedFrames(len(means), {**boxes, **({HUMAN: people} if people else {})})


def _of_people(judgements: Sequence[FrameJudgement]) -> tuple[float, ...]:
    found = []
    for one in judgements:
        others = [
            other.front_rad
            for other in judgements
            if other.unit == one.unit
            and other.annotator != one.annotator
            and other.front_rad is not None
        ]
        mean = circular_mean(others) if others else None
        if one.front_rad is not None and mean is not None:
            found.append(math.degrees(angular_distance(one.front_rad, mean)))
    return tuple(found)
