"""A description and a posterior as what a page shows of them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from sloop_ppl.bridge.relation_text import (
    ground_label,
    names_of,
    reading_in_words,
    relation_in_words,
)
from sloop_ppl.inference import Posterior
from sloop_ppl.language import NOT_ON_MAP, Description, SpatialRelation
from sloop_ppl.language._place_names import PlaceNames
from sloop_ppl.maps import CityMap
from sloop_ppl.maps._whereabouts import nearest_landmark, whereabouts
from sloop_ppl.web._codec import packed_bits, packed_floats

__all__ = ["belief_payload", "frames_payload", "reading_payload", "spoken", "why_payload"]

_NEAR_M = 15.0


def reading_payload(read: Description, city: CityMap) -> dict[str, Any]:
    """Return what was read: marked stretches of the text, phrases, and what was set aside."""
    names = PlaceNames(city, (read,))
    return {
        "text": read.text,
        "spans": _spans(read),
        "phrases": [_phrase(r, i, read, names) for i, r in enumerate(read.relations)],
        "unresolved": [
            {
                "text": missed.text,
                "span": list(missed.span),
                "status": missed.status,
                "candidates": [ground_label(names, c) for c in missed.candidates[:3]],
            }
            for missed in read.unresolved
        ],
        "readings": [
            {"p": one.probability, "text": reading_in_words(one, names, len(read.targets) > 1)}
            for one in read.all_readings()
        ],
    }


def belief_payload(posterior: Posterior) -> dict[str, Any]:
    """Return the belief over each target with what is drawn and said of it at once."""
    return {
        "model": posterior.model.name,
        "targets": [_target(posterior, target) for target in posterior.targets],
    }


def frames_payload(posterior: Posterior) -> dict[str, Any]:
    """Return which way the grounds face, by target; it takes longer than the belief."""
    found = {}
    for target in posterior.targets:
        found[target] = [
            {
                "ground": frame.ground,
                "label": ground_label(names_of(posterior), frame.ground),
                "relation": frame.relation,
                "angle_rad": frame.mean_rad,
                "kappa": frame.kappa,
                "p": frame.p,
                "at": list(_centroid(frame.ground, posterior.city)),
            }
            for frame in posterior.frames(target)
        ]
    return found


def why_payload(
    posterior: Posterior, target: str, at: tuple[float, float] | None
) -> dict[str, Any]:
    """Return how much each phrase moves a belief and, at a place, what each says of it.

    Returns
    -------
    dict
        ``phrases``: for each, ``bits`` by which the belief moves when it is left out, and
        ``times``, how much likelier than on average the phrase alone makes the place's cell.
        ``components``: the probability of each component there.
    """
    cell = None if at is None else posterior.city.grid.cell_at(*at)
    size = posterior.city.grid.size
    tables = posterior.phrase_tables(target) if cell is not None else ()
    phrases = []
    for one in posterior.influence(target):
        entry: dict[str, Any] = {
            "text": relation_in_words(one.relation, names_of(posterior)),
            "bits": one.bits,
        }
        if cell is not None:
            entry["times"] = float(tables[one.index][cell] * size)
        phrases.append(entry)
    payload: dict[str, Any] = {"phrases": phrases}
    if cell is not None and at is not None:
        payload["p"] = float(posterior.belief(target)[cell])
        payload["where"] = whereabouts(posterior.city, *at)
        if posterior.component(target):
            shares = posterior.responsibilities(target).values[:, cell[0], cell[1]]
            names = posterior.component(target)
            payload["components"] = {
                name: float(share)
                for name, share in zip(names, shares, strict=True)
                if math.isfinite(share)
            }
    return payload


def spoken(posterior: Posterior, target: str) -> str:
    """Return one sentence on where a target probably is, for those who listen to the page."""
    city, belief = posterior.city, posterior.belief(target)
    landmark = nearest_landmark(city, *posterior.mode(target))
    if landmark is None:
        return f"{target}: {belief.max():.1%} in the likeliest cell"
    near = float(belief[city.fields(landmark.id).distance_m <= _NEAR_M].sum())
    return f"{target}: {_percent(near)} within {_NEAR_M:.0f} m of {landmark.label}"


def _percent(p: float) -> str:
    return f"{100 * p:.0f} %" if 0.01 <= p <= 0.99 else f"{100 * p:.2g} %"


def _target(posterior: Posterior, target: str) -> dict[str, Any]:
    city, belief = posterior.city, posterior.belief(target)
    prior = np.exp(posterior.log_prior[target]).reshape(belief.shape)
    x, y = posterior.mode(target)
    return {
        "id": target,
        "belief": packed_floats(belief),
        "prior": None if np.ptp(prior) < 1e-12 else packed_floats(prior / prior.sum()),
        "hpd50": packed_bits(posterior.hpd(target, 0.5)),
        "hpd90": packed_bits(posterior.hpd(target, 0.9)),
        "hpd90_m2": float(posterior.hpd(target, 0.9).sum() * city.grid.cell_m**2),
        "mode_m": [x, y],
        "where": whereabouts(city, x, y),
        "spoken": spoken(posterior, target),
        "entropy_bits": posterior.entropy(target) / math.log(2),
        "components": [
            {"name": name, "p": p, "prior": posterior.component_prior(target).get(name, 0.0)}
            for name, p in posterior.component(target).items()
        ],
        "referents": [
            {
                "phrase": one.relation.relation,
                "candidates": [
                    {
                        "ground": c.ground,
                        "label": ground_label(names_of(posterior), c.ground or NOT_ON_MAP),
                        "p": c.p,
                        "at": list(_centroid(c.ground, city)) if c.ground else None,
                    }
                    for c in one.candidates[:6]
                ],
            }
            for one in posterior.grounds(target)
        ],
    }


def _spans(read: Description) -> list[dict[str, Any]]:
    """Return the marked stretches of the text, in order and without overlap."""
    marks: list[dict[str, Any]] = []
    for index, relation in enumerate(read.relations):
        if relation.spans is None:
            continue
        spans = relation.spans
        roles = [("figure", spans.figure), ("relation", spans.relation)]
        roles += [("ground", span) for span in spans.grounds]
        marks += [
            {
                "span": list(span),
                "role": role,
                "phrase": index,
                "status": "denied" if relation.negated else "asserted",
                "confidence": relation.confidence,
            }
            for role, span in roles
            if span[0] < span[1]
        ]
    marks += [
        {"span": list(m.span), "role": "unresolved", "phrase": None, "status": m.status}
        for m in read.unresolved
    ]
    marks.sort(key=lambda mark: (mark["span"][0], -mark["span"][1]))
    apart: list[dict[str, Any]] = []
    for mark in marks:
        if not apart or mark["span"][0] >= apart[-1]["span"][1]:
            apart.append(mark)
    return apart


def _phrase(
    relation: SpatialRelation, index: int, read: Description, names: PlaceNames
) -> dict[str, Any]:
    return {
        "index": index,
        "figure": relation.figure,
        "relation": relation.relation,
        "grounds": [ground_label(names, ground) for ground in relation.grounds],
        "negated": relation.negated,
        "either": None if relation.either is None else list(relation.either),
        "confidence": relation.confidence,
        "text": relation_in_words(relation, names),
        "candidates": [
            [
                {"label": ground_label(names, c.ground or NOT_ON_MAP), "p": c.probability}
                for c in relation.slot(i)[:6]
            ]
            for i in range(len(relation.grounds))
        ],
        "words": [] if relation.spans is None else [
            read.text[slice(*span)] for span in (relation.spans.relation, *relation.spans.grounds)
        ],
    }  # fmt: skip


def _centroid(ground: str, city: CityMap) -> tuple[float, ...]:
    return tuple(round(v, 2) for v in city.centroid(ground)) if ground in city else ()
