"""The paper's six methods, ours and a comparator, by name."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

from sloop_ppl.errors import InputError, UnknownName
from sloop_ppl.models._guard import guarded, trusted
from sloop_ppl.models._vocabulary import speaker_words
from sloop_ppl.models.components import Component
from sloop_ppl.models.frames import (
    FrameDistribution,
    FramePrior,
    PredictedPoint,
    UniformFrame,
)
from sloop_ppl.models.grounded_relation import GroundedRelation
from sloop_ppl.models.latents import Latent
from sloop_ppl.models.likelihoods import LIKELIHOODS, RelationLikelihood
from sloop_ppl.registry import Registry

__all__ = ["PRESETS", "VARIANTS", "ObservationModel", "preset"]

Normalisation = Literal["truth", "map", "speaker"]
VARIANTS = ("published", "paper")
"""Which source a `sloop*` preset follows: the authors' published code, or the paper's text."""


@dataclass(frozen=True)
class ObservationModel:
    """A complete observation model.

    Parameters
    ----------
    name
        What it is called.
    components
        The mixture's components, at least one.
    likelihood
        How true a relation is of each cell.
    frame_prior
        What is believed about which way a ground faces.
    normalisation
        ``"map"`` divides each component by its sum over the map, as the paper's mixture does;
        ``"truth"`` leaves the raw probability that the phrases are true; ``"speaker"`` divides by
        what else could have been said of the ground there.
    lapse
        Probability that a phrase is wrong and says nothing, in [0, 1).
    own_lapse
        The same for what speakers say of where they are themselves; None for `lapse`.
    temper
        How far to temper a component of L phrases, in [0, 1]: its log likelihood is divided by L to
        this power. 0 multiplies the phrases as if they were independent.
    error_m
        Standard deviation of an error that all phrases of a description share: the speaker
        describes a place this far from the true one in each direction, metres, >= 0.
    joint_grounds
        True to give a relation to several grounds its own meaning; False to read it as one relation
        per ground, as the published code does.
    heed_distance
        True to read a said distance ("about 50 feet west of"); False to ignore it, as the published
        code does.
    denial
        How far a denied phrase is believed, in [0, 1]: under ``"map"`` normalisation "not near the
        bank" has 1 - denial g / max g, so that 1 rules out the place where g is greatest.
    unreliable
        Probability that nothing a speaker says means anything: all of one speaker's phrases, of all
        targets, lapse together; in [0, 1).
    shared_frames
        True when one speaker keeps one frame per ground: phrases about the same ground, of any
        target of the description, share its front.
    informed_sigma_m
        Width of a Gaussian around the true place that takes the language's part, metres; None for a
        model that listens.
    variant
        One of `VARIANTS`.
    latents
        Further latents that its program draws; see :class:`sloop_ppl.models.Latent`.
    sum_readings
        True to sum over the readings and alternatives of a description; False to take the most
        probable reading, and of alternatives the first, as the paper's methods do.
    sum_grounds
        True to sum over what each mention may refer to; False to take the most probable place.

    Raises
    ------
    InputError
        When there is no component, or a number is out of its range.

    Examples
    --------
    >>> from dataclasses import replace
    >>> from sloop_ppl.models import preset
    >>> wary = replace(preset("bayes"), name="wary", lapse=0.1)
    >>> wary.normalisation, wary.temper > 0
    ('map', True)
    """

    name: str
    components: tuple[Component, ...]
    likelihood: RelationLikelihood
    frame_prior: FramePrior
    normalisation: Normalisation = "map"
    lapse: float = 0.0
    temper: float = 0.0
    error_m: float = 0.0
    joint_grounds: bool = False
    heed_distance: bool = False
    denial: float = 0.95
    unreliable: float = 0.0
    shared_frames: bool = False
    informed_sigma_m: float | None = None
    variant: str = "published"
    latents: tuple[Latent, ...] = ()
    sum_readings: bool = True
    sum_grounds: bool = True
    own_lapse: float | None = None

    def __post_init__(self) -> None:
        if not self.components:
            raise InputError(f"Model '{self.name}' has no component; expected at least one")
        if not isinstance(self.latents, tuple) or not all(
            isinstance(latent, Latent) for latent in self.latents
        ):
            raise InputError(
                f"Model '{self.name}' has the latents {self.latents!r}; expected a tuple of "
                "sloop_ppl.models.Latent, such as (Latent(...),)"
            )
        if not 0 <= self.lapse < 1:
            raise InputError(f"Model '{self.name}' has lapse {self.lapse}; expected 0 <= lapse < 1")
        if self.own_lapse is not None and not 0 <= self.own_lapse < 1:
            raise InputError(
                f"Model '{self.name}' has own_lapse {self.own_lapse}; expected 0 <= own_lapse < 1"
            )
        if not 0 <= self.denial <= 1:
            raise InputError(f"Model '{self.name}' has denial {self.denial}; expected 0 to 1")
        if not 0 <= self.unreliable < 1:
            raise InputError(
                f"Model '{self.name}' has unreliable {self.unreliable}; expected at least 0 and "
                "less than 1"
            )
        if not 0 <= self.temper <= 1:
            raise InputError(f"Model '{self.name}' has temper {self.temper}; expected 0 to 1")
        if not 0 <= self.error_m < math.inf:
            raise InputError(f"Model '{self.name}' has error_m {self.error_m}; expected >= 0")
        if self.shared_frames and any(part.cut for part in self.components):
            raise InputError(
                f"Model '{self.name}' shares frames and cuts below uniform; choose one of the two"
            )

    @property
    def needs_truth(self) -> bool:
        """Tell whether the model has to be told where the targets are."""
        return self.informed_sigma_m is not None

    def lapse_of(self, term: GroundedRelation) -> float:
        """Return the probability that a phrase is wrong; see `lapse` and `own_lapse`."""
        own = self.own_lapse if term.is_own_place else None
        return self.lapse if own is None else own

    def frame_prior_for(self, term: GroundedRelation) -> FrameDistribution | None:
        """Return the prior of the front that a phrase depends on; None when it depends on none.

        Under ``"speaker"`` normalisation every phrase does, since the front decides what else
        could have been said; that prior is the one of "front" for all words. Which way who listens
        faces, or a thing that is searched for, no one knows: any way, unless it is set from
        outside.
        """
        if term.is_silent:
            return None
        speaks = self.normalisation == "speaker"
        if not speaks and not term.needs_frame:
            return None
        prior = self.frame_prior
        if term.is_point:
            prior = getattr(self.frame_prior, "of_point", UniformFrame())
        return prior(term.as_relation("front") if speaks else term)

    def log_uninformative(self, cells: int) -> float:
        """Return the log probability of a phrase that says nothing, the same at every cell.

        Under ``"map"`` normalisation it is uniform over cells, under ``"truth"`` an even chance,
        and under ``"speaker"`` any word is as likely.
        """
        level = {"map": 1 / cells, "truth": 0.5, "speaker": 1 / len(speaker_words())}
        return math.log(level[self.normalisation])


PRESETS: Registry[ObservationModel] = Registry("model")
"""Models by name; `preset` looks one up."""


def preset(name: str | ObservationModel, variant: str = "published") -> ObservationModel:
    r"""Return the model of this name.

    Parameters
    ----------
    name
        A name in `PRESETS`, or an ObservationModel, which is returned as it is, except that what a
        likelihood from outside this package returns is checked at every call.
    variant
        ``"published"`` for the authors' code; ``"paper"`` for the paper's text: \|u.v\|, directions
        from the nearest cell, at .05 and near .1, no cut. Only the ``sloop*`` models have the two.

    Raises
    ------
    UnknownName
        When there is no such model or variant.
    InputError
        When it is neither a name nor an ObservationModel, or has no such variant.

    Examples
    --------
    >>> [c.name for c in preset("sloop-m4").components]
    ['product', 'no-frame', 'at', 'near']
    """
    if isinstance(name, ObservationModel):
        if variant != name.variant and variant != "published":
            raise InputError(
                f"Model '{name.name}' is given as an ObservationModel; leave the variant out"
            )
        return _guarded(name)
    if not isinstance(name, str):
        raise InputError(
            f"Model is a {type(name).__name__}; expected a name of sloop_ppl.models.PRESETS or an "
            "ObservationModel; a likelihood goes into one: replace(preset('bayes'), likelihood=...)"
        )
    found = _guarded(PRESETS[name])
    if variant not in VARIANTS:
        raise UnknownName("variant", variant, VARIANTS)
    if variant == "published":
        return found
    if not name.startswith("sloop"):
        raise InputError(
            f"Model '{name}' has no variant '{variant}'; only the sloop models follow the paper's "
            "text or its published code"
        )
    return _as_in_the_text(found)


def _guarded(model: ObservationModel) -> ObservationModel:
    if trusted(model.likelihood):
        return model
    return replace(model, likelihood=guarded(model.likelihood))


def _as_in_the_text(published: ObservationModel) -> ObservationModel:
    weights = {"at": 0.05, "near": 0.1} if len(published.components) == 4 else {}
    combine = {"at": "product", "near": "product"}
    components = tuple(
        replace(
            part,
            cut=False,
            weight=weights.get(part.name, part.weight),
            combine=combine.get(part.name, part.combine),
        )
        for part in published.components
    )
    return replace(
        published,
        components=components,
        likelihood=LIKELIHOODS["gaussian-cosine"],
        variant="paper",
    )


def _register(name: str, *components: Component, informed_sigma_m: float | None = None) -> None:
    PRESETS.add(
        name,
        ObservationModel(
            name=name,
            components=components,
            likelihood=LIKELIHOODS["gaussian-clipped"],
            frame_prior=PredictedPoint(),
            informed_sigma_m=informed_sigma_m,
            sum_readings=False,
            sum_grounds=False,
        ),
    )


_register("uniform", Component("uniform", combine="nothing"))
_register("keyword", Component("keyword", combine="keyword"))
_register("informed", Component("informed", combine="nothing"), informed_sigma_m=25.0)
_register("sloop", Component("product", cut=True))
_register(
    "sloop-m2",
    Component("product", 0.8, cut=True),
    Component("near", 0.2, combine="sum", read_as="near"),
)
_register(
    "sloop-m4",
    Component("product", 0.6, cut=True),
    Component("no-frame", 0.25, keep_frames=False, cut=True),
    Component("at", 0.1, combine="sum", read_as="at"),
    Component("near", 0.05, combine="sum", read_as="near"),
)
PRESETS.add_later("bayes", "sloop_ppl.models.bayes", "BAYES")
PRESETS.add_later("referent-gaussian", "sloop_ppl.models.referent_gaussian", "REFERENT_GAUSSIAN")
