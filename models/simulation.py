"""Run the speaker forward: place targets, and say where they are."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import torch
from numpy.typing import NDArray

from sloop_ppl._cell_axes import in_order
from sloop_ppl.errors import InputError
from sloop_ppl.language import DEFAULT_TARGETS, Description, SpatialRelation, TargetObject
from sloop_ppl.maps import CityMap
from sloop_ppl.models._shared_latents import latents_of
from sloop_ppl.models._vocabulary import in_english, speakable_grounds, speaker_words
from sloop_ppl.models.components import Component
from sloop_ppl.models.frames import PredictedSpread
from sloop_ppl.models.grounded_relation import GroundedRelation, ground_relations, word_options
from sloop_ppl.models.likelihoods import LIKELIHOODS
from sloop_ppl.models.presets import ObservationModel, preset
from sloop_ppl.models.program import word_weights

__all__ = ["SPEAKER", "Latents", "Simulated", "simulate", "speaker_of", "why_not_generative"]

_ANGLES = 360  # as many as `sloop_ppl.models.program` sums a speaker's fronts over
_TOGETHER = 128
"""Phrases weighed together: each front is tried with each cell, though but one is wanted."""

SPEAKER = ObservationModel(
    name="speaker",
    components=(
        Component("literal", 0.85),
        Component("uninformative", 0.15, combine="uninformative"),
    ),
    likelihood=LIKELIHOODS["student-vonmises"],
    frame_prior=PredictedSpread(absolute=0.0),
    normalisation="speaker",
    lapse=0.1,
)
"""A speaker whose every choice has a probability: means what is said, or chooses carelessly.

Set by hand: careless of one target in seven and of one phrase in ten; left and right are the
ground's, as every word is chosen by what the ground's front makes true."""


def speaker_of(model: str | ObservationModel) -> ObservationModel:
    """Return a model as a speaker: each phrase a choice among what could have been said.

    Parameters
    ----------
    model
        A model's name, or an ObservationModel; one that speaks is returned as it is.

    Returns
    -------
    ObservationModel
        With ``speaker`` normalisation, neither tempered nor blurred, frames not shared. Components
        that are plain products of all phrases keep their weight; what the others have goes to words
        chosen carelessly. It runs forward (`simulate`), and its evidence is a probability of what
        was said.

    Raises
    ------
    UnknownName
        When there is no such model.
    InputError
        When it cannot speak: no component is a plain product, or it declares latents.

    Notes
    -----
    `bayes` is a listener: factors normalised over the map, tempered since phrases of one speaker
    are not independent. What it believes is not what its speaker would lead a listener of the
    same kind to believe; docs/models.md says by how much they differ.

    Examples
    --------
    >>> speaker_of("bayes").normalisation
    'speaker'
    """
    chosen = preset(model)
    if why_not_generative(chosen) is None:
        return chosen
    if latents_of(chosen):
        raise InputError(
            f"Model '{chosen.name}' declares latents, which a speaker does not draw; leave them "
            "out to let it speak"
        )
    literal = sum(p.weight for p in chosen.components if p.uses_frames and not chosen.needs_truth)
    if not literal:
        raise InputError(
            f"Model '{chosen.name}' has no component that is a plain product of phrases, so it "
            "cannot speak; expected one such as bayes or sloop"
        )
    uninformative = sum(p.weight for p in chosen.components) - literal
    parts = [Component("literal", literal)]
    if uninformative > 0:
        parts.append(Component("uninformative", uninformative, combine="uninformative"))
    return replace(
        chosen,
        name=f"{chosen.name}, speaking",
        components=tuple(parts),
        normalisation="speaker",
        temper=0.0,
        error_m=0.0,
        unreliable=0.0,
        shared_frames=False,
        variant="published",
    )


@dataclass(frozen=True)
class Latents:
    """What lay behind what was said of one target.

    Parameters
    ----------
    place_m
        Centre of its cell, (x, y) metres.
    cell
        Row (row 0 in the south) and column.
    component
        Name of the speaker's component.
    frame_angles_rad
        Per phrase, the front its ground had for the speaker.
    lapses
        Per phrase, whether it was a slip.
    """

    place_m: tuple[float, float]
    cell: tuple[int, int]
    component: str
    frame_angles_rad: tuple[float, ...]
    lapses: tuple[bool, ...]


@dataclass(frozen=True)
class Simulated:
    """A description and what lay behind it.

    Parameters
    ----------
    description
        Relations, and the text that says them.
    latents
        Target -> what lay behind.
    """

    description: Description
    latents: Mapping[str, Latents]


def simulate(
    city: CityMap,
    targets: Sequence[str | TargetObject],
    rng: np.random.Generator,
    *,
    model: str | ObservationModel = SPEAKER,
    phrases: int | tuple[int, int] = (1, 3),
    grounds: Sequence[str] | None = None,
    prior: NDArray[np.float64] | None = None,
) -> Simulated:
    """Draw a description from the generative model.

    Parameters
    ----------
    city
        The map.
    targets
        Objects, or ids; the ids of the default objects have their names.
    rng
        Where everything is drawn from.
    model
        A model's name, or an ObservationModel, as a speaker; see `speaker_of`.
    phrases
        How many phrases a target gets: a number, or the least and the most, as likely each.
    grounds
        Ids of the landmarks that may be spoken of; those with a name of their own when None.
    prior
        Weights of the cells, shape (H, W); uniform when None.

    Returns
    -------
    Simulated
        The relations, English that `sloop_ppl.parse` reads back, and the latents.

    Raises
    ------
    InputError
        When the model cannot be run forward, or there are too few grounds.

    Notes
    -----
    For each target: component, then cell, from their priors; grounds uniformly without
    replacement, whatever the cell, so that inference loses nothing by taking them as given; for
    each phrase a front from the model's prior, a slip with the model's lapse, and a word: any
    when it slips or the component is idle, else from the softmax over `speaker_words` of log g.
    Fronts are drawn from the same angles that inference sums over.

    Examples
    --------
    >>> from sloop_ppl.maps import load_map
    >>> drawn = simulate(load_map("cleveland"), ["RedBike"], np.random.default_rng(0), phrases=2)
    >>> len(drawn.description.relations)
    2
    """
    model = speaker_of(model)
    named = {target.id: target for target in DEFAULT_TARGETS}
    objects = tuple(
        named.get(t, TargetObject(t, (t,))) if isinstance(t, str) else t for t in targets
    )
    choice = tuple(speakable_grounds(city) if grounds is None else grounds)
    least, most = (phrases, phrases) if isinstance(phrases, int) else phrases
    if not 1 <= least <= most <= len(choice):
        raise InputError(
            f"A target should get {least} to {most} phrases; expected 1 to {len(choice)}, the "
            "number of grounds that can be spoken of"
        )
    weights = np.ones(city.grid.size) if prior is None else _weights(prior, city)
    grounded: dict[str, _Ground] = {}
    drawn = []
    for _ in objects:
        picked = rng.choice(len(choice), int(rng.integers(least, most + 1)), replace=False)
        for ground in (choice[i] for i in picked):
            if ground not in grounded:
                grounded[ground] = _Ground.of(ground, city, model)
        drawn.append(_draw([grounded[choice[i]] for i in picked], model, weights, rng))
    words = _choose_words([phrase for about in drawn for phrase in about.phrases], model)
    relations, latents = [], {}
    for target, about in zip(objects, drawn, strict=True):
        relations += [
            SpatialRelation(target.id, next(words), (phrase.about.term.ground,))
            for phrase in about.phrases
        ]
        latents[target.id] = about.latents(city)
    text = in_english(relations, objects, city)
    return Simulated(Description(text, city.name, objects, tuple(relations)), latents)


def _weights(prior: NDArray[np.float64], city: CityMap) -> NDArray[np.float64]:
    """Return the weights of cells, shape (S,); a table of xarray is read by its coordinates."""
    found = in_order(prior, "The prior", city.grid)
    weights = np.asarray(found, dtype=np.float64, order="C")
    if weights.shape != city.grid.shape:
        raise InputError(f"The prior has shape {weights.shape}; expected {city.grid.shape}")
    if not (np.isfinite(weights).all() and (weights >= 0).all() and weights.any()):
        raise InputError("The prior holds NaN, infinite, negative or no weights; expected weights")
    return weights.reshape(-1)


@dataclass(frozen=True, eq=False)
class _Ground:
    """A ground that may be spoken of, and the fronts it may have."""

    term: GroundedRelation
    frame_angles_rad: NDArray[np.float64]
    mass: NDArray[np.float64]

    @classmethod
    def of(cls, ground: str, city: CityMap, model: ObservationModel) -> _Ground:
        about = SpatialRelation("", "front", (ground,))
        (term,) = ground_relations((about,), city, joint=model.joint_grounds)
        believed = model.frame_prior_for(term)
        if believed is None:  # not under "speaker" normalisation
            return cls(term, np.zeros(1), np.ones(1))
        angles, mass = believed.bins(_ANGLES)
        return cls(term, angles, mass / mass.sum())


@dataclass(frozen=True)
class _Phrase:
    """What one phrase is about, and what decides its word; `level` is where in its chances."""

    about: _Ground
    cell: int
    frame_angle: float
    lapsed: bool
    is_uninformative: bool
    level: float


@dataclass(frozen=True)
class _Drawn:
    component: str
    cell: int
    phrases: tuple[_Phrase, ...]

    def latents(self, city: CityMap) -> Latents:
        row, col = divmod(self.cell, city.grid.n_cols)
        place = (float(city.grid.x_m[col]), float(city.grid.y_m[row]))
        angles = tuple(phrase.frame_angle for phrase in self.phrases)
        lapses = tuple(phrase.lapsed for phrase in self.phrases)
        return Latents(place, (row, col), self.component, angles, lapses)


def _draw(
    grounds: Sequence[_Ground],
    model: ObservationModel,
    weights: NDArray[np.float64],
    rng: np.random.Generator,
) -> _Drawn:
    """Draw all that lies behind what is said of one target."""
    mixture = np.array([part.weight for part in model.components])
    component = model.components[rng.choice(len(mixture), p=mixture / mixture.sum())]
    cell = int(rng.choice(len(weights), p=weights / weights.sum()))
    phrases = []
    for about in grounds:
        frame_angle = float(rng.choice(about.frame_angles_rad, p=about.mass))
        lapsed = bool(rng.random() < model.lapse)
        is_uninformative = lapsed or component.combine == "uninformative"
        phrases.append(
            _Phrase(about, cell, frame_angle, lapsed, is_uninformative, float(rng.random()))
        )
    return _Drawn(component.name, cell, tuple(phrases))


def _choose_words(phrases: Sequence[_Phrase], model: ObservationModel) -> Iterator[str]:
    """Yield the word of each phrase, those about one ground weighed together."""
    chances = np.full((len(phrases), len(speaker_words())), 1 / len(speaker_words()))
    by_ground: dict[str, list[int]] = {}
    for i, phrase in enumerate(phrases):
        if not phrase.is_uninformative:
            by_ground.setdefault(phrase.about.term.ground, []).append(i)
    for whole in by_ground.values():
        for start in range(0, len(whole), _TOGETHER):
            some = whole[start : start + _TOGETHER]
            chances[some] = _word_chances([phrases[i] for i in some], model)
    ends = chances.cumsum(1)
    for phrase, end in zip(phrases, ends / ends[:, -1:], strict=True):
        yield speaker_words()[int(np.searchsorted(end, phrase.level, side="right"))]


def _word_chances(phrases: Sequence[_Phrase], model: ObservationModel) -> NDArray[np.float64]:
    """Return the probability of each word for each phrase about one ground, shape (P, V)."""
    term = phrases[0].about.term.at(np.array([phrase.cell for phrase in phrases]))
    options, _ = word_options(term)
    with torch.no_grad():
        angles = np.array([phrase.frame_angle for phrase in phrases])
        weighed = word_weights(model.likelihood, options, angles)
        each = [weighed.log_chance(word).diagonal() for word in range(len(options))]
    chances: NDArray[np.float64] = torch.stack(each, 1).exp().numpy()
    return chances


def why_not_generative(model: ObservationModel) -> str | None:
    """Return why a model gives what is said no probability; None for one that can speak."""
    if model.normalisation != "speaker":
        return (
            f"Model '{model.name}' has '{model.normalisation}' normalisation, which gives words "
            "no probability; expected 'speaker'"
        )
    for part in model.components:
        literal = part.combine == "product" and part.read_as is None and part.keep_frames
        if not (literal or part.combine == "uninformative") or part.cut:
            return (
                f"Component '{part.name}' of model '{model.name}' gives words no probability; "
                "expected plain products and combine='uninformative'"
            )
    if latents_of(model):
        return f"Model '{model.name}' declares latents, which a simulated speaker does not draw"
    if model.temper or model.error_m or model.shared_frames:
        return (
            f"Model '{model.name}' tempers, blurs or shares frames, which the speaker does not; "
            "set temper and error_m to 0 and shared_frames to False"
        )
    return None
