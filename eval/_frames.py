"""Cross-validate frame predictors: train on some cities, score on another."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from sloop_ppl.errors import InputError
from sloop_ppl.eval._frame_scores import (
    FrameScore,
    FrameScores,
    fit_points,
    score_frame,
    spread_points,
)
from sloop_ppl.inference._frame_examples import (
    FrameExamples,
    FrameLabel,
    address_labels,
    entrance_labels,
    examples_of_maps,
    joined,
)
from sloop_ppl.inference._frame_training import RECIPES, train_frames, with_limits
from sloop_ppl.maps import CityMap
from sloop_ppl.models import FRAME_PREDICTORS, GroundedRelation
from sloop_ppl.models.frames import FrameDistribution, TrainedFrames, predict_frames
from sloop_ppl.rng import child

__all__ = ["FOLDS", "FrameEvaluation", "ScoredFrame", "cross_validate_frames"]

FOLDS: dict[str, str | None] = {
    "new_york_block": "new_york",
    "baltimore": "baltimore",
    "austin_campus": "austin",
    "citysim": "austin",
    "helsinki": "helsinki",
    "harrisburg": None,
    "paris": None,
}
"""Map -> the fold it is held out in; None for one that only trains. Another map is its own fold."""

_LEAST_LABELS = 50
_DISPUTED_DEG = 15.0
_POINTS = ("nearest-street", "random")
RULE = "nearest-street"


@dataclass(frozen=True)
class ScoredFrame:
    """The score of one prediction for one labelled building.

    Parameters
    ----------
    fold, map, building
        Which building, on which map, in which fold.
    label
        ``"address"`` or ``"entrance"``: what tells the front.
    predictor
        Whose prediction.
    disputed
        True when the rule of the nearest street is more than 15 degrees off the label.
    score
        How good it is.
    """

    fold: str
    map: str
    building: str
    label: str
    predictor: str
    disputed: bool
    score: FrameScore


@dataclass(frozen=True)
class FrameEvaluation:
    """The scores of several predictors, each city held out.

    Parameters
    ----------
    folds
        Names of the folds that count.
    scores
        One per predictor, label and building.
    agreement
        Deviation in degrees of address from main entrance where a building has both.
    """

    folds: tuple[str, ...]
    scores: tuple[ScoredFrame, ...]
    agreement: tuple[float, ...]

    @property
    def predictors(self) -> tuple[str, ...]:
        """Names of the predictors that were scored on addresses, in order."""
        named = (s.predictor for s in self.scores if s.label == "address")
        return tuple(dict.fromkeys(named))

    def select(
        self,
        predictor: str,
        label: str = "address",
        fold: str | None = None,
        disputed: bool | None = None,
    ) -> list[FrameScore]:
        """Return the scores of a predictor, or of those of a label, a fold, or disputed or not."""
        return [
            s.score
            for s in self.scores
            if s.predictor == predictor
            and s.label == label
            and fold in (None, s.fold)
            and disputed in (None, s.disputed)
        ]

    def mean_of_folds(
        self, predictor: str, disputed: bool | None = None
    ) -> dict[str, float] | None:
        """Return the means over folds of a predictor's averages, and how many buildings in all."""
        found = [
            FrameScores.of(self.select(predictor, fold=fold, disputed=disputed))
            for fold in self.folds
        ]
        each = [scores for scores in found if scores is not None]
        if not each:
            return None
        names = [name for name in vars(each[0]) if name != "n"]
        means = {name: float(np.mean([getattr(s, name) for s in each])) for name in names}
        return {"n": sum(s.n for s in each), **means}

    def to_json(self) -> dict[str, Any]:
        """Return the value that ``sloop eval frames --json`` prints."""
        keys = ("n", "mean_deviation_deg", "median_deviation_deg", "mean_log_score", "arc50",
                "arc90")  # fmt: skip
        overall = {p: self.mean_of_folds(p) or {} for p in self.predictors}
        disputed = {p: self.mean_of_folds(p, disputed=True) for p in self.predictors}
        entrances = dict.fromkeys(s.predictor for s in self.scores if s.label == "entrance")
        near = [d for d in self.agreement if d <= 5]
        return {
            "folds": list(self.folds),
            "predictors": {p: {k: found[k] for k in keys} for p, found in overall.items()},
            "within45": {p: found["within45"] for p, found in overall.items()},
            "disputed": {p: found for p, found in disputed.items() if found},
            "by_fold": {
                fold: {
                    p: vars(scores)
                    for p in self.predictors
                    if (scores := FrameScores.of(self.select(p, fold=fold)))
                }
                for fold in self.folds
            },
            "entrances": {
                p: vars(scores)
                for p in entrances
                if (scores := FrameScores.of(self.select(p, "entrance")))
            },
            "address_against_entrance": {
                "n": len(self.agreement),
                "median_deviation_deg": float(np.median(self.agreement)) if self.agreement else 0.0,
                "within5": len(near) / max(len(self.agreement), 1),
            },
        }


def cross_validate_frames(
    maps: Mapping[str, CityMap],
    recipes: Sequence[str] = ("ego-ctx", "ctx", "ego"),
    *,
    epochs: int | None = None,
    patience: int | None = None,
    rng: np.random.Generator,
    progress: Callable[[str], None] | None = None,
) -> FrameEvaluation:
    """Train each recipe without a fold's cities and score it on them, for each fold.

    Parameters
    ----------
    maps
        Name -> map; `FOLDS` says which are held out together.
    recipes
        Names in :data:`sloop_ppl.inference._frame_training.RECIPES`.
    epochs, patience
        Epochs and patience instead of the recipes'.
    progress
        Called with a line at a time on how it goes.

    Returns
    -------
    FrameEvaluation
        Only folds with 50 labels or more count. The rules (nearest street, random) are scored
        as von Mises distributions whose concentration and lapse suit the training cities best.
        Main entrances are scored too, by what was trained without their city.

    Raises
    ------
    InputError
        When fewer than two folds have labels enough.
    """
    labels = {name: address_labels(city) for name, city in maps.items()}
    doors = {name: entrance_labels(city) for name, city in maps.items()}
    folds = _folds(labels)
    sets = {
        view: examples_of_maps(
            maps, view, rng=child(rng, "examples"), progress=None if done else progress
        )
        for done, view in enumerate(dict.fromkeys(RECIPES[r].shape.view for r in recipes))
    }
    scores: list[ScoredFrame] = []
    for fold, held in folds.items():
        rest = [name for name in maps if name not in held]
        predict = {
            recipe: _trained(
                recipe, [sets[RECIPES[recipe].shape.view][n] for n in rest if labels[n]],
                epochs, patience, child(rng, "training", fold, recipe), progress, fold,
            )
            for recipe in recipes
        }  # fmt: skip
        spreads = {name: _fitted(name, maps, labels, rest) for name in _POINTS}
        for name in held:
            for label, some in (("address", labels[name]), ("entrance", doors[name])):
                made = _predictions(maps[name], some, predict, spreads, label)
                scores += _scored(fold, name, label, maps[name], some, made)
        if progress:
            progress(f"{fold}: {sum(len(labels[name]) for name in held)} buildings scored")
    return FrameEvaluation(tuple(folds), tuple(scores), _agreement(maps))


def _folds(labels: Mapping[str, Sequence[FrameLabel]]) -> dict[str, list[str]]:
    folds: dict[str, list[str]] = {}
    for name in labels:
        fold = FOLDS.get(name, name)
        if fold is not None:
            folds.setdefault(fold, []).append(name)
    counted = {f: m for f, m in folds.items() if sum(len(labels[n]) for n in m) >= _LEAST_LABELS}
    if len(counted) < 2:
        raise InputError(
            f"{len(counted)} cities have {_LEAST_LABELS} labelled buildings or more; expected at "
            "least two, so that one can be held out; give a folder of OpenStreetMap extracts"
        )
    return counted


def _trained(
    recipe: str,
    sets: list[FrameExamples],
    epochs: int | None,
    patience: int | None,
    rng: np.random.Generator,
    progress: Callable[[str], None] | None,
    fold: str,
) -> TrainedFrames:
    chosen = with_limits(RECIPES[recipe], epochs, patience)
    network, info = train_frames(joined(sets), chosen, rng=rng)
    if progress:
        progress(f"{recipe} without {fold}: {info.epochs} passes, loss {info.best:.3f}")
    return TrainedFrames(network)


def _fitted(
    name: str,
    maps: Mapping[str, CityMap],
    labels: Mapping[str, Sequence[FrameLabel]],
    rest: Sequence[str],
) -> tuple[float, float]:
    """Return the concentration and lapse of a rule that suit the training cities best."""
    some = [(maps[n], label) for n in rest for label in labels[n]]
    predicted = [_rule(name, city, label) for city, label in some]
    return fit_points(predicted, [label.frame_angle_rad for _, label in some])


def _rule(name: str, city: CityMap, label: FrameLabel) -> FrameDistribution:
    return FRAME_PREDICTORS[name](GroundedRelation("front", (label.building,), city))


def _predictions(
    city: CityMap,
    labels: Sequence[FrameLabel],
    trained: Mapping[str, TrainedFrames],
    spreads: Mapping[str, tuple[float, float]],
    label: str,
) -> dict[str, list[FrameDistribution]]:
    ids = [one.building for one in labels]
    made = {name: predict_frames(one, city, ids) for name, one in trained.items()}
    for name, spread in spreads.items():
        made[name] = [spread_points(_rule(name, city, one), *spread) for one in labels]
    if label == "entrance":
        made["address"] = [_by_address(city, one, spreads[RULE]) for one in labels]
    return made


def _by_address(city: CityMap, label: FrameLabel, spread: tuple[float, float]) -> FrameDistribution:
    """Return what the address predictor says of a building whose door it must not look at."""
    if city.frontage(label.building).by_address is None:
        return spread_points(_rule(RULE, city, label), *spread)
    return _rule("address", city, label)


def _scored(
    fold: str,
    name: str,
    label: str,
    city: CityMap,
    labels: Sequence[FrameLabel],
    made: Mapping[str, Sequence[FrameDistribution]],
) -> list[ScoredFrame]:
    off = [score_frame(_rule(RULE, city, one), one.frame_angle_rad).deviation_deg for one in labels]
    return [
        ScoredFrame(
            fold, name, one.building, label, predictor, off[i] > _DISPUTED_DEG,
            score_frame(predicted[i], one.frame_angle_rad),
        )
        for predictor, predicted in made.items()
        for i, one in enumerate(labels)
    ]  # fmt: skip


def _agreement(maps: Mapping[str, CityMap]) -> tuple[float, ...]:
    found = []
    for city in maps.values():
        by_door = {label.building: label.frame_angle_rad for label in entrance_labels(city)}
        for label in address_labels(city, by_door):
            towards = FrameDistribution.points((label.frame_angle_rad,))
            found.append(score_frame(towards, by_door[label.building]).deviation_deg)
    return tuple(found)
