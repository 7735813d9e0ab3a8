"""The generative model of a description: one Pyro program, run by every engine.

Shape legend: S cells; K components; V values of each latent that phrases share; U values of each
latent of one phrase alone; B fronts of a ground. Tables are laid out (K, V..., U..., B, S), with
an axis of length one for what does not matter.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple, TypeAlias, TypeVar, get_args

import numpy as np
import pyro
import pyro.distributions as dist
import torch
from numpy.typing import NDArray
from torch import Tensor

from sloop_ppl.errors import InputError, ProgramError, SloopError, UnknownName
from sloop_ppl.language import Description
from sloop_ppl.maps import CityMap
from sloop_ppl.models._distributions import FrameDensity, LogBernoulli, categorical
from sloop_ppl.models._logspace import LEAST_LOG, log1mexp, log_blur, look_up
from sloop_ppl.models._program_data import ProgramData
from sloop_ppl.models._speaker import WordWeights, frame_angle_masses
from sloop_ppl.models._vocabulary import speaker_words
from sloop_ppl.models.components import COMBINATIONS, cut_below_uniform
from sloop_ppl.models.frames import FrameDistribution
from sloop_ppl.models.grounded_relation import GroundedRelation, word_options
from sloop_ppl.models.grounding import (
    ground_description,
    ground_target_relations,
    program_data,
    true_places,
)
from sloop_ppl.models.likelihoods import (
    ClosedFormMarginal,
    RelationLikelihood,
    marginal_over,
    parameters_of,
    with_values,
)
from sloop_ppl.models.pair_kernel import PairKernel
from sloop_ppl.models.phrase import Phrase
from sloop_ppl.models.presets import ObservationModel, preset

__all__ = ["Frames", "Program", "build", "generative_model"]

Frames = Literal["bins", "density", "summed"]
"""How frames are drawn: Categorical over angle bins, from their density, or summed out."""

PairSite: TypeAlias = tuple[str, str, Tensor]
"""Ids of a figure and of the target that is its ground, and the log factor of their cells."""

T = TypeVar("T")

_DEEP = 60.0
"""Nats below its peak at which a phrase ends in a model that cuts below uniform: the factor ``cut``
counts from there, or Pyro's contraction would multiply 1e-600 by 1e600."""

_ONE = torch.ones(())
_MOST_DIMS = 24
"""Sites that get a dim each: well below the 64 that torch has for them and for tables together."""


def generative_model(
    data: ProgramData, frames: Frames, bins: int, pairs: Mapping[str, PairSite] | None = None
) -> dict[str, Tensor]:
    """Draw where targets are and how each phrase was meant; observe that the description holds.

    First what phrases share: reading h ~ Cat(pi), branch of each "or", referent gamma_m of each
    mention ~ Cat(candidates and none), frames, and latents of the model. For each target: component
    z ~ Cat(w) and cell s ~ Cat(prior). For each phrase j that z reads: referents of its own, frame
    psi_j ~ (1 - eps) sum_m pi_m VonMises(mu_m, kappa_m) + eps Uniform given its referent, lapse
    l_j ~ Bernoulli(lambda), and holds_j ~ Bernoulli(phi_j) observed 1, where phi_j is
    g(s | r_j, gamma_j, psi_j) / sum_s E_psi[g], or 1 / S in a lapse, of a referent on no map and
    of a phrase that is not in h. Per component of n phrases a composite likelihood,
    (prod_j E[phi_j])^(n^-t), divided by its sum over the map; then the cut and the shared error.
    Last, the phrases between targets, each a factor of their two cells.
    """
    model, cells = data.model, {}
    numbers = {name: draw_number(name, prior) for name, prior in data.number_priors.items()}
    likelihood = with_values(model.likelihood, numbers)
    shared = [pyro.sample(v.name, categorical(v.log_prior)) for v in data.shared]
    for i, target in plate(data, frames, "targets", data.targets):
        log_weight = at_latents(data.log_weight_given[i], shared)
        component = pyro.sample(f"{target}/component", categorical(log_weight))
        cells[target] = cell = pyro.sample(f"{target}/cell", categorical(data.log_prior[i]))
        log_phi = []
        for j, relation in plate(data, frames, f"{target}/phrases", data.relations[i]):
            summed = summed_phrase(data, likelihood, relation)
            phrase, log_expected_phi = summed.phrase, summed.log_phi
            log_phi.append(log_expected_phi)
            if frames == "summed" or not data.reads[i][j].any():  # all that is left is shared
                log_holds = look_up(log_expected_phi, (*shared, cell))
            else:
                own = [pyro.sample(u.name, categorical(u.log_prior)) for u in phrase.own]
                name = f"{target}/frame_{j}"
                angles, which = draw_frame_angle(name, phrase, [*shared, *own], frames, bins)
                log_p = log_phrase(data, likelihood, summed, angles)
                log_holds = look_up(phrase.on_shared_axis(log_p), (*shared, *own, which, cell))
                if lapse := model.lapse_of(relation):
                    lapses = pyro.sample(f"{target}/lapse_{j}", dist.Bernoulli(double(lapse)))
                    log_holds = torch.where(lapses > 0, data.log_uninformative, log_holds)
            if data.cuts.any():  # what is cut to one level anyway must not underflow
                log_holds = log_holds.clamp_min(log_expected_phi.max() - _DEEP)
            if not data.reads[i][j].all():
                log_holds = torch.where(look_up(data.reads[i][j], (component,)), log_holds, 0.0)
            pyro.sample(f"{target}/holds_{j}", LogBernoulli(log_holds), obs=_ONE)
        if not data.is_located(i):
            continue
        # log l = sum_j log E[phi_j] of each component; `together`: what is no product of these.
        log_l, together, observed = component_tables(data, likelihood, i, log_phi)
        at = (component, *shared, cell)
        if together is not None:
            pyro.sample(f"{target}/together", LogBernoulli(look_up(together, at)), obs=_ONE)
        log_p = log_l
        if model.temper:
            log_p = log_l * data.n_phrases[i] ** -double(model.temper)
            pyro.factor(f"{target}/temper", look_up(log_p - log_l, at))
        if model.normalisation == "map":  # each component a distribution over a uniform map
            log_z = log_normaliser(data, i, log_p)
            pyro.factor(f"{target}/normaliser", -look_up(log_z, at))
            log_p = log_p - log_z
        if data.cuts.any():
            log_cut = torch.where(data.cuts, cut_below_uniform(log_p), log_p)
            pyro.factor(f"{target}/cut", look_up(log_cut - log_p + (log_l - observed), at))
            log_p = log_cut
        if model.error_m:
            log_moved = log_blur(log_p, data.city.grid, model.error_m)
            pyro.factor(f"{target}/shared_error", look_up(log_moved - log_p, at))
    for name, (figure, ground, log_pair) in (pairs or {}).items():
        log_holds = look_up(log_pair, (*shared, cells[ground], cells[figure]))
        pyro.sample(name, LogBernoulli(log_holds), obs=_ONE)
    return cells


def log_phrase(
    data: ProgramData, likelihood: RelationLikelihood, summed: SummedPhrase, angles: Sequence[Any]
) -> Tensor:
    """Return log phi of a phrase for each front, had it not lapsed, shape (V..., U..., B, S).

    Parameters
    ----------
    data, likelihood
        What the program is run on, and how true a relation is of each cell.
    summed
        The phrase, and what it is divided by.
    angles
        The fronts of each of its meanings, radians.
    """
    phrase, model = summed.phrase, data.model
    if phrase.is_of_each_denied:  # without fronts of its own
        return summed.log_meant[..., None, :]
    log_g = phrase.over_meanings(
        lambda meaning, angle: likelihood.log_g(meaning, meaning.directions(angle)), angles
    )
    if model.normalisation == "speaker":  # P(word) among what could have been said
        log_g = log_g - phrase.over_meanings(
            lambda meaning, angle: log_vocabulary(likelihood, meaning, angle), angles
        )
    log_p = log_held(log_g, phrase.relation, model, summed.log_peak) - summed.log_z[..., None, :]
    return phrase.unless_silent(log_p, data.log_uninformative, after=2)


def at_latents(table: Tensor, latents: Sequence[Tensor]) -> Tensor:
    """Return the rows of a table (V..., K) at values of latents; of one without their axes all."""
    if table.dim() == 1:
        return table
    nothing = torch.tensor(0)
    chosen = [nothing if n == 1 else v for v, n in zip(latents, table.shape, strict=False)]
    return table[tuple(torch.broadcast_tensors(*chosen))]


def that_matters(table: Tensor) -> Tensor:
    """Return a table (V..., B) without the axes of latents that it is the same under all values of.

    Another latent's axis would make the frame depend on it.
    """
    for axis in range(table.dim() - 1):
        first = table.narrow(axis, 0, 1)
        if table.shape[axis] > 1 and torch.equal(table, first.expand_as(table)):
            table = first
    return table


def plate(
    data: ProgramData, frames: Frames, name: str, items: Sequence[T]
) -> Iterable[tuple[int, T]]:
    """Enumerate items whose sites do not depend on each other: a plate that is a loop.

    Enumeration takes a dim of every tensor for each site, of which torch has 64; where sites are
    many, those of one item lie along the dims of another's (`pyro.markov`). `poutine.do` of an
    enumerated program works in plates only.
    """
    if _count_sites(data) > _MOST_DIMS:
        indices: Iterable[int] = pyro.markov(range(len(items)), history=0)
        return ((i, items[i]) for i in indices)
    if frames != "bins" or not items:  # Pyro's automatic guides take no plates that are loops
        return enumerate(items)
    return ((int(i), items[int(i)]) for i in pyro.plate(name, len(items)))


def _count_sites(data: ProgramData) -> int:
    sites = 2 * len(data.targets) + 2 * sum(map(len, data.relations)) + len(data.shared)
    return sites + len(data.own)


def draw_number(name: str, prior: Any) -> Tensor:
    """Draw a number of the likelihood at a site of its name.

    Raises
    ------
    InputError
        When several are drawn at once, as in a plate: the likelihood's tables take one.
    """
    drawn: Tensor = pyro.sample(name, prior)
    if drawn.numel() > 1:
        raise InputError(
            f"Number '{name}' of the likelihood is drawn {drawn.numel()} times at once; expected "
            "one draw a run, such as Predictive(parallel=False)"
        )
    return drawn.reshape(())


class FrameAngles(NamedTuple):
    """The fronts of a phrase's ground, one row for each of its meanings, and which was drawn."""

    angles: Sequence[Any]
    which: Tensor


def draw_frame_angle(
    name: str, phrase: Phrase, latents: list[Tensor], frames: Frames, bins: int
) -> FrameAngles:
    """Draw the front that a phrase depends on at a site of this name, if it depends on one.

    Parameters
    ----------
    name
        Name of the site, ``T/frame_j``; in bins the angle itself is the deterministic site
        ``T/angle_j``.
    latents
        Values of the latents that its tables have axes for.
    frames
        From bins or from the density. In bins the frame is Categorical given the latents; a
        density has one site for each ground that may be meant, ``T/frame_j/m`` for the others.

    Raises
    ------
    InputError
        When the frame is a point under some values of another latent.
    """
    nothing = torch.tensor(0)
    if phrase.frames is None:
        return FrameAngles([None] * len(phrase.meanings), nothing)
    if phrase.shared_angles is not None:
        return FrameAngles([phrase.shared_angles] * len(phrase.meanings), nothing)
    spread = [frame for frame in phrase.frames if frame is not None and not frame.is_point]
    if frames == "bins" or not spread:
        angles, log_mass = phrase.bins(bins)
        index = pyro.sample(name, categorical(at_latents(that_matters(log_mass), latents)))
        angle = look_up(that_matters(angles), (*latents, index))
        pyro.deterministic(name.replace("/frame_", "/angle_"), angle)
        return FrameAngles(list(angles.reshape(len(phrase.meanings), -1)), index)
    own = phrase.own_frames(name)
    if len(spread) < len([frame for frame in phrase.frames if frame is not None]):
        raise InputError(
            f"The frame of '{phrase.relation.relation} {phrase.relation.ground}' is a point under "
            "some values of another latent, so it has no density; use frames='bins'"
        )
    # One angle for each ground that may be meant: those of the others are drawn from their priors.
    drawn = {frame: pyro.sample(site, FrameDensity(frame)) for site, frame in own.items()}
    first, *_ = drawn.values()
    each = [first if frame is None else drawn[frame] for frame in phrase.frames]
    index = torch.arange(first.numel()).reshape(first.shape)
    return FrameAngles([angle.reshape(-1) for angle in each], index)


class SummedPhrase(NamedTuple):
    """A phrase with its own latents summed out.

    Parameters
    ----------
    phrase
        The phrase.
    log_peak
        Log of the greatest g over the map and all fronts, shape (V..., U..., 1, 1); of a denied
        phrase only, else 0.
    log_z
        Log of the sum over the map of E_psi[g], shape (V..., U..., 1); 0 where it is not divided.
    log_phi
        Log of E[phi] over frame, lapse and own latents, shape (V..., S).
    log_meant
        Log of E[phi] over the frame alone, had it not lapsed, shape (V..., U..., S).
    """

    phrase: Phrase
    log_peak: Tensor
    log_z: Tensor
    log_phi: Tensor
    log_meant: Tensor


def summed_phrase(
    data: ProgramData, likelihood: RelationLikelihood, relation: GroundedRelation
) -> SummedPhrase:
    """Return a phrase with frame, lapse and the latents of its own summed out; made once.

    Notes
    -----
    This is the exact engine's one optimisation: E_psi[g] is the likelihood's closed form,
    ``log_marginal``, where it has one, else a sum over 1440 directions.
    """
    model, phrase = data.model, data.phrase(relation)
    key = phrase.key(by_itself=not data.shares_tables)
    if key in data.tables:
        kept: SummedPhrase = data.tables[key]
        return kept._replace(phrase=phrase)
    if phrase.is_of_each_denied:
        log_g = phrase.over_meanings(lambda one, _: log_none_holds(data, likelihood, one))[
            ..., 0, :
        ]
        log_peak = log_g.new_zeros(1)
    else:
        log_g = phrase.over_meanings(
            lambda meaning, frame: log_expected(data, likelihood, meaning, frame), phrase.frames
        )
        log_peak = log_g.new_zeros(1)
        if relation.negated:
            log_peak = phrase.over_meanings(lambda one, _: log_greatest(data, likelihood, one))
        log_g = log_held(log_g, relation, model, log_peak)[..., 0, :]
    log_z = log_g.new_zeros(1)
    if model.normalisation == "map":
        log_z = torch.logsumexp(data.counted(log_g), -1, keepdim=True)
    log_p = log_meant = phrase.unless_silent(log_g - log_z, data.log_uninformative)
    angles = phrase.shared_angles
    if angles is not None:
        kept = SummedPhrase(phrase, log_peak, log_z, log_p, log_meant)
        given = log_phrase(data, likelihood, kept, [angles] * len(phrase.meanings))
        log_p = phrase.on_shared_axis(given)[..., 0, :]
    for latent in reversed(phrase.own):  # their axes are the last before the cells
        log_p = torch.logsumexp(log_p + latent.log_prior[:, None], -2)
    log_phi = with_lapse(log_p, model.lapse_of(relation), data.log_uninformative)
    found = SummedPhrase(phrase, log_peak, log_z, log_phi, log_meant)
    if not data.number_priors:
        data.tables[key] = found
    return found


def log_expected(
    data: ProgramData,
    likelihood: RelationLikelihood,
    meaning: GroundedRelation,
    frame: FrameDistribution | None,
) -> Tensor:
    """Return log E_psi[g], or of the word's probability, over the frame's prior, shape (1, S)."""
    if frame is None:
        return likelihood.log_g(meaning, meaning.directions(None)).reshape(1, -1)
    if data.model.normalisation == "speaker":
        angles, log_mass = frame_angle_masses(frame, _SPEAKER_BINS)
        log_p = likelihood.log_g(meaning, meaning.directions(angles))
        log_p = log_p - log_vocabulary(likelihood, meaning, angles)
        return torch.logsumexp(log_p + log_mass, 0, keepdim=True)
    if isinstance(likelihood, ClosedFormMarginal):
        return likelihood.log_marginal(meaning, frame)[None]
    log_mean: Tensor = marginal_over(
        frame, meaning.offset_rad, lambda directions: likelihood.log_g(meaning, directions)
    )
    return log_mean[None]


_SPEAKER_BINS = 360
"""Fronts of a speaker: a sum over a vocabulary has no closed form, so each front takes the tables
of all words, four times as many for 1440. A kink is
off by 1e-4 in log E[g], a smooth g by nothing."""


def component_tables(
    data: ProgramData, likelihood: RelationLikelihood, i: int, log_phi: list[Tensor]
) -> tuple[Tensor, Tensor | None, Tensor]:
    """Return the log likelihood of each component before tempering, and what makes it up.

    Parameters
    ----------
    log_phi
        Each phrase with its own latents summed out, shape (V..., S).

    Returns
    -------
    tuple of Tensor
        Shape (K, V..., S): all of it; the part of components that are no plain product of phrases
        (the paper's sums over landmarks; keyword; informed), None when there is none; and all of it
        as the sites ``holds`` have it: phrases of a model that cuts end `_DEEP` below their peak.
    """

    def phrase(relation: GroundedRelation) -> Tensor:
        return summed_phrase(data, likelihood, relation).log_phi

    nothing = torch.zeros((1,) * (len(data.shared) + 1), dtype=torch.float64)
    cuts = bool(data.cuts.any())
    products, clipped, others = [], [], []
    for k, part in enumerate(data.model.components):
        read = part.terms_it_reads(data.relations[i])
        product = shallow = other = nothing
        if data.truths is not None:
            other = log_informed(data, i)
        elif part.is_literal:
            for j, table in enumerate(log_phi):
                if bool(data.reads[i][j][k]):
                    product = product + table
                    if cuts:
                        shallow = shallow + table.clamp_min(table.max() - _DEEP)
        elif read:
            other = COMBINATIONS[part.combine](read, phrase).sum(0)
        products.append(product)
        clipped += [shallow] if cuts else []
        others.append(other.reshape((1,) * (nothing.dim() - other.dim()) + other.shape))
    tables = torch.broadcast_tensors(*products, *clipped, *others)
    count = len(products)
    log_l = torch.stack(tables[:count])
    observed = torch.stack(tables[count : 2 * count]) if cuts else log_l
    if all(other is nothing or other.numel() == 1 for other in others):
        return log_l, None, observed
    together = torch.stack(tables[-count:])
    return log_l + together, together, observed + together


def log_normaliser(data: ProgramData, i: int, log_p: Tensor) -> Tensor:
    """Return what each component's table is divided by, shape (K, 1...) or (K, V..., 1).

    Parameters
    ----------
    data
        The program's data.
    i
        Position of the target.
    log_p
        The components' tables, tempered, shape (K, V..., S).

    Notes
    -----
    The sum over shared latents and a uniform map, so that each component is a distribution. With
    several readings it is that of each reading h, so that h alone gives the belief it would give
    by itself, times the reading's evidence E_h = sum_k w_k Z_hk / Z_0k relative to its mean over
    readings, where Z_0k is the sum were all phrases silent: a reading is never divided by its own
    sum, which would return the prior over readings.
    """
    log_p = data.counted(log_p)
    axes = [1 + axis for axis in data.readings]
    if not axes:
        log_z = torch.logsumexp((log_p + data.log_shared).flatten(1), 1)
        return log_z.reshape(-1, *(1,) * (log_p.dim() - 1))
    log_pi = data.log_prior_of(data.readings)
    rest = [axis for axis in range(1, log_p.dim()) if axis not in axes]
    log_z = torch.logsumexp(log_p + (data.log_shared - log_pi), rest, keepdim=True)
    log_w = data.log_weight_given[i]
    log_w = log_w.reshape(
        *(log_w.shape[:-1] if log_w.dim() > 1 else (1,) * len(data.shared)), 1, -1
    )
    log_e = torch.logsumexp(log_w.movedim(-1, 0) + log_z - log_silent(data, i), 0, keepdim=True)
    log_e = log_e - torch.logsumexp((log_e + log_pi).flatten(), 0)
    return log_z - log_e


def log_silent(data: ProgramData, i: int) -> Tensor:
    """Return the log level of each component had no phrase said anything, shape (K, 1..., 1)."""
    model = data.model
    table = torch.full((data.n_cells,), data.log_uninformative, dtype=torch.float64)
    levels = []
    for k, part in enumerate(model.components):
        read = part.terms_it_reads(data.relations[i])
        level = 0.0
        if part.is_literal:
            level = data.log_uninformative * sum(int(reads[k]) for reads in data.reads[i])
        elif read:
            level = float(COMBINATIONS[part.combine](read, lambda _: table).sum(0).mean())
        levels.append(level)
    shape = (-1, *(1,) * (len(data.shared) + 1))
    log_level = torch.tensor(levels, dtype=torch.float64).reshape(shape)
    if model.temper:
        log_level = log_level * data.n_phrases[i] ** -double(model.temper)
    return log_level


def log_informed(data: ProgramData, i: int) -> Tensor:
    """Return the log of a Gaussian around the true place, for a model that is told it, (S,)."""
    grid, (x, y) = data.city.grid, (data.truths or ())[i]
    grid.cell_at(x, y)  # raises for a place outside the map
    squared = (grid.x_m[None, :] - x) ** 2 + (grid.y_m[:, None] - y) ** 2
    sigma_m = data.model.informed_sigma_m or 0.0
    return torch.from_numpy(-squared.reshape(-1) / (2 * sigma_m**2))


def word_weights(
    likelihood: RelationLikelihood,
    options: Sequence[GroundedRelation],
    frame_angles_rad: Tensor | NDArray[np.float64],
) -> WordWeights:
    """Return how true each of some words is for each front, at every cell of the relations.

    Parameters
    ----------
    options
        What could have been said; see `sloop_ppl.models.grounded_relation.word_options`.
    frame_angles_rad
        Directions the ground may face, radians, shape (B,).

    Notes
    -----
    P(word | front, cell) is the softmax of log g over words: a speaker prefers what is truest.
    """
    angles = torch.as_tensor(frame_angles_rad)
    tables = [likelihood.log_g(option, option.directions(angles)) for option in options]
    needs = [option.needs_frame for option in options]
    plain = [t.reshape(-1, t.shape[-1])[0] for t, n in zip(tables, needs, strict=True) if not n]
    framed = [t for t, n in zip(tables, needs, strict=True) if n]
    return WordWeights.of(needs, plain, framed, len(angles))


def log_words(
    options: Sequence[GroundedRelation],
    model: ObservationModel,
    words: NDArray[np.intp],
    denied: NDArray[np.bool_],
    *,
    n_angles: int = 72,
) -> Tensor:
    """Return the log probability of one phrase about each cell of a ground, shape (S,).

    Parameters
    ----------
    options
        All that could have been said of the ground, as terms of S cells; see
        :func:`sloop_ppl.models.grounded_relation.word_options`.
    model
        A model with ``"speaker"`` normalisation; its lapse is left out. Numbers of its likelihood
        and the concentration of its frames may be tensors of shape (S,).
    words
        Index among the options of the word said of each cell, shape (S,).
    denied
        Whether it was denied, shape (S,).
    n_angles
        Angles that stand for the frame, which is summed out: 72 are exact to rounding for a smooth
        likelihood and to some .005 in the log for one with a kink.

    Notes
    -----
    The phrase factor at many known cells at once, which is what learning from them takes.
    """
    front = options[speaker_words().index("front")]
    angles, log_mass = frame_angle_masses(model.frame_prior(front), n_angles)
    log_p = word_weights(model.likelihood, options, angles).log_chances(words)
    if denied.any():
        other = log1mexp(log_p).clamp_min(LEAST_LOG)
        log_p = torch.where(torch.from_numpy(denied), other, log_p)
    return torch.logsumexp(log_p + log_mass, 0)


def log_vocabulary(
    likelihood: RelationLikelihood, relation: GroundedRelation, frame_angles_rad: Tensor
) -> Tensor:
    """Return the log of the sum of g over all that could have been said instead, shape (B, S)."""
    options, _ = word_options(relation)
    return word_weights(likelihood, options, frame_angles_rad).log_total


def log_greatest(
    data: ProgramData, likelihood: RelationLikelihood, meaning: GroundedRelation
) -> Tensor:
    """Return the log of the greatest g over cells and fronts, shape (1, 1)."""
    if data.model.normalisation != "map":
        return torch.zeros(1, 1, dtype=torch.float64)
    angles = None
    if data.model.frame_prior_for(meaning) is not None:
        turns = torch.arange(_PEAK_ANGLES, dtype=torch.float64)
        angles = turns * (2 * math.pi / _PEAK_ANGLES)
    return likelihood.log_g(meaning, meaning.directions(angles)).amax().reshape(1, 1)


def log_none_holds(
    data: ProgramData, likelihood: RelationLikelihood, relation: GroundedRelation
) -> Tensor:
    """Return the log of what is left when a relation to each of several places is denied, (1, S).

    "Not near a bank" denies every bank: prod_c (1 - denial g_c / max g_c), each with its frame
    summed out.
    """
    total = torch.zeros(1, relation.n_cells, dtype=torch.float64)
    for one in relation.each_denied:
        log_g = log_expected(data, likelihood, one, data.model.frame_prior_for(one))
        log_peak = torch.zeros(1, dtype=torch.float64)
        if data.model.normalisation == "map":
            log_peak = log_greatest(data, likelihood, one)
        total = total + log_held(log_g, one, data.model, log_peak)
    return total


def log_held(
    log_g: Tensor, relation: GroundedRelation, model: ObservationModel, log_peak: Tensor
) -> Tensor:
    """Return the log of what holds: g, or of a denied relation 1 - denial g / max g.

    Observing 0 of a factor that is divided by its sum over the map would tell next to nothing;
    divided by its greatest value it tells as much as an asserted phrase. Under other
    normalisations g is the probability of a truth or of a word, and 1 - g that of its denial. At
    least the log of 1e-300: a cell that is ruled out must not turn sums into NaN.
    """
    if not relation.negated:
        return log_g
    if model.normalisation == "map":
        log_g = log_g - log_peak + math.log(max(model.denial, 1e-300))
    return log1mexp(log_g.clamp_max(0.0)).clamp_min(LEAST_LOG)


_PEAK_ANGLES = 72
"""Fronts that the greatest g is looked for at: 5 degrees apart, the peak of a von Mises shape is
met to within kappa (1 - cos 2.5 degrees), .003 nats for kappa 3."""


def with_lapse(log_p: Tensor, lapse: Any, log_uninformative: float) -> Tensor:
    """Return log[(1 - lapse) p + lapse u], a phrase that may say nothing."""
    if not lapse:
        return log_p
    share = double(lapse)  # a tensor while it is learnt
    return torch.logaddexp(log_p + torch.log1p(-share), share.log() + log_uninformative)


def double(number: Any) -> Tensor:
    """Return a number as a float64 tensor; a tensor keeps its gradient."""
    return torch.as_tensor(number, dtype=torch.float64)


@dataclass(frozen=True, eq=False)
class Program:
    """The generative model of one description; call it to run it.

    Parameters
    ----------
    data
        What it is run on.
    frames
        ``"bins"``, ``"density"`` or ``"summed"``; see `build`.
    bins
        Angle bins of each frame.
    pairs
        Name of a site -> ids of a figure and of the target that is its ground, and the log factor
        of their cells, shape (V..., S, S), the ground's first. Engines leave them out: they weigh
        the cells of each target by itself, and the joint posterior has the rest.
    """

    data: ProgramData
    frames: Frames = "bins"
    bins: int = 72
    pairs: Mapping[str, PairSite] = field(default_factory=dict)

    @property
    def targets(self) -> tuple[str, ...]:
        """Ids of the targets."""
        return self.data.targets

    def __call__(self) -> dict[str, Tensor]:
        """Run the program; return the cell of each target.

        Raises
        ------
        ProgramError
            When a likelihood fails, or a number is drawn several times at once.
        """
        try:
            return generative_model(self.data, self.frames, self.bins, self.pairs)
        except SloopError as error:
            raise ProgramError(error) from error


def build(
    description: Description,
    city: CityMap,
    model: str | ObservationModel = "bayes",
    *,
    frames: Frames = "bins",
    log_prior: Tensor | None = None,
    truth: Mapping[str, tuple[float, float]] | None = None,
    priors: Mapping[str, Any] | None = None,
    frame_bins: int = 72,
) -> Program:
    """Return the generative model of a description as a plain Pyro callable.

    Parameters
    ----------
    description
        What was said.
    city
        The map.
    model
        A model's name, or an ObservationModel.
    frames
        ``"bins"``: each frame is a Categorical over angle bins, its angle a deterministic site.
        ``"density"``: a continuous angle with the same prior, for NUTS and guides. ``"summed"``:
        frames, lapses and other latents of one phrase are summed out, as in the exact engine.
    log_prior
        Log belief over cells of each target, shape (N, S); uniform when None.
    truth
        Target -> true place in metres; only for the model ``informed``.
    priors
        Parameter of the likelihood -> Pyro distribution; it becomes a site of that name.
    frame_bins
        Angles that stand for each frame, > 0.

    Returns
    -------
    Program
        Takes no arguments. Sites of target T and its relation j: ``T/component``, ``T/cell``
        (row by row from the south-west), ``T/frame_j`` and ``T/angle_j`` (radians), ``T/lapse_j``,
        ``T/holds_j`` (observed); ``reading``, ``either_g`` and ``ground_k`` where the description
        leaves its reading, the branch of alternatives g or the referent of mention k open; the
        factors ``T/temper``, ``T/normaliser``, ``T/cut`` and ``T/shared_error``; ``T/together``
        (observed) for components that are no product of phrases; ``frame/G`` where phrases share
        the frame of ground G; latents that the model declares by their names. Relations to other
        targets come last of ``T/holds_j``, and have no sites of frame and lapse: these are summed
        out.

    Raises
    ------
    UnknownName
        When there is no such model, ground or parameter.
    InputError
        When two sites would have one name, the tables would not fit in memory, or there is no
        density where one is asked for.

    Examples
    --------
    >>> import pyro
    >>> import sloop_ppl as sloop
    >>> city = sloop.load_map("cleveland")
    >>> said = sloop.parse("the green toyota is behind velvet dog", city)
    >>> program = sloop.models.build(said, city, "bayes")
    >>> trace = pyro.poutine.trace(program).get_trace()
    >>> [name for name in trace.stochastic_nodes if name.endswith(("cell", "_0"))]
    ['GreenToyota/cell', 'GreenToyota/frame_0', 'GreenToyota/lapse_0']
    """
    if not isinstance(description, Description) or not isinstance(city, CityMap):
        raise InputError(
            f"The program is built of a {type(description).__name__} and a {type(city).__name__}; "
            "expected what parse(text, city) and load_map(name) return"
        )
    chosen = preset(model)
    if frames not in get_args(Frames):
        raise UnknownName("way to draw frames", str(frames), get_args(Frames))
    known = [parameter.name for parameter in parameters_of(chosen.likelihood)]
    for name in priors or {}:
        if name not in known:
            raise UnknownName(f"parameter of the likelihood of {chosen.name}", name, known)
    for name, prior in (priors or {}).items():
        if not isinstance(prior, torch.distributions.Distribution):
            raise InputError(
                f"The prior of '{name}' is {prior!r}; expected a distribution, such as "
                "pyro.distributions.LogNormal(0.0, 1.0)"
            )
    grounded = ground_description(description, city, chosen)
    to_targets = ground_target_relations((description,), city, chosen)
    truths = true_places(truth, tuple(grounded), chosen)
    if isinstance(frame_bins, bool) or not isinstance(frame_bins, int) or frame_bins < 1:
        raise InputError(f"frame_bins is {frame_bins!r}; expected a whole number of angles above 0")
    shape = (len(grounded), city.grid.size)
    if log_prior is not None and (
        not isinstance(log_prior, Tensor) or tuple(log_prior.shape) != shape
    ):
        found = tuple(getattr(log_prior, "shape", ()))
        raise InputError(
            f"log_prior is a {type(log_prior).__name__} of shape {found}; expected a torch tensor "
            f"of shape {shape}: targets, cells"
        )
    data = program_data(
        grounded,
        city,
        chosen,
        log_prior,
        truths=truths,
        number_priors=priors,
        to_targets=to_targets,
    )
    if frames == "bins":
        check_size(data, frame_bins)
    if frames == "density":
        check_density(data, f"Model '{chosen.name}'")
        check_continuous(data)
    return Program(data, frames, frame_bins, pair_sites(data))


def pair_kernels(data: ProgramData) -> tuple[PairKernel, ...]:
    """Return the factors of relations to other targets, in the order of saying per target."""
    return tuple(
        PairKernel(term, data.city, data.model, data.power_of(term), log_meanings)
        for terms in data.to_targets.values()
        for term in terms
    )


def log_meanings(data: ProgramData) -> Tensor:
    """Return the log of what holds of the one phrase of a program under each meaning, (M, S)."""
    likelihood, relation = data.model.likelihood, data.relations[0][0]
    phrase = data.phrase(relation)
    log_g = phrase.over_meanings(
        lambda meaning, frame: log_expected(data, likelihood, meaning, frame), phrase.frames
    )
    peak = log_g.new_zeros(1)
    if relation.negated:
        peak = phrase.over_meanings(lambda one, _: log_greatest(data, likelihood, one))
    return log_held(log_g, relation, data.model, peak)[..., 0, :].reshape(-1, data.n_cells)


def pair_sites(data: ProgramData) -> dict[str, PairSite]:
    """Return the sites of relations to other targets, ``T/holds_j`` counted on; see `Program`.

    Raises
    ------
    InputError
        When a table would not fit in memory, or there are too many sites to enumerate together.
    """
    found: dict[str, PairSite] = {}
    counts = {t: len(relations) for t, relations in zip(data.targets, data.relations, strict=True)}
    for kernel in pair_kernels(data):
        term = kernel.relation
        if data.n_cells**2 > _MOST_NUMBERS or _count_sites(data) > _MOST_DIMS:
            raise InputError(
                f"The program of '{term.relation} {term.ground}' relates two targets of "
                f"{data.n_cells} cells beside {_count_sites(data)} sites; use a smaller map, or "
                "sloop_ppl.infer, which multiplies them without a table"
            )
        log_pair, off = kernel.log_rows(torch.arange(data.n_cells)), kernel.log_silent
        if kernel.is_alternative:  # the phrase to a place is silent then, and counts as that
            log_pair, off = log_pair - off, 0.0
        for latent in reversed(data.shared):
            values = term.holds_when.get(latent.name)
            rows = [log_pair]
            if values is not None:
                silent = torch.full_like(log_pair, off)
                rows = [log_pair if value in values else silent for value in latent.support]
            log_pair = torch.stack(rows)
        name = f"{term.figure}/holds_{counts[term.figure]}"
        counts[term.figure] += 1
        found[name] = (term.figure, term.ground, log_pair)
    return found


def check_continuous(data: ProgramData) -> None:
    """Refuse a program with frames="density" that has no continuous site at all.

    Raises
    ------
    InputError
        When it has none; NUTS would return nothing.
    """
    own = [frame for _, _, phrase in data.framed_phrases() for frame in phrase.frames or ()]
    if data.number_priors or any(frame is not None and not frame.is_point for frame in own):
        return
    raise InputError(
        f"Model '{data.model.name}' has no continuous latent here: no phrase depends on a frame "
        "with a density, and no number has a prior; use frames='bins', or give priors={parameter: "
        "distribution}"
    )


def check_density(data: ProgramData, what: str, *, points: bool = True) -> None:
    """Refuse frames that have no density.

    Parameters
    ----------
    what
        What needs the density, for the message.
    points
        True to let a frame pass that is points alone: it stays discrete in every program.

    Raises
    ------
    InputError
        When a frame, or a part of it, is a point.
    """
    for _, _, phrase in data.framed_phrases():
        for frame in filter(None, phrase.frames or ()):
            pointed = any(math.isinf(part.kappa) for part in frame.parts)
            if pointed and not (points and frame.is_point):
                raise InputError(
                    f"{what} needs frames with a density and got a point in the frame of "
                    f"'{phrase.relation.relation} {phrase.relation.ground}'; use frames='bins', a "
                    "model such as bayes, or the exact engine"
                )


def check_size(data: ProgramData, bins: int) -> None:
    """Refuse to lay out tables that would not fit in memory."""
    for relations in data.relations:
        for relation in relations:
            phrase = data.phrase(relation)
            n_angles = 1 if phrase.frames is None else bins
            shape = (len(data.model.components), *phrase.sizes, n_angles, data.n_cells)
            if math.prod(shape) > _MOST_NUMBERS:
                raise InputError(
                    f"The program of this description would need tables of {shape} numbers; use "
                    "fewer frame_bins, a smaller map, or the exact engine"
                )


_MOST_NUMBERS = 200_000_000
"""Of one table: 1.6 GB in float64, and enumeration holds a few of them."""
