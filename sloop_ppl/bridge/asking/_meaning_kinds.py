"""Questions about what was meant: which place, which reading, which way a ground faces."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sloop_ppl.bridge.asking.kinds import Proposal
from sloop_ppl.bridge.asking.scene import Scene
from sloop_ppl.bridge.relation_text import relation_in_words
from sloop_ppl.inference import GroundPosterior
from sloop_ppl.inference.factors import site_name
from sloop_ppl.language import HEARER, NOT_ON_MAP, SPEAKER, SpatialRelation
from sloop_ppl.maps._whereabouts import COMPASS_POINTS
from sloop_ppl.models import SharedFrame

__all__ = ["frames", "readings", "referents"]

Table = NDArray[np.float64]

_MOST_PLACES = 4
_LEAST, _MOST = 0.02, 0.98
_FACINGS = ("north", "east", "south", "west")


def _constant(table: Table) -> Any:
    """Return a table that is the same in every scene: its latent is no cell."""
    return lambda _scene: table


def referents(scene: Scene) -> Iterator[Proposal]:
    """Yield "which X is meant", for each mention that may be one of several places."""
    seen = set()
    for ground in scene.posterior.grounds(scene.target):
        name = ground.latent
        if name is None or name in seen or not ground.is_open:
            continue
        seen.add(name)
        support = list(scene.posterior.joint.support(name))
        likely = [c.ground for c in ground.candidates if c.ground and c.p >= _LEAST]
        kept = likely[:_MOST_PLACES]
        if len(kept) < 1 or len(support) < 2:
            continue
        labels = _labels(scene, kept)
        table = np.zeros((len(kept) + 1, len(support)))
        for v, place in enumerate(support):
            table[kept.index(place) if place in kept else len(kept), v] = 1.0
        none = "none of these" if len(kept) > 1 else "another one"
        yield Proposal(
            f"Which place do you mean by {_words(scene, ground)}: {', '.join(labels)} or {none}?",
            (*labels, none),
            _constant(table),
            tuple(kept),
            about="referent",
            latent=name,
            described_in=_text(scene, name),
        )


def _labels(scene: Scene, places: Sequence[str]) -> list[str]:
    """Return a word for each place, with its side where a name is not enough."""
    names = [scene.city.landmark(place).name for place in places]
    found = []
    for place, name in zip(places, names, strict=True):
        if name and names.count(name) == 1:
            found.append(name)
            continue
        x, y = scene.city.centroid(place)
        middle_x, middle_y = np.mean([scene.city.centroid(p) for p in places], axis=0)
        octant = COMPASS_POINTS[round(math.atan2(y - middle_y, x - middle_x) / (math.pi / 4)) % 8]
        kind = name or f"the {scene.city.landmark(place).kind}"
        near = scene.city.nearest(x, y, [m for m in scene.city.of_kind("street") if m.name])
        by = f" by {near[0].label}" if near else ""
        found.append(f"{kind} in the {octant}{by}")
    return [f"{w} ({found[:i].count(w) + 1})" if found.count(w) > 1 else w
            for i, w in enumerate(found)]  # fmt: skip


def _words(scene: Scene, ground: GroundPosterior) -> str:
    """Return the words of a mention as they were said."""
    spans = ground.relation.spans
    for description in scene.posterior.descriptions:
        known = ground.relation in description.relations
        if known and spans is not None and ground.slot < len(spans.grounds):
            start, end = spans.grounds[ground.slot]
            return f"“{description.text[start:end]}”"
    return f"“{relation_in_words(ground.relation, scene.names)}”"


def _text(scene: Scene, latent: str) -> str:
    """Return the text of the description that has a latent."""
    for which, factor in enumerate(scene.posterior.factors):
        for shared in factor.data.shared:
            if site_name(shared.name, which) == latent:
                _, _, number = shared.name.rpartition("/text_")
                return factor.descriptions[int(number) if number.isdigit() else 0].text
    return ""


def readings(scene: Scene) -> Iterator[Proposal]:
    """Yield "do you mean that ...", for what some readings say and others do not."""
    posterior, which = scene.posterior, 0
    for n, factor in enumerate(posterior.factors):
        for d, description in enumerate(factor.descriptions):
            site = site_name(f"reading/text_{d}" if d else "reading", n)
            known = posterior.readings(which)
            which += 1
            if site not in posterior.joint.latents:
                continue
            support = list(posterior.joint.support(site))
            kept = [one for one in known if one.prior > 0]
            claims: dict[str, tuple[SpatialRelation, Table]] = {}
            for relation in (r for one in kept for r in one.reading.relations):
                holds = np.array(
                    [any(_same(relation, r) for r in kept[v].reading.relations) for v in support],
                    dtype=np.float64,
                )
                claims.setdefault(_claim(scene, relation), (relation, holds))
            p = np.array([one.p for one in kept])[support]
            for words, (relation, holds) in claims.items():
                nameless = [g for g in relation.grounds if g in scene.city
                            and not scene.city.landmark(g).name]  # fmt: skip
                if nameless or NOT_ON_MAP in relation.grounds:
                    continue
                if relation.figure == scene.target and _LEAST < float(p @ holds) < _MOST:
                    yield Proposal(
                        f"Do you mean that {words}?",
                        ("yes", "no"),
                        _constant(np.stack([holds, 1.0 - holds])),
                        tuple(g for g in relation.grounds if g in scene.city),
                        about="reading",
                        latent=site,
                        described_in=description.text,
                    )


def _same(one: SpatialRelation, other: SpatialRelation) -> bool:
    """Tell whether two readings make one claim, wherever in the text it was read."""
    fields = ("figure", "relation", "grounds", "negated", "distance", "part")
    return all(getattr(one, name) == getattr(other, name) for name in fields)


def _claim(scene: Scene, relation: SpatialRelation) -> str:
    verb = "are" if relation.figure == SPEAKER else "is"
    noun = scene.noun if relation.figure == scene.target else relation.figure
    words = relation_in_words(relation, scene.names)
    if HEARER in relation.grounds:  # it is who listens that asks
        words = words.replace("the hearer", "me")
    return f"{noun} {verb} {words}"


def frames(scene: Scene) -> Iterator[Proposal]:
    """Yield "which way does X face", for each ground whose front a relation depends on."""
    posterior, seen = scene.posterior, set()
    for framed in posterior.framed(scene.target):
        ground = framed.term.ground
        data = posterior.factors[framed.which].data
        shared = [s.name for s in data.shared if isinstance(s, SharedFrame) and s.ground == ground]
        name = f"{scene.target}/frame_{framed.relation}"
        if shared:
            name = site_name(shared[0], framed.which)
        if name in seen or name not in posterior.joint.latents or ground == NOT_ON_MAP:
            continue
        seen.add(name)
        angles = np.array(posterior.joint.support(name), dtype=np.float64)
        if ground not in scene.city:
            continue
        table = scene.person.quarters(angles)
        yield Proposal(
            f"Which way does the front of {scene.label(ground)} face: north, east, south or west?",
            _FACINGS,
            _constant(table),
            (ground,),
            about="frame",
            latent=name,
            described_in=posterior.factors[framed.which].descriptions[0].text,
        )
