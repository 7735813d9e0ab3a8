"""Predict fronts with a trained network, one that ships or one of a file."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from pathlib import Path

import numpy as np
import shapely
import torch
from numpy.typing import NDArray

from sloop_ppl.maps import CityMap
from sloop_ppl.maps.landmark import PATH_KINDS
from sloop_ppl.models.frames._network import DIRECTIONS, TrainedFrames, load_weights
from sloop_ppl.models.frames._pictures import pictures_of
from sloop_ppl.models.frames._streets import FEATURES, Choices, choices_of
from sloop_ppl.models.frames.distribution import FrameDistribution, FramePart
from sloop_ppl.models.frames.predictor import FRAME_PREDICTORS, FramePredictor, unpredicted_frame
from sloop_ppl.models.grounded_relation import GroundedRelation

__all__ = [
    "LearnedFrames",
    "frame_predictor",
    "padded_choices",
    "predict_frames",
    "shipped_weights",
]

_CHUNK = 256
_UNSEEN = 0.5  # how often what lies beyond the map's edge is what a building faces
_UNFAMILIAR = 0.3  # extra lapse of what is no building, which no network was trained on
_REACH_M = 40.0
# Half a step off the axes, where one of the two would be zero.
_LOOKED = np.array([(math.cos(a), math.sin(a)) for a in (np.arange(32) + 0.5) * (math.pi / 16)])
_LEAST = 0.01  # parts that weigh less are left to the lapse
_FLAT = 0.5  # so are parts of a lesser concentration


def shipped_weights(name: str) -> Path:
    """Return the path of the weights that ship with the package under a name."""
    return Path(str(files("sloop_ppl"))) / "data" / "frames" / f"{name}.safetensors"


@dataclass(frozen=True)
class LearnedFrames:
    """A trained network as a frame predictor; its weights are read when they are first needed.

    Parameters
    ----------
    weights
        Path of a weights file; see :func:`sloop_ppl.models.frames.load_weights`.

    Notes
    -----
    Source: SLOOP sec. IV-C (EGO-CTX, CTX, EGO), with a distribution in place of the angle.
    """

    weights: Path

    def __call__(self, term: GroundedRelation) -> FrameDistribution:
        """Return the distribution of the ground's front, the same for all words."""
        plain = unpredicted_frame(term)
        return plain if plain is not None else self.predict(term.city, [term.ground])[0]

    def predict(self, city: CityMap, landmarks: Sequence[str]) -> list[FrameDistribution]:
        """Return which way each landmark faces; a prediction is made once a map.

        Raises
        ------
        InputError
            When the weights cannot be used.
        UnknownName
            When the map has no such landmark.
        """
        known: dict[str, FrameDistribution] = city.derived(f"fronts by {self.weights}", dict)
        missing = [i for i in dict.fromkeys(landmarks) if i not in known]
        if missing:
            made = predict_frames(_loaded(self.weights), city, missing)
            known.update(zip(missing, made, strict=True))
        return [known[i] for i in landmarks]


def frame_predictor(name_or_path: str | Path) -> FramePredictor:
    """Return the registered predictor of this name, or that of a ``.safetensors`` file.

    Raises
    ------
    UnknownName
        When no predictor has this name; it lists those there are.
    InputError
        When the weights cannot be used.
    """
    name = str(name_or_path)
    if name.endswith(".safetensors"):
        load_weights(name)
        return LearnedFrames(Path(name))
    return FRAME_PREDICTORS[name]


@cache
def _loaded(path: Path) -> TrainedFrames:
    return load_weights(path)


def predict_frames(
    trained: TrainedFrames, city: CityMap, landmarks: Sequence[str]
) -> list[FrameDistribution]:
    """Return which way each landmark faces.

    Parameters
    ----------
    trained
        A network.
    city
        The map.
    landmarks
        Their ids.

    Returns
    -------
    list of FrameDistribution
        A map without ways tells nothing: uniform. Near the edge, where something unseen may be
        nearer than what is seen, and for what is no building, the lapse is larger.

    Notes
    -----
    Each picture is seen in its four quarter turns and the four answers are averaged, so turning
    the map by 90 degrees turns the prediction by exactly as much.
    """
    if not city.of_kind(*PATH_KINDS):
        return [FrameDistribution((), lapse=1.0)] * len(landmarks)
    found = []
    for start in range(0, len(landmarks), _CHUNK):
        some = landmarks[start : start + _CHUNK]
        choices = choices_of(city, some)
        pictures = pictures_of(city, some, trained.network.shape.view)
        mean, kappa, weight = _answers(trained, pictures, choices)
        sure = _sureness(city, some, choices)
        weight *= (sure / weight.sum(1))[:, None]
        parts = mean, kappa, weight[:, :-1]
        found += _mixtures(*(_merged_first(DIRECTIONS, *parts) if trained.network.weigh else parts))
    return found


def padded_choices(
    choices: Sequence[Choices],
) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.bool_]]:
    """Return bearings (N, C), features (N, C, F) and which are there (N, C), one C for all."""
    most = max([1, *(len(c.bearing_rad) for c in choices)])
    bearing = np.zeros((len(choices), most), np.float32)
    features = np.zeros((len(choices), most, len(FEATURES)), np.float32)
    there = np.zeros((len(choices), most), dtype=bool)
    for i, choice in enumerate(choices):
        count = len(choice.bearing_rad)
        bearing[i, :count], features[i, :count] = choice.bearing_rad, choice.features
        there[i, :count] = True
    return bearing, features, there


def _answers(
    trained: TrainedFrames, pictures: NDArray[np.float32], choices: Sequence[Choices]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return means, concentrations (N, P) and weights (N, P + 1), averaged over quarter turns."""
    tables = [torch.from_numpy(a) for a in (pictures, *padded_choices(choices))]
    with torch.inference_mode():
        answer = trained.network.averaged(*tables)
    parameters = answer.mean_rad, answer.kappa, answer.log_weight.exp()
    mean, kappa, weight = (one.numpy().astype(np.float64) for one in parameters)
    return mean, kappa, weight


def _sureness(
    city: CityMap, landmarks: Sequence[str], choices: Sequence[Choices]
) -> NDArray[np.float64]:
    """Return how far each prediction can be trusted, apart from what the network says, (0, 1].

    The share of the directions in which the map ends before the nearest street is unseen. What is
    no building has an extra lapse.
    """
    own = np.array([city.footprint(i) for i in landmarks], dtype=object)
    centre = shapely.get_coordinates(shapely.centroid(own))[:, None]
    west, south, east, north = city.grid.extent_m
    edge = np.where(_LOOKED > 0, (east, north), (west, south))
    border = np.maximum((edge - centre) / _LOOKED, 0).min(2)
    reach = np.array([max(c.distance_m[0], _REACH_M) if len(c.distance_m) else _REACH_M
                      for c in choices])  # fmt: skip
    sure = 1 - _UNSEEN * (border < reach[:, None]).mean(1)
    kind = np.array([city.landmark(i).kind for i in landmarks])
    housed = (kind == "building") | ((kind == "poi") & (shapely.area(own) > 0))
    trusted: NDArray[np.float64] = np.where(housed, sure, sure * (1 - _UNFAMILIAR))
    return trusted


def _mixtures(
    mean_rad: NDArray[np.float64], kappa: NDArray[np.float64], weight: NDArray[np.float64]
) -> list[FrameDistribution]:
    """Return N mixtures, the heaviest parts first; what is light or flat is left to the lapse.

    Parameters
    ----------
    mean_rad, kappa, weight
        Mean, kappa and weight of P parts each, shape (N, P); weights sum to at most one.

    Returns
    -------
    list of FrameDistribution
        N of them; each lapse is what its kept parts lack to one.
    """
    order = np.argsort(-weight, axis=1, kind="stable")
    kept = (weight >= _LEAST) & (kappa >= _FLAT)
    found: list[FrameDistribution] = []
    for i, row in enumerate(order):
        which = row[kept[i, row]]
        parameters = (one[i, which].tolist() for one in (mean_rad, kappa, weight))
        parts = tuple(
            FramePart(math.remainder(mean, 2 * math.pi), spread, share)
            for mean, spread, share in zip(*parameters, strict=True)
        )
        found.append(FrameDistribution(parts, lapse=1 - sum(part.weight for part in parts)))
    return found


def _merged_first(
    count: int,
    mean_rad: NDArray[np.float64],
    kappa: NDArray[np.float64],
    weight: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return mixtures whose first parts are replaced with one, put last.

    Parameters
    ----------
    count
        How many are merged, into the von Mises with their first moment; they are equally
        concentrated.
    mean_rad, kappa, weight
        Mean, kappa and weight of P parts each, shape (N, P).

    Returns
    -------
    tuple of numpy.ndarray
        The same three of P - count + 1 parts.

    Notes
    -----
    The mean resultant of a von Mises is about 1 - 1/(2 kappa) for kappa > 2; the inverse is the
    approximation of Best and Fisher (1981).
    """
    share, spread = weight[:, :count], kappa[:, 0]
    total = share.sum(1)
    some = total >= 1e-12
    moment = (share * np.exp(1j * mean_rad[:, :count])).sum(1) / np.where(some, total, 1.0)
    r = np.abs(moment) * (1 - 1 / (2 * np.maximum(spread, 2.0)))
    wide = np.where(r < 0.53, 2 * r + r**3 + 5 * r**5 / 6, -0.4 + 1.39 * r + 0.43 / (1 - r))
    combined = np.where(r < 0.85, wide, 1 / np.maximum(r**3 - 4 * r**2 + 3 * r, 1e-12))
    one = (np.angle(moment), np.minimum(combined, spread), total)
    mean, concentration, whole = (
        np.concatenate([old[:, count:], np.where(some, new, 0.0)[:, None]], 1)
        for old, new in zip((mean_rad, kappa, weight), one, strict=True)
    )
    return mean, concentration, whole


for _name in ("ego-ctx", "ctx", "ego"):
    FRAME_PREDICTORS.add(_name, LearnedFrames(shipped_weights(_name)))
