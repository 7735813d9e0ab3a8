"""What was probably meant: the posterior over a description's readings and over its referents."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from sloop_ppl.inference.factors import DescriptionFactor, site_name
from sloop_ppl.inference.joint import JointPosterior
from sloop_ppl.language import NOT_ON_MAP, Reading, SpatialRelation
from sloop_ppl.models._choices import Choice, Phrasing, phrasings_of

__all__ = ["GroundPosterior", "ReadingPosterior", "Referent", "readings_of", "referents_of"]


class Referent(NamedTuple):
    """One place that a mention may refer to.

    Parameters
    ----------
    ground
        Id of the place; None when it is not on the map.
    p
        Probability, given everything.
    prior
        The same before the map was asked.
    """

    ground: str | None
    p: float
    prior: float


@dataclass(frozen=True)
class GroundPosterior:
    """What one ground of a relation probably is.

    Parameters
    ----------
    relation
        The relation.
    index
        Its position in ``posterior.relations(target)``.
    slot
        Which of its grounds: "between" has two.
    candidates
        The places, the most probable first. Where all of them are denied they keep their prior.
    latent
        Name of the latent in the joint posterior that tells which it is; None for a certain one,
        and for one that no component reads.
    """

    relation: SpatialRelation
    index: int
    slot: int
    candidates: tuple[Referent, ...]
    latent: str | None = None

    @property
    def is_open(self) -> bool:
        """Tell whether there is more than one place it may be, or it may be on no map."""
        return len(self.candidates) > 1 or self.candidates[0].ground is None


class ReadingPosterior(NamedTuple):
    """One way to understand a description.

    Parameters
    ----------
    reading
        The reading.
    prior
        Its probability before the map was asked.
    p
        Its probability given everything.
    """

    reading: Reading
    prior: float
    p: float


def referents_of(
    joint: JointPosterior, factors: Sequence[DescriptionFactor], target: str
) -> tuple[GroundPosterior, ...]:
    """Return what each ground of each relation of a target probably is, in the order of saying.

    Parameters
    ----------
    joint
        The joint posterior.
    factors
        The descriptions.
    target
        Id of the target.
    """
    found: list[GroundPosterior] = []
    before = 0
    for which, factor in enumerate(factors):
        if target not in factor.log_factors:
            continue
        for text in range(len(factor.descriptions)):
            phrasings = {
                one.position: one
                for one in _phrasings(factor, text)
                if one.relation.figure == target and one.position is not None
            }
            relations = factor.descriptions[text].about(target)
            for position, relation in enumerate(relations):
                one = phrasings.get(position)
                found += [
                    GroundPosterior(
                        relation,
                        before + position,
                        slot,
                        candidates,
                        _latent(joint, one, slot, which),
                    )
                    for slot, candidates in _slots(joint, relation, one, which)
                ]
            before += len(relations)
    return tuple(found)


def readings_of(
    joint: JointPosterior, factors: Sequence[DescriptionFactor], which: int
) -> tuple[ReadingPosterior, ...]:
    """Return the readings of a description with their probabilities, in the order it has them.

    Parameters
    ----------
    joint
        The joint posterior.
    factors
        The descriptions, weighed, speaker by speaker.
    which
        Position among all texts.
    """
    texts = [(n, d) for n, factor in enumerate(factors) for d in range(len(factor.descriptions))]
    n, d = texts[which]
    readings = factors[n].descriptions[d].all_readings()
    site = site_name(f"reading/text_{d}" if d else "reading", n)
    kept = [h for h, reading in enumerate(readings) if reading.probability > 0]
    after = {h: reading.probability for h, reading in enumerate(readings)}
    if not factors[n].data.model.sum_readings:
        after = {h: float(h == 0) for h in after}
    elif site in joint.latents:
        shares = dict(zip(joint.support(site), joint.probabilities(site), strict=True))
        after = dict.fromkeys(after, 0.0)
        after |= {kept[value]: float(p) for value, p in shares.items()}
    return tuple(
        ReadingPosterior(reading, reading.probability, after[h])
        for h, reading in enumerate(readings)
    )


def _phrasings(factor: DescriptionFactor, text: int) -> tuple[Phrasing, ...]:
    model = factor.data.model
    return phrasings_of(
        factor.descriptions[text],
        sum_readings=model.sum_readings,
        sum_grounds=model.sum_grounds,
        text=text,
    )


def _latent(joint: JointPosterior, one: Phrasing | None, slot: int, which: int) -> str | None:
    """Return the name of the latent that tells which place a ground is."""
    choice = one.slots[slot] if one is not None and slot < len(one.slots) else None
    site = None if choice is None else site_name(choice.name, which)
    return site if site in joint.latents else None


def _slots(
    joint: JointPosterior, relation: SpatialRelation, one: Phrasing | None, which: int
) -> list[tuple[int, tuple[Referent, ...]]]:
    """Return the candidates of each ground of a relation, as the program had them."""
    if relation.each:  # said of all of them
        return [(0, tuple(Referent(ground, 1.0, 1.0) for ground in relation.grounds))]
    found = []
    for slot in range(len(relation.grounds)):
        prior = {c.ground: c.probability for c in relation.slot(slot)}
        after: dict[str | None, float] = dict(prior)
        if one is not None:
            after = dict.fromkeys(prior, 0.0)
            choice = one.slots[slot]
            if choice is None:
                after |= {c.ground: c.probability for c in one.relation.candidates[slot]}
            else:
                after |= _after(joint, choice, site_name(choice.name, which))
        ranked = sorted(after, key=lambda ground: -after[ground])
        found.append((slot, tuple(Referent(g, after[g], prior.get(g, 0.0)) for g in ranked)))
    return found


def _after(joint: JointPosterior, choice: Choice, site: str) -> dict[str | None, float]:
    """Return the posterior of a referent; its prior where no component reads its phrase."""
    if site not in joint.latents:
        shares = dict(zip(choice.support, choice.prior, strict=True))
    else:
        shares = dict(zip(joint.support(site), joint.probabilities(site), strict=True))
    return {None if g == NOT_ON_MAP else g: float(p) for g, p in shares.items()}
