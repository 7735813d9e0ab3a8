"""Which latents phrases share: frames, what a description leaves open, what a model declares."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

from sloop_ppl.errors import InputError
from sloop_ppl.models.grounded_relation import GroundedRelation
from sloop_ppl.models.latents import Latent
from sloop_ppl.models.phrase import RELIABLE, SharedFrame
from sloop_ppl.models.presets import ObservationModel

__all__ = ["MOST_SETTINGS", "latents_of", "shared_and_own"]

_RESERVED = (
    *("angle", "cell", "component", "cut", "draw", "frame", "holds", "lapse", "normaliser"),
    *("phrase", "prior", "reading", RELIABLE, "shared_error", "targets", "temper", "together"),
    *("x", "y"),
)
"""Names of the program's sites and of the axes of tables."""

MOST_SETTINGS = 72 * 72
"""Joint values of shared latents that are enumerated: each has a table of components and cells, so
that 5184 of a map of 41 x 41 cells and two components take 140 MB."""

_MOST_NUMBERS = 1 << 23
"""Numbers in the table of a target, beyond which what a description leaves open is cut short."""

_SHARED_BINS = {1: 72, 2: 36}
"""Angle bins of each frame when so many are shared: 36 each for two leave room for a latent of four
values beside them."""


def latents_of(model: ObservationModel) -> tuple[Latent, ...]:
    """Return the latents of a model: declared, of its likelihood, and the speaker's reliability."""
    declared = _declared(model)
    if not model.unreliable:
        return declared
    shares = (1 - model.unreliable, model.unreliable)
    return (*declared, Latent(RELIABLE, (True, False), shares))


def _declared(model: ObservationModel) -> tuple[Latent, ...]:
    return (*model.latents, *getattr(model.likelihood, "latents", ()))


def shared_and_own(
    grounded: Mapping[str, Sequence[GroundedRelation]],
    to_targets: Mapping[str, Sequence[GroundedRelation]],
    model: ObservationModel,
    n_cells: int,
    numbers: Collection[str],
) -> tuple[tuple[SharedFrame | Latent, ...], tuple[Latent, ...]]:
    """Return the latents that several phrases depend on, and those that one phrase each does.

    Parameters
    ----------
    grounded
        Target -> its grounded relations.
    to_targets
        Target -> its relations to other targets.
    model
        The observation model.
    n_cells
        Number S of cells.
    numbers
        Parameters of the likelihood that have sites of their own.

    Raises
    ------
    InputError
        When two latents have one name, or more are shared than can be enumerated.
    """
    every = [relation for phrases in grounded.values() for relation in phrases]
    frames = _shared_frames(every, model)
    placed = [(t, j, r) for t, phrases in grounded.items() for j, r in enumerate(phrases)]
    between = [relation for terms in to_targets.values() for relation in terms]
    latents = (
        *_choices_of([*every, *between]),
        *(one for latent in latents_of(model) for one in latent.each(placed)),
    )
    declared = tuple(
        latent
        for latent in latents
        if latent.choice in ("reading", "branch")
        or any(latent.is_about(relation) for relation in between if latent.choice)
        or sum(latent.is_about(relation) for relation in every) != 1
    )
    declared = _most_probable(declared, frames, len(model.components) * n_cells)
    names = [latent.name for latent in _declared(model)]
    _check_names(names, tuple(grounded), frames, numbers)
    _check_sites([latent.name for latent in latents])
    _check_shared((*frames, *declared), model)
    shared = {latent.name for latent in declared}
    own = tuple(latent for latent in latents if latent.name not in shared)
    return (*frames, *declared), own


def _choices_of(every: Sequence[GroundedRelation]) -> tuple[Latent, ...]:
    """Return the latents that descriptions declare: readings, then branches, then grounds."""
    kinds = ("reading", "branch", "ground")
    choices = {c.name: c for kind in kinds for r in every for c in r.choices if c.kind == kind}
    return tuple(map(Latent.of_choice, choices.values()))


def _most_probable(
    latents: tuple[Latent, ...], frames: Sequence[SharedFrame], size: int
) -> tuple[Latent, ...]:
    """Leave out the least probable values of readings, branches and grounds, until all fits.

    Parameters
    ----------
    latents
        Those that phrases share.
    frames
        Frames that they share.
    size
        Numbers in the table of one joint value.

    Notes
    -----
    A person who talks long leaves more open than can be listed; what was least probable from the
    start goes first. The most probable reading stays.
    """
    kept = list(latents)
    fixed = math.prod(len(frame.support) for frame in frames)

    def is_too_much() -> bool:
        joint = fixed * math.prod(len(latent.support) for latent in kept)
        return joint > MOST_SETTINGS or joint * size > _MOST_NUMBERS

    while is_too_much():
        options = [
            (latent.prior[v], -n, -v)
            for n, latent in enumerate(kept)
            if latent.choice is not None
            for v in range(1, len(latent.support))
        ]
        if not options:
            break
        _, n, v = min(options)
        kept[-n] = _without(kept[-n], -v)
    return tuple(kept)


def _without(latent: Latent, v: int) -> Latent:
    """Return a latent without one of its values."""
    support = (*latent.support[:v], *latent.support[v + 1 :])
    prior = (*latent.prior[:v], *latent.prior[v + 1 :])
    total = math.fsum(prior)
    return replace(latent, support=support, prior=tuple(p / total for p in prior))


def _shared_frames(
    every: Sequence[GroundedRelation], model: ObservationModel
) -> tuple[SharedFrame, ...]:
    """Return the frames that a model lets several phrases share.

    A frame is shared by all frame phrases about a certain ground, of any target; its prior is that
    of a front or behind phrase, if there is one, whatever the order in which they were said.
    """
    if not model.shared_frames:
        return ()
    framed = [
        relation
        for relation in every
        if not relation.has_open_ground and model.frame_prior_for(relation) is not None
    ]
    counts = Counter(relation.ground for relation in framed)
    several = [ground for ground, count in counts.items() if count > 1]
    if len(several) > max(_SHARED_BINS):
        raise InputError(
            f"{len(several)} grounds have a front that several phrases share "
            f"({', '.join(several)}); at most {max(_SHARED_BINS)} can be enumerated; say less at "
            "a time or use a model without shared frames"
        )
    shared = []
    for ground in several:
        about = [relation for relation in framed if relation.ground == ground]
        prior = model.frame_prior_for(min(about, key=lambda r: (r.record.absolute, r.relation)))
        if prior is not None:
            shared.append(SharedFrame(ground, *prior.bins(_SHARED_BINS[len(several)])))
    return tuple(shared)


def _check_shared(shared: Sequence[SharedFrame | Latent], model: ObservationModel) -> None:
    """Refuse more joint values of shared latents than can be enumerated, and to cut them."""
    joint = math.prod(len(latent.support) for latent in shared)
    if joint > MOST_SETTINGS:
        raise InputError(
            f"Phrases share {len(shared)} latents with {joint} joint values "
            f"({', '.join(latent.name for latent in shared)}); at most {MOST_SETTINGS} can be "
            "enumerated; say less at a time, or declare fewer"
        )
    if shared and any(part.cut for part in model.components):
        raise InputError(
            f"Model '{model.name}' cuts cells below uniform, which is not defined where phrases "
            f"share a latent ('{shared[0].name}'); use its variant 'paper', or bayes"
        )


def _check_names(
    latents: Sequence[str],
    targets: Sequence[str],
    frames: Sequence[SharedFrame],
    numbers: Collection[str],
) -> None:
    """Refuse a name that two sites would have."""
    taken = {*(frame.name for frame in frames), *numbers}
    for name in latents:
        if name in _RESERVED:
            raise InputError(f"Latent '{name}' has a name that the program uses; choose another")
        if "[" in name:
            raise InputError(f"Latent '{name}' has a bracket in its name; expected none")
        if name in taken:
            raise InputError(f"Two latents are named '{name}'; expected a name of its own for each")
        if any(name == target or name.startswith(f"{target}/") for target in targets):
            raise InputError(
                f"Latent '{name}' has the name of a site of a target; expected another name"
            )
        taken.add(name)


def _check_sites(names: Sequence[str]) -> None:
    """Refuse latents whose sites have one name: `q` of each ground beside `q/Ivy`."""
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        raise InputError(
            f"Two latents have a site named '{twice[0]}'; expected a name of its own for each"
        )
