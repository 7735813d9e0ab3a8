"""Predict fronts with a trained network."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray

from sloop_ppl.maps import CityMap
from sloop_ppl.maps.landmark import PATH_KINDS
from sloop_ppl.models.frames.distribution import FrameDistribution, FramePart
from sloop_ppl.models.frames.image import pictures_of
from sloop_ppl.models.frames.network import DIRECTIONS
from sloop_ppl.models.frames.predictor import FRAME_PREDICTORS, plain_front
from sloop_ppl.models.frames.streets import FEATURES, Choices, facing_choices
from sloop_ppl.models.frames.weights import TrainedFrames, load_weights
from sloop_ppl.models.terms import RelationTerm

__all__ = ["LearnedFrames", "padded_choices", "predict_fronts", "shipped_weights"]

_TURNS = 4
_CHUNK = 256
_LEAST = 0.01  # parts that weigh less are left to the lapse
_FLAT = 0.5  # so are parts of a lesser concentration
_UNSEEN = 0.5  # how often what lies beyond the map's edge is what a building faces
_UNFAMILIAR = 0.3  # extra lapse of what is no building, which no network was trained on
_REACH_M = 40.0


def shipped_weights(name: str) -> Path:
    """Return the path of the weights that ship with the package under a name."""
    return Path(str(files("sloop_ppl"))) / "data" / "frames" / f"{name}.safetensors"


@dataclass(frozen=True)
class LearnedFrames:
    """A trained network as a frame predictor; its weights are read when they are first needed.

    Parameters
    ----------
    weights : path of a weights file; see :func:`sloop_ppl.models.frames.load_weights`.

    Notes
    -----
    Source: SLOOP sec. IV-C (EGO-CTX, CTX, EGO), with a distribution in place of the angle.
    """

    weights: Path

    def __call__(self, term: RelationTerm) -> FrameDistribution:
        """Return the distribution of the ground's front, the same for all words."""
        plain = plain_front(term)
        return plain if plain is not None else self.predict(term.city, [term.ground])[0]

    def predict(self, city: CityMap, landmarks: Sequence[str]) -> list[FrameDistribution]:
        """Return which way each landmark faces; a prediction is made once a map.

        Raises
        ------
        InputError : when the weights cannot be used.
        UnknownName : when the map has no such landmark.
        """
        known: dict[str, FrameDistribution] = city.derived(f"fronts by {self.weights}", dict)
        missing = [i for i in dict.fromkeys(landmarks) if i not in known]
        if missing:
            made = predict_fronts(_loaded(self.weights), city, missing)
            known.update(zip(missing, made, strict=True))
        return [known[i] for i in landmarks]


@cache
def _loaded(path: Path) -> TrainedFrames:
    return load_weights(path)


def predict_fronts(
    trained: TrainedFrames, city: CityMap, landmarks: Sequence[str]
) -> list[FrameDistribution]:
    """Return which way each landmark faces.

    Parameters
    ----------
    trained : a network.
    city : the map.
    landmarks : ids.

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
    view = trained.network.shape.view
    found = []
    for start in range(0, len(landmarks), _CHUNK):
        some = landmarks[start : start + _CHUNK]
        choices = [facing_choices(city, i) for i in some]
        pictures = pictures_of(city, some, view)
        mean, kappa, weight = _answers(trained, pictures, choices)
        for i, name in enumerate(some):
            sure = _sureness(city, name, choices[i])
            count = _parts(trained, len(choices[i].bearing_rad))
            found.append(_distribution(trained, mean[i], kappa[i], weight[i], count, sure))
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
    bearing, features, there = (torch.from_numpy(a) for a in padded_choices(choices))
    seen, quarter = torch.from_numpy(pictures), math.pi / 2
    turns = range(_TURNS)
    with torch.inference_mode():  # all turns at once: a small step costs as much as a large one
        answer = trained.network(
            torch.cat([torch.rot90(seen, -turn, (-2, -1)) for turn in turns]),
            torch.cat([bearing + turn * quarter for turn in turns]),
            features.repeat(_TURNS, 1, 1),
            there.repeat(_TURNS, 1),
        )
    mean, kappa = answer.mean_rad.chunk(_TURNS), answer.kappa.chunk(_TURNS)
    weight = answer.log_weight.exp().chunk(_TURNS)
    if trained.network.shape.angle:
        turned = [mean[turn] - turn * quarter for turn in turns]
        shares = [weight[turn][:, :1] / _TURNS for turn in turns]
        return (
            _float64(torch.cat(turned, 1)),
            _float64(torch.cat(kappa, 1)),
            _float64(torch.cat([*shares, weight[0][:, -1:]], 1)),
        )
    whole = torch.stack([_turned_back(weight[turn], turn) for turn in turns]).mean(0)
    return _float64(mean[0]), _float64(kappa[0]), _float64(whole)


def _turned_back(weight: torch.Tensor, turn: int) -> torch.Tensor:
    """Return the weights with those of the directions where they were before the turn."""
    directions = torch.roll(weight[:, :DIRECTIONS], -turn * DIRECTIONS // _TURNS, 1)
    return torch.cat([directions, weight[:, DIRECTIONS:]], 1)


def _float64(tensor: torch.Tensor) -> NDArray[np.float64]:
    return tensor.numpy().astype(np.float64)


def _parts(trained: TrainedFrames, streets: int) -> int:
    shape = trained.network.shape
    return _TURNS if shape.angle else DIRECTIONS + (streets if shape.streets else 0)


def _distribution(
    trained: TrainedFrames,
    mean: NDArray[np.float64],
    kappa: NDArray[np.float64],
    weight: NDArray[np.float64],
    count: int,
    sure: float,
) -> FrameDistribution:
    """Return the mixture of the first parts; where streets are parts, the rest becomes one."""
    mean, kappa, share = mean[:count], kappa[:count], sure * weight[:count] / weight.sum()
    if trained.network.shape.streets:
        free = _merged(mean[:DIRECTIONS], float(kappa[0]), share[:DIRECTIONS])
        mean, kappa, share = (
            np.append(old[DIRECTIONS:], new)
            for old, new in zip((mean, kappa, share), free, strict=True)
        )
    order = np.argsort(-share, kind="stable")
    parts = tuple(
        FramePart(math.remainder(float(mean[i]), 2 * math.pi), float(kappa[i]), float(share[i]))
        for i in order
        if share[i] >= _LEAST and kappa[i] >= _FLAT
    )
    return FrameDistribution(parts, lapse=1 - sum(part.weight for part in parts))


def _merged(
    mean: NDArray[np.float64], kappa: float, share: NDArray[np.float64]
) -> tuple[float, float, float]:
    """Return mean, concentration and weight of the von Mises with the first moment of several.

    Notes
    -----
    The mean resultant of a von Mises is about 1 - 1/(2 kappa) for kappa > 2; the inverse is the
    approximation of Best and Fisher (1981).
    """
    total = float(share.sum())
    if total < 1e-12:
        return 0.0, 0.0, 0.0
    moment = complex((share * np.exp(1j * mean)).sum()) / total
    r = abs(moment) * (1 - 1 / (2 * max(kappa, 2.0)))
    if r < 0.53:
        combined = 2 * r + r**3 + 5 * r**5 / 6
    elif r < 0.85:
        combined = -0.4 + 1.39 * r + 0.43 / (1 - r)
    else:
        combined = 1 / (r**3 - 4 * r**2 + 3 * r)
    return math.atan2(moment.imag, moment.real), min(combined, kappa), total


def _sureness(city: CityMap, landmark_id: str, choices: Choices) -> float:
    """Return how far a prediction can be trusted, in (0, 1], apart from what the network says.

    The share of the directions in which the map ends before the nearest street is unseen. What is
    no building has an extra lapse.
    """
    x, y = city.centroid(landmark_id)
    west, south, east, north = city.grid.extent_m
    angle = np.arange(32) * (2 * math.pi / 32)
    with np.errstate(divide="ignore", invalid="ignore"):
        sideways = np.where(np.cos(angle) > 0, east - x, west - x) / np.cos(angle)
        upright = np.where(np.sin(angle) > 0, north - y, south - y) / np.sin(angle)
    border = np.fmin(np.maximum(sideways, 0), np.maximum(upright, 0))
    reach = float(choices.distance_m[0]) if len(choices.distance_m) else _REACH_M
    sure = 1 - _UNSEEN * float((border < max(reach, _REACH_M)).mean())
    kind = city.landmark(landmark_id).kind
    housed = kind == "building" or (kind == "poi" and city.footprint(landmark_id).area > 0)
    return sure if housed else sure * (1 - _UNFAMILIAR)


for _name in ("ego-ctx", "ctx", "ego"):
    FRAME_PREDICTORS.add(_name, LearnedFrames(shipped_weights(_name)))
