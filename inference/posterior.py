"""The belief over each target's cell after language and sensing, with its latents open to view."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.special import softmax

from sloop_ppl._cell_axes import in_order
from sloop_ppl.errors import BeliefCollapse, InputError, NoRelationFound, UnknownName
from sloop_ppl.inference._belief_summaries import BeliefSummaries
from sloop_ppl.inference._draws import (
    CHAINS,
    PhraseWord,
    draws_from,
    inverse,
    to_arviz,
    uniforms_for,
)
from sloop_ppl.inference._log_evidence import LogEvidence
from sloop_ppl.inference._log_tables import LogTable
from sloop_ppl.inference._pairs import pair_table
from sloop_ppl.inference._phrase_tables import PhraseTables
from sloop_ppl.inference._store import StoredPosterior, load_parts, save_parts, to_dataset
from sloop_ppl.inference._utterances import utterances_about
from sloop_ppl.inference.answers import (
    AnswerFactor,
    CheckedAnswer,
    check_answer,
    checked_answers,
    renumbered,
)
from sloop_ppl.inference.belief_comparison import BeliefComparison, compare_beliefs
from sloop_ppl.inference.engines import Engine, Exact, InferenceInfo
from sloop_ppl.inference.export_geojson import cells_geojson
from sloop_ppl.inference.factors import (
    DescriptionFactor,
    by_speaker,
    joint_posterior,
    site_name,
    weigh,
)
from sloop_ppl.inference.frames import (
    Framed,
    FramePosterior,
    FrameSummary,
    find_framed,
    frame_array,
    frame_table,
    framed_relations,
    summarise_frames,
)
from sloop_ppl.inference.influence import Influence, bits_between, without_relation
from sloop_ppl.inference.joint import JointPosterior
from sloop_ppl.inference.lapses import Lapse, lapses_of
from sloop_ppl.inference.predictive import PhraseCheck, check_phrase, word_table
from sloop_ppl.inference.prior import log_priors
from sloop_ppl.inference.referents import (
    GroundPosterior,
    ReadingPosterior,
    readings_of,
    referents_of,
)
from sloop_ppl.language import Description, SpatialRelation
from sloop_ppl.maps import CityMap, SearchArea
from sloop_ppl.models import GroundedRelation, Latent, ObservationModel, PairKernel
from sloop_ppl.models._vocabulary import speaker_words
from sloop_ppl.models.grounded_relation import word_options
from sloop_ppl.models.simulation import Simulated, speaker_of

if TYPE_CHECKING:
    import xarray

__all__ = ["Posterior", "check_possible"]

Table = NDArray[np.float64]

_MOST_DRAWN = 4  # targets in a notebook; all are in its table


@dataclass(frozen=True, eq=False, repr=False)
class Posterior(BeliefSummaries):
    """What is believed about where targets are. Immutable: evidence returns a new one.

    It is a `JointPosterior`, its attribute `joint`, with the map, the model and the descriptions
    it came from; its methods ask that joint.

    Shape legend: H, W grid; S = H W cells; K components.

    Parameters
    ----------
    city
        The map.
    model
        The observation model.
    method
        The engine that weighs what is said.
    log_prior
        Target -> log belief before anything was said, shape (S,).
    factors
        The descriptions, weighed, in the order they came.
    log_sensed
        Target -> log likelihood of all that was sensed, shape (S,).
    info
        How the last inference went.
    area
        Where targets are searched for: they are nowhere else, whatever is said or sensed later.
        The whole map when None.
    answers
        What was answered to questions, in the order it came, which is of no account.

    Notes
    -----
    The posterior of a target's component and cell given what all speakers d said is
    prior(s) sensed(s) prod_d sum_k factor_d(k, s). The component, the count of phrases that
    tempering goes by, and shared frames belong to a speaker: two texts of one speaker are one
    longer description, those of several multiply, and the order never matters. A text without a
    name is a speaker by itself. Frames that a speaker shares between targets, and relations between
    targets, couple their beliefs: what is learnt of one tells of the other.

    Examples
    --------
    >>> import sloop_ppl as sloop
    >>> post = sloop.infer("The red bike is west of Hoyt Block.", "cleveland")
    >>> post.mode("RedBike"), post.belief("RedBike").shape
    ((-22.5, -77.5), (41, 41))
    >>> post = post.update(sloop.parse("The red bike is near Velvet Dog.", post.city))
    >>> len(post.texts)
    2
    """

    city: CityMap
    model: ObservationModel
    method: Engine
    log_prior: Mapping[str, Table]
    factors: tuple[DescriptionFactor, ...]
    log_sensed: Mapping[str, Table]
    info: InferenceInfo | None = None
    area: SearchArea | None = None
    answers: tuple[AnswerFactor, ...] = ()
    _beliefs: dict[str, Table] = field(default_factory=dict, init=False)

    def __repr__(self) -> str:
        parts = []
        for target in self.targets:
            x, y = self.mode(target)
            parts.append(f"{target} near ({x:g}, {y:g}) m, {self.entropy(target):.2f} nats")
        return f"Posterior({self.city.name!r}, {self.model.name!r}: {'; '.join(parts)})"

    def _repr_html_(self) -> str:
        from sloop_ppl._html import beside, caption, html_table
        from sloop_ppl.maps._notebook import city_svg

        parts = []
        for target in self.targets[:_MOST_DRAWN]:
            marks = [(*self.mode(target), "#22252b")]
            heat = self.belief(target)
            drawing = city_svg(self.city, f"Belief of {target}", heat=heat, marks=marks)
            parts.append(caption(target) + drawing)
        head = ("target", "most probable, m", "entropy, nats", "90 % region, cells", "relations")
        rows = []
        for target in self.targets:
            x, y = self.mode(target)
            phrases = "; ".join(
                f"{r.relation} {', '.join(r.grounds)}" for r in self.relations(target)
            )
            size = int(self.hpd(target).sum())
            rows.append((target, f"{x:g}, {y:g}", self.entropy(target), size, phrases))
        what = f"Posterior on {self.city.name} under {self.model.name}"
        return caption(what) + beside(parts) + html_table(rows, head)

    @property
    def engine(self) -> str:
        """Name of the engine."""
        return self.method.name

    @property
    def targets(self) -> tuple[str, ...]:
        """Ids of the targets."""
        return tuple(self.log_prior)

    @cached_property
    def joint(self) -> JointPosterior:
        """The joint posterior of all latents, by the names of the program's sites."""
        return joint_posterior(self.log_prior, self.log_sensed, self.factors, self.answers)

    # What was said

    @property
    def descriptions(self) -> tuple[Description, ...]:
        """The descriptions, speaker by speaker, in the order they came."""
        return tuple(description for factor in self.factors for description in factor.descriptions)

    @property
    def texts(self) -> tuple[str, ...]:
        """The texts of the descriptions, in the order they came."""
        return tuple(d.text for d in self.descriptions)

    def relations(self, target: str) -> tuple[SpatialRelation, ...]:
        """Return what was said of a target."""
        return tuple(r for _, f in self._factors_about(target) for r in f.about(target))

    def grounded(self, target: str) -> tuple[GroundedRelation, ...]:
        """Return what was said of a target, grounded; position j is that of the sites ``_j``."""
        return tuple(
            term for _, factor in self._factors_about(target) for term in factor.relations(target)
        )

    @property
    def is_coupled(self) -> bool:
        """Tell whether what is learnt of one target tells of another.

        They share a latent, or it was said how they lie apart.
        """
        if any(f.pairs for f in self.factors):
            return True
        return any(len(targets) > 1 for f in self.factors for targets in f.data.holders.values())

    @property
    def related(self) -> frozenset[str]:
        """Targets of which it was said how they lie apart from another, figures and grounds."""
        pairs = [pair for factor in self.factors for pair in factor.pairs]
        return frozenset(name for pair in pairs for name in (pair.figure, pair.ground))

    @property
    def log_evidence(self) -> LogEvidence:
        """Log probability of all that was said and sensed; it ranks no unlike models.

        See :func:`sloop_ppl.inference.rank_models`.
        """
        used = {r.relation for d in self.descriptions for r in d.relations}
        words = (*speaker_words(), *sorted(used - set(speaker_words())))
        value = self.joint.log_evidence
        return LogEvidence(value, self.model.normalisation, self.model.name, words)

    # Where a target is

    def belief(self, target: str) -> Table:
        """Return the probability of each cell, summing to one, row 0 in the south, shape (H, W)."""
        self._check(target)
        if target not in self._beliefs:
            cells = self.joint.probabilities(f"{target}/cell")
            self._beliefs[target] = cells.reshape(self.city.grid.shape)
        return self._beliefs[target]

    def compare(self, other: Posterior) -> BeliefComparison:
        """Return how far the beliefs are from those of another posterior, target by target.

        Parameters
        ----------
        other
            A posterior over the same cells, such as that of another model or of a longer text.

        Raises
        ------
        InputError
            When it is no posterior, is over other cells, or has no target in common.
        """
        return compare_beliefs(self, other)

    # Components

    def component(self, target: str, which: int = -1) -> dict[str, float]:
        """Return the posterior probability of each component.

        Parameters
        ----------
        target
            Id of the target.
        which
            Which description about the target, the latest by default.

        Returns
        -------
        dict
            Component name -> probability; empty when nothing was said of the target.
        """
        if not self._factors_about(target):
            return {}
        name, factor = self._component(target, which)
        p = self.joint.probabilities(name)
        return dict(zip(factor.components, map(float, p), strict=True))

    def component_prior(self, target: str, which: int = -1) -> dict[str, float]:
        """Return the prior weight of each component of a description, 0 where it does not apply."""
        if not self._factors_about(target):
            return {}
        _, factor = self._component(target, which)
        weights = factor.data.log_weight_before(factor.data.targets.index(target)).exp()
        return dict(zip(factor.components, map(float, weights), strict=True))

    def joint_component(self, target: str, which: int = -1) -> xarray.DataArray:
        """Return p(component, cell), dims component, y, x, for one description of a target.

        Raises
        ------
        InputError
            When nothing was said of the target, or there is no such description.
        """
        name, factor = self._component(target, which)
        return self._over_cells(self.joint.probabilities(name, f"{target}/cell"), factor, "p")

    def responsibilities(self, target: str, which: int = -1) -> xarray.DataArray:
        """Return p(component | cell), dims component, y, x; NaN where the target cannot be."""
        name, factor = self._component(target, which)
        table = self.joint.probabilities(name, f"{target}/cell")
        mass = table.sum(0)
        share = np.divide(table, mass, out=np.full_like(table, np.nan), where=mass > 0)
        return self._over_cells(share, factor, "responsibility")

    # Frames

    def framed(self, target: str) -> tuple[Framed, ...]:
        """Return the relations of a target that depend on a frame of reference."""
        self._check(target)
        return framed_relations(self.factors, target)

    def frames(self, target: str) -> tuple[FrameSummary, ...]:
        """Return the posterior of every frame that was used in speaking of a target.

        One entry per part of the frame's prior (a street has two normals, left and right have the
        map's frame and the ground's), in the order the relations were said.
        """
        self._check(target)
        return summarise_frames(self.joint, self.factors, target)

    def frame(
        self, target: str, ground: str | None = None, relation: int | None = None, bins: int = 72
    ) -> xarray.DataArray:
        """Return how probable each direction of a ground's front is.

        Parameters
        ----------
        target
            Id of the target it was said of.
        ground
            Id of the landmark; may be left out when the target has one frame only.
        relation
            Index in :meth:`relations`, when two relations speak of the same ground.
        bins
            Number of equal directions B, the first centred on east, anticlockwise.

        Returns
        -------
        xarray.DataArray
            Dim angle (radians), sums to one; its coordinate ``prior`` is what was believed before.

        Raises
        ------
        InputError
            When nothing depends on a frame, or several frames fit.
        UnknownName
            When there is no such target, or no frame of such a ground.
        """
        return frame_array(self._frame(target, ground, relation), bins)

    def joint_frame(
        self, target: str, relation: int | None = None, ground: str | None = None, bins: int = 72
    ) -> xarray.DataArray:
        """Return p(front, cell), dims angle, y, x, for one frame; arguments as in :meth:`frame`."""
        return frame_table(self._frame(target, ground, relation), self.city.grid, bins)

    # What was meant

    def grounds(self, target: str) -> tuple[GroundPosterior, ...]:
        """Return what each ground of each relation of a target probably refers to.

        Returns
        -------
        tuple of GroundPosterior
            In the order of :meth:`relations`, one entry per ground ("between" has two), its
            candidates with their probabilities, the most probable first; None is a place that is
            not on the map.
        """
        self._check(target)
        return referents_of(self.joint, self.factors, target)

    def readings(self, which: int = -1) -> tuple[ReadingPosterior, ...]:
        """Return the ways to understand a description, with their probabilities.

        Parameters
        ----------
        which
            Position in :attr:`descriptions`, the latest by default.

        Returns
        -------
        tuple of ReadingPosterior
            Reading, its prior probability and its posterior one; one reading that is certain where
            the description has no others. Empty when nothing was said.

        Raises
        ------
        InputError
            When there is no such description.
        """
        count = len(self.descriptions)
        if not count:
            return ()
        if not -count <= which < count:
            raise InputError(
                f"Description {which} does not exist; expected 0 to {count - 1}, or -1 for the "
                "latest"
            )
        return readings_of(self.joint, self.factors, which)

    # Questions

    def checked_answers(self) -> tuple[CheckedAnswer, ...]:
        """Return each answer with the probability that it is no error, given everything.

        Of answers that contradict each other, or what was said, the less probable is doubted.
        """
        if not self.answers:
            return ()
        before = joint_posterior(self.log_prior, self.log_sensed, self.factors)
        return checked_answers(self.joint, self.answers, before)

    def value_of(self, question: Any, **options: Any) -> Any:
        """Return what a question is worth: expected bits about the cell, and expected reward.

        Parameters
        ----------
        question
            One of :func:`sloop_ppl.ask`, of this posterior or an earlier one.
        **options
            How the search goes on; see :meth:`sloop_ppl.bridge.Question.value`.

        Raises
        ------
        InputError
            When it is no question.
        """
        if not callable(getattr(question, "value", None)):
            raise InputError(
                f"The question is a {type(question).__name__}; expected one of "
                "sloop_ppl.ask(posterior, city)"
            )
        return question.value(self, **options)

    # Latents that the model or the description declares

    @property
    def latents(self) -> tuple[str, ...]:
        """Names of the latents that the model declares, for each of those there are."""
        names = []
        for which, factor in enumerate(self.factors):
            shared = [v for v in factor.data.shared if isinstance(v, Latent)]
            declared = [v for v in (*shared, *factor.data.own) if v.choice is None]
            names += [site_name(latent.name, which) for latent in declared]
        in_joint = set(self.joint.latents)  # nothing tells of one whose phrase no component reads
        return tuple(name for name in names if name in in_joint)

    def latent(self, name: str) -> xarray.DataArray:
        """Return how probable each value of a declared latent is.

        Parameters
        ----------
        name
            One of `latents`, or of what a description leaves open, such as ``ground_0``.

        Returns
        -------
        xarray.DataArray
            Dim `name`, sums to one; its coordinate ``prior`` is what was believed before.

        Raises
        ------
        UnknownName
            When there is no such latent.
        """
        return self._latent_table(name, self.joint.probabilities(self._declared(name)[1]), ())

    def joint_latent(self, name: str, target: str) -> xarray.DataArray:
        """Return p(value, cell) of a declared latent and a target, dims `name`, y, x.

        Raises
        ------
        UnknownName
            When there is no such latent or target.
        """
        self._check(target)
        table = self.joint.probabilities(self._declared(name)[1], f"{target}/cell")
        return self._latent_table(name, table.reshape(-1, *self.city.grid.shape), ("y", "x"))

    # Phrases

    def phrase_tables(self, target: str) -> tuple[Table, ...]:
        """Return what each relation says of the cells by itself, as it was meant.

        Returns
        -------
        tuple of numpy.ndarray
            One table per relation of :meth:`relations`, summing to one, shape (H, W): no other
            relation, no component but the literal one, no prior; frames summed out. The ground of a
            relation to a target is where all that is known puts it.
        """
        tables = []
        for _, factor in self._factors_about(target):
            for index in range(len(factor.about(target))):
                own = [t for t in factor.relations(target) if t.index == index]
                log_p = np.zeros(self.city.grid.size)
                for term in own:
                    log_p = log_p + PhraseTables(factor.data, term).log_phi_alone
                for pair in factor.pairs_of(target, index):
                    log_p = log_p + self._seen_from_ground(pair)
                tables.append(softmax(log_p).reshape(self.city.grid.shape))
        return tuple(tables)

    def _seen_from_ground(self, pair: PairKernel) -> Table:
        """Return the log of a relation to a target, where that is summed out, shape (S,)."""
        alone = pair_table(replace(pair, power=1.0))
        with np.errstate(divide="ignore"):
            log_p = torch.from_numpy(np.log(self.belief(pair.ground).reshape(-1)))
        name = f"{pair.ground}/cell"
        found: Table = alone.summed(LogTable((name,), log_p), name).values.numpy()
        return found

    def lapses(self, target: str) -> tuple[Lapse, ...]:
        """Return how probable it is that each relation of a target is wrong, given everything."""
        self._check(target)
        return lapses_of(self.joint, self.factors, target)

    def influence(
        self, target: str, rng: np.random.Generator | None = None
    ) -> tuple[Influence, ...]:
        """Return how many bits each relation moves the belief: inferred again without it.

        Parameters
        ----------
        target
            Id of the target.
        rng
            Wanted by engines that draw.

        Returns
        -------
        tuple of Influence
            In the order of :meth:`relations`. Prior and sensing stay; the components that apply
            are chosen anew, so that a description that is left with nothing to say in front of,
            behind, left or right has no component without frames.

        Notes
        -----
        Influences do not add up to the bits gained from the prior: relations overlap, or
        contradict each other.
        """
        relations = self.relations(target)
        belief = self.belief(target)
        if self.model.needs_truth:  # it listens to nothing that was said
            return tuple(Influence(r, i, 0.0, belief) for i, r in enumerate(relations))
        found = []
        for index, relation in enumerate(relations):
            kept = without_relation(self.descriptions, target, index)
            other = self._with_factors(kept, rng).belief(target)
            found.append(Influence(relation, index, bits_between(belief, other), other))
        return tuple(found)

    @property
    def can_speak(self) -> bool:
        """Tell whether the model has a speaker form; see `sloop_ppl.models.speaker_of`."""
        try:
            speaker_of(self.model)
        except InputError:
            return False
        return True

    def speaking(self, rng: np.random.Generator | None = None) -> Posterior:
        """Return the posterior under the model's speaker form: the same words, prior and sensing.

        Its log evidence is a probability of what was said, and ranks models.

        Parameters
        ----------
        rng
            Wanted by engines that draw.

        Raises
        ------
        InputError
            When the model cannot speak; see `sloop_ppl.models.speaker_of`.
        """
        return replace(self, model=speaker_of(self.model))._with_factors(self.descriptions, rng)

    def predictive(self, target: str) -> tuple[PhraseCheck, ...]:
        """Return how expected each phrase of a target was, given all the others.

        Parameters
        ----------
        target
            Id of the target.

        Returns
        -------
        tuple of PhraseCheck
            In the order of :meth:`relations`, under the model's speaker form; a relation to several
            grounds without a meaning of its own is checked by its first, one to a place that may be
            several by the most probable of them. Left out is what is not on the map, and what is to
            a target. The others are taken in their most probable reading.

        Raises
        ------
        InputError
            When the model cannot speak.
        """
        speaker = replace(speaker_of(self.model), sum_readings=False, sum_grounds=False)
        generative = replace(self, model=speaker, method=Exact())
        terms = {term.index: term for term in reversed(self._numbered(target))}
        found = []
        for index, relation in enumerate(self.relations(target)):
            if index not in terms or terms[index].is_silent:
                continue
            others = without_relation(self.descriptions, target, index)
            belief = generative._with_factors(others, None).belief(target).reshape(-1)
            found.append(check_phrase(relation, index, terms[index], generative.model, belief))
        return tuple(found)

    def _numbered(self, target: str) -> list[GroundedRelation]:
        """Return the grounded relations of a target, numbered as in :meth:`relations`."""
        found, before = [], 0
        for _, factor in self._factors_about(target):
            main = (term for term in factor.relations(target) if term.is_main)
            found += [replace(t, index=t.index + before) for t in main]
            before += len(factor.about(target))
        return found

    # Draws

    def draws(self, target: str, n: int, *, rng: np.random.Generator) -> xarray.Dataset:
        """Draw cells, components and fronts together.

        Parameters
        ----------
        target
            Id of the target.
        n
            How many, > 0.
        rng
            Where they are drawn from.

        Returns
        -------
        xarray.Dataset
            See :func:`sloop_ppl.inference._draws.draws_from`.
        """
        self._check(target)
        uniforms = uniforms_for(self.factors, target, n, rng)
        return draws_from(self.joint, self.factors, self.city.grid, target, uniforms)

    def to_arviz(self, n: int = 1000, *, rng: np.random.Generator | None = None) -> Any:
        """Return n draws of every target as an ArviZ InferenceData (needs ``sloop-ppl[arviz]``).

        Parameters
        ----------
        n
            Draws of each target in each of four chains, > 0.
        rng
            Where they are drawn from; None for draws that lie evenly, the same every time.

        Returns
        -------
        arviz.InferenceData
            Groups ``posterior``, ``prior`` and ``constant_data``, see
            :func:`sloop_ppl.inference._draws.to_arviz`; of a model that can speak also
            ``posterior_predictive``, ``observed_data`` and ``log_likelihood``, whose variable
            ``word`` is the word of each asserted phrase: the draws of it, the one that was said,
            and the log probability of that at each draw.
        """
        names = [part.name for part in self.model.components]
        draws = {
            target: draws_from(
                self.joint,
                self.factors,
                self.city.grid,
                target,
                uniforms_for(self.factors, target, CHAINS * n, rng),
            )
            for target in self.targets
        }
        attrs = {
            "inference_library": "sloop_ppl",
            "model": self.model.name,
            "map": self.city.name,
            "components": names,
        }
        constants = self.dataset[["belief", "log_prior"]]
        return to_arviz(
            draws,
            names,
            constants,
            attrs,
            self._prior_draws(CHAINS * n, rng),
            self._phrase_words(draws, rng),
        )

    def _prior_draws(
        self, n: int, rng: np.random.Generator | None
    ) -> dict[str, tuple[NDArray[np.intp], Mapping[str, float]]]:
        """Return, by target, numbers of drawn cells, and the components' prior weights."""
        found: dict[str, tuple[NDArray[np.intp], Mapping[str, float]]] = {}
        for target in self.targets:
            uniforms = uniforms_for((), target, n, rng)[:, 0]
            cells = inverse(softmax(self.log_prior[target]), uniforms)
            found[target] = cells, self.component_prior(target)
        return found

    def _phrase_words(
        self, draws: Mapping[str, xarray.Dataset], rng: np.random.Generator | None
    ) -> list[PhraseWord]:
        """Return each asserted phrase with the probability of every word at the drawn cells."""
        if not self.can_speak:
            return []
        model = replace(speaker_of(self.model), sum_readings=False, sum_grounds=False)
        found: list[PhraseWord] = []
        for target, table in draws.items():
            cells = table["row"].values * self.city.grid.n_cols + table["col"].values
            seen: set[int] = set()
            for term in self._numbered(target):
                if term.is_silent or term.negated or term.index in seen:
                    continue
                seen.add(term.index)
                words, p = word_table(term, model)
                options, chosen = word_options(term)
                label = f"{target} {term.relation} {', '.join(term.grounds)}"
                uniforms = uniforms_for((), target, len(cells), rng)[:, 0]
                # Not in step with the cells, which the same lattice has drawn.
                turned = np.roll(uniforms[::-1], len(uniforms) // 3 + len(found))
                found.append(
                    PhraseWord(label, words, options[chosen].relation, p[:, cells], turned)
                )
        return found

    def utterances(
        self, target: str, n: int, *, rng: np.random.Generator, **options: Any
    ) -> tuple[Simulated, ...]:
        """Draw what would be said of a target, as far as is known where it is.

        Parameters
        ----------
        target
            Id of the target.
        n
            How many descriptions, > 0.
        rng
            Where they are drawn from.
        **options
            ``speaker``, ``phrases``, ``grounds``; see
            :func:`sloop_ppl.inference._utterances.utterances_about`.
        """
        known = {t.id: t for d in self.descriptions for t in d.targets}
        who = known.get(target, target)
        options.setdefault("speaker", speaker_of(self.model))
        return utterances_about(who, self.belief(target), self.city, n, rng=rng, **options)

    def noted(self, info: InferenceInfo) -> Posterior:
        """Return the same posterior, what it has computed included, with how it was found."""
        same = copy.copy(self)
        object.__setattr__(same, "info", info)
        return same

    # More evidence

    def update(
        self, description: Description | AnswerFactor, rng: np.random.Generator | None = None
    ) -> Posterior:
        """Return the posterior after one more description; the order of updates is irrelevant.

        Parameters
        ----------
        description
            What is said now, or an answer to a question: ``question.answer("...")``. Targets not
            known so far start from a uniform prior over the
            area. Of a speaker who
            has spoken before (`Description.speaker`) it makes what was said one longer
            description; any other speaker is independent of those before.
        rng
            Wanted by engines that draw.

        Raises
        ------
        NoRelationFound
            When the description speaks of no target.
        InputError
            When it answers a question that was not asked.
        BeliefCollapse
            When it excludes all that was believed.
        """
        if isinstance(description, AnswerFactor):
            check_answer(description, self.joint, self.texts)
            after = replace(self, answers=(*self.answers, description))
            check_possible(after, description, self)
            own = description.description
            return after if own is None else after.update(own, rng)
        if not isinstance(description, Description):
            raise InputError(
                f"What is said is a {type(description).__name__}; expected a description: "
                "parse(text, city)"
            )
        if not description.targets:
            raise NoRelationFound(
                f"'{description.text}' says nothing of any target; expected at least one relation"
            )
        targets = tuple(target.id for target in description.targets)
        uniform = log_priors(None, targets, self.city, self.area)
        nothing = dict.fromkeys(targets, np.zeros(self.city.grid.size))
        before = {**self.log_prior, **{t: uniform[t] for t in targets if t not in self.targets}}
        known = next((f for f in self.factors if f.is_by(description.speaker)), None)
        texts = (*known.descriptions, description) if known else (description,)
        weighed = weigh(
            texts, self.city, self.model, self.method, before, truth=self._truth, rng=rng
        )
        factors = tuple(weighed if factor is known else factor for factor in self.factors)
        shifts = {
            target: (len(self._before(target, known)), len(description.about(target)))
            for target in targets
            if known is not None
        }
        after = replace(
            self,
            log_prior=before,
            answers=renumbered(self.answers, shifts),
            factors=factors if known else (*factors, weighed),
            log_sensed={**nothing, **self.log_sensed},
        )
        return check_possible(after, description, self)

    def condition(self, log_likelihood: Mapping[str, Table]) -> Posterior:
        """Return the posterior after sensing; components and frames move with the cells.

        Parameters
        ----------
        log_likelihood
            Target -> log likelihood of what was sensed at each cell, at most 0 up to a constant,
            -inf where impossible, shape (H, W); a table of xarray is read by its coordinates.

        Raises
        ------
        BeliefCollapse
            When nothing that was believed possible remains.
        InputError
            When a table has the wrong shape or holds NaN or +inf.
        """
        sensed = dict(self.log_sensed)
        for target, table in log_likelihood.items():
            self._check(target)
            found = in_order(table, f"Log likelihood of '{target}'", self.city.grid)
            flat = np.asarray(found, dtype=np.float64, order="C")
            if flat.shape != self.city.grid.shape:
                raise InputError(
                    f"Log likelihood of '{target}' has shape {flat.shape}; expected "
                    f"{self.city.grid.shape}"
                )
            if np.isnan(flat).any() or np.isposinf(flat).any():
                raise InputError(f"Log likelihood of '{target}' holds NaN or +inf")
            sensed[target] = sensed[target] + flat.reshape(-1)
        return check_possible(replace(self, log_sensed=sensed), log_likelihood, self)

    # Files

    def to_geojson(self, target: str | None = None, least: float = 0.0) -> dict[str, Any]:
        """Return the cells of a target, or of all, as GeoJSON squares with their probability.

        Parameters
        ----------
        target
            Id of the target; None for all.
        least
            Cells of a lower probability are left out, in [0, 1).

        Raises
        ------
        InputError
            When the map has no centre on earth.
        """
        return cells_geojson(self, self.targets if target is None else (target,), least)

    @property
    def dataset(self) -> xarray.Dataset:
        """The posterior as an xarray Dataset: belief(target, y, x) and what it is made of."""
        beliefs = {target: self.belief(target) for target in self.targets}
        return to_dataset(self._parts, beliefs, self.log_evidence)

    def save(self, path: str | Path) -> None:
        """Write the posterior, its map and its descriptions to a netCDF file.

        Raises
        ------
        OutputError
            When the path does not end in ``.nc`` or cannot be written.
        """
        beliefs = {target: self.belief(target) for target in self.targets}
        save_parts(self._parts, beliefs, self.log_evidence, path)

    @staticmethod
    def load(path: str | Path) -> Posterior:
        """Read a posterior that :meth:`save` wrote.

        Raises
        ------
        InputError
            When the file is not a saved posterior, or one of an older version.
        """
        parts = load_parts(path)
        return Posterior(
            city=parts.city,
            model=parts.model,
            method=parts.method,
            log_prior=parts.log_prior,
            factors=parts.factors,
            log_sensed=parts.log_sensed,
            area=parts.area,
            answers=parts.answers,
        )

    @property
    def _parts(self) -> StoredPosterior:
        return StoredPosterior(
            self.city,
            self.model,
            self.method,
            self.log_prior,
            self.factors,
            self.log_sensed,
            self.area,
            self.answers,
        )

    @property
    def _truth(self) -> dict[str, tuple[float, float]]:
        """Where targets are, of a model that was told."""
        truths: dict[str, tuple[float, float]] = {}
        for factor in self.factors:
            truths |= dict(zip(factor.data.targets, factor.data.truths or (), strict=False))
        return truths

    def _declared(self, name: str) -> tuple[Latent, str]:
        """Return a declared latent and its name in the joint posterior."""
        for which, factor in enumerate(self.factors):
            for latent in (*factor.data.shared, *factor.data.own):
                if not isinstance(latent, Latent) or name not in self.joint.latents:
                    continue
                if site_name(latent.name, which) == name:
                    return latent, name
        raise UnknownName("latent of the model", name, self.latents)

    def _latent_table(self, name: str, values: Table, dims: tuple[str, ...]) -> xarray.DataArray:
        import xarray

        latent, _ = self._declared(name)
        grid = self.city.grid
        coords: dict[str, Any] = {name: [str(value) for value in latent.support]}
        coords["prior"] = (name, np.array(latent.prior))
        coords |= {dim: {"y": grid.y_m, "x": grid.x_m}[dim] for dim in dims}
        return xarray.DataArray(values, dims=(name, *dims), coords=coords, name="p")

    def _before(self, target: str, last: DescriptionFactor) -> list[SpatialRelation]:
        """Return the relations of a target up to those of one description, these included."""
        found: list[SpatialRelation] = []
        for factor in self.factors:
            found += factor.about(target) if target in factor.log_factors else ()
            if factor is last:
                break
        return found

    def _check(self, target: str) -> None:
        if target not in self.log_prior:
            raise UnknownName("target", target, self.targets)

    def _factors_about(self, target: str) -> list[tuple[int, DescriptionFactor]]:
        """Return the descriptions that say something of a target, with their positions."""
        self._check(target)
        return [(i, f) for i, f in enumerate(self.factors) if target in f.log_factors]

    def _component(self, target: str, which: int) -> tuple[str, DescriptionFactor]:
        """Return the component's name in the joint posterior, and the description it is of."""
        informative = self._factors_about(target)
        if not informative:
            raise InputError(
                f"Nothing was said of '{target}', so it has no mixture; its belief is its prior"
            )
        if not -len(informative) <= which < len(informative):
            raise InputError(
                f"Description {which} of '{target}' does not exist; expected 0 to "
                f"{len(informative) - 1}, or -1 for the latest"
            )
        position, factor = informative[which]
        return site_name(f"{target}/component", position), factor

    def _frame(self, target: str, ground: str | None, relation: int | None) -> FramePosterior:
        framed = find_framed(self.framed(target), target, self.model.name, ground, relation)
        return FramePosterior(self.joint, self.factors[framed.which], target, framed)

    def _with_factors(
        self, descriptions: Sequence[Description], rng: np.random.Generator | None
    ) -> Posterior:
        """Return the posterior had other descriptions come; prior and sensing stay."""
        factors = tuple(
            weigh(
                texts,
                self.city,
                self.model,
                self.method,
                self.log_prior,
                truth=self._truth,
                rng=rng,
            )
            for texts in by_speaker(descriptions)
        )
        # An answer about what is not said any more says nothing of what is.
        supports = joint_posterior(self.log_prior, self.log_sensed, factors)
        kept = [a for a in self.answers if set(a.latents) <= set(supports.latents)]
        return replace(self, factors=factors, answers=tuple(kept))

    def _over_cells(self, values: Table, factor: DescriptionFactor, name: str) -> xarray.DataArray:
        import xarray

        grid = self.city.grid
        return xarray.DataArray(
            values.reshape(-1, *grid.shape),
            dims=("component", "y", "x"),
            coords={"component": list(factor.components), "y": grid.y_m, "x": grid.x_m},
            name=name,
        )


def check_possible(
    posterior: Posterior, observation: object, before: Posterior | None = None
) -> Posterior:
    """Return a posterior unless some target has nowhere left to be.

    Parameters
    ----------
    posterior
        What is believed now.
    observation
        What was said or sensed last.
    before
        What was believed before that; None when nothing was known but the prior.

    Raises
    ------
    BeliefCollapse
        When no cell of a target is possible; it names what excludes them.
    """
    first, *_ = posterior.targets
    # All factors multiply, so whatever is impossible of one target leaves no weight to another.
    if np.isfinite(posterior.joint.log_weights(f"{first}/cell")).any():
        return posterior
    stuck = [target for target in posterior.targets if not _is_possible(posterior, target)]
    target = (stuck or [first])[0]
    culprits = _culprits(posterior, target)
    raise BeliefCollapse(
        f"Nothing that was believed about '{target}' is possible after this observation: "
        f"{'; '.join(culprits)}, with no cell in common; check it, or start from a prior "
        "without zeros",
        prior=posterior.log_prior[target] if before is None else before.belief(target),
        observation=observation,
        culprits=culprits,
    )


def _is_possible(posterior: Posterior, target: str) -> bool:
    """Tell whether a target has a cell that nothing about itself excludes."""
    left = posterior.log_prior[target] + posterior.log_sensed[target]
    for table in _answered(posterior, target).values():
        left = left + table
    for factor in posterior.factors:
        if target in factor.log_factors:
            table = factor.log_factors[target]
            left = left + table.reshape(-1, table.shape[-1]).max(0)
    return bool(np.isfinite(left).any())


def _culprits(posterior: Posterior, target: str) -> tuple[str, ...]:
    """Return what excludes cells of a target, with the number each leaves."""
    weighed: list[tuple[str, Table]] = [
        ("its prior", posterior.log_prior[target]),
        ("what was sensed", posterior.log_sensed[target]),
        *_answered(posterior, target).items(),
    ]
    for factor in posterior.factors:
        if target in factor.log_factors:
            terms = factor.relations(target)
            phrases = [f"{term.relation} {' and '.join(term.grounds)}" for term in terms]
            table = factor.log_factors[target]
            weighed.append((f"'{', '.join(phrases)}'", table.reshape(-1, table.shape[-1]).max(0)))
    left = [(name, int(np.isfinite(table).sum()), table.size) for name, table in weighed]
    return tuple(f"{name} leaves {n} of {size} cells" for name, n, size in left if n < size)


def _answered(posterior: Posterior, target: str) -> dict[str, Table]:
    """Return each answer about a target's cell with its log likelihood, shape (S,)."""
    return {
        f"the answer '{answer.answer}' to “{answer.question}”": answer.table().values.numpy()
        for answer in posterior.answers
        if answer.latents == (f"{target}/cell",)
    }
