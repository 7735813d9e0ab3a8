"""Read a text on a map: the rule parser's steps, from words to a `Description`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

from sloop_ppl.language.attachment import attach
from sloop_ppl.language.attachment_record import Attached, Attachments
from sloop_ppl.language.chunks import Chunk, place_phrases, read_chunks
from sloop_ppl.language.coreference import Figures
from sloop_ppl.language.figures import FigureFinder, FigureMention
from sloop_ppl.language.grounds import Ground, GroundReader
from sloop_ppl.language.linking import LandmarkMention, link_landmarks
from sloop_ppl.language.nearest import nearest_landmarks
from sloop_ppl.language.place_index import PlaceIndex
from sloop_ppl.language.spelling import mend, split_run_ons
from sloop_ppl.language.targets import DEFAULT_TARGETS
from sloop_ppl.language.values import (
    Description,
    RelationSpans,
    SpatialRelation,
    TargetObject,
    Unresolved,
)
from sloop_ppl.language.words import Word, split_words
from sloop_ppl.maps import CityMap

__all__ = ["TextReading", "find_cues", "find_figures", "find_landmarks", "relate", "to_description"]


@dataclass
class TextReading:
    """What has been read of one text so far; each step of the pipeline fills in its part.

    Parameters
    ----------
    text
        The text.
    city
        The map.
    words, norms
        Its words, and the same with their spelling mended.
    landmarks, figures, places, chunks
        What was recognised.
    reading
        Which relation phrases locate which objects.
    targets
        The objects spoken of.
    """

    text: str
    city: CityMap
    places: PlaceIndex
    finder: FigureFinder
    words: Sequence[Word] = ()
    norms: Sequence[str] = ()
    landmarks: Sequence[LandmarkMention] = ()
    figures: Sequence[FigureMention] = ()
    kinds: Sequence[Chunk] = ()
    chunks: Sequence[Chunk] = ()
    reading: Attachments = field(default_factory=Attachments)
    targets: tuple[TargetObject, ...] = ()
    grounds: Sequence[Ground] = ()
    description: Description | None = None


def find_landmarks(state: TextReading) -> None:
    """Cut the text into words and link those that name places."""
    vocabulary = state.places.index.vocabulary
    words = split_run_ons(split_words(state.text), vocabulary.keys() | state.finder.vocabulary)
    state.words = words
    state.landmarks = link_landmarks(words, state.places.index)


def find_figures(state: TextReading) -> None:
    """Mend the spelling of the other words and find the objects among them."""
    taken = [False] * len(state.words)
    for mention in state.landmarks:
        taken[mention.first : mention.last] = [True] * (mention.last - mention.first)
    vocabulary = state.finder.vocabulary
    state.norms = [
        w.low if t or w.kind != "word" else mend(w.low, vocabulary)
        for w, t in zip(state.words, taken, strict=True)
    ]
    kinds = place_phrases(state.norms, taken)
    for kind in kinds:
        if kind.last - kind.first > 1 or state.norms[kind.first] not in vocabulary:
            taken[kind.first : kind.last] = [True] * (kind.last - kind.first)
    state.figures = state.finder.find(state.norms, taken)
    owned = {w for m in state.figures for w in range(m.first, m.last)}
    state.kinds = [k for k in kinds if k.first not in owned]


def find_cues(state: TextReading) -> None:
    """Find relation cues, directions and the small words that hold phrases together."""
    state.chunks = read_chunks(
        state.words,
        state.norms,
        state.landmarks,
        state.figures,
        state.kinds,
        state.places.streets,
    )


def relate(state: TextReading) -> None:
    """Attach relation phrases to objects."""
    reader = GroundReader(state.words, state.norms, state.chunks, state.places, settle(state))
    figures = Figures(state.finder)
    if state.finder.declared is None:
        default = {t.id for t in DEFAULT_TARGETS}
        for mention in state.figures:
            for one in mention.candidates:
                if one not in default:
                    figures.infer(_inferred(one, mention, state))
    state.reading = attach(reader, figures)
    state.targets = figures.targets()
    state.grounds = reader.grounds


def _inferred(symbol: str, mention: FigureMention, state: TextReading) -> TargetObject:
    text = " ".join(w.low for w in state.words[mention.first : mention.last])
    return TargetObject(symbol, (text,))


def settle(state: TextReading) -> dict[int, int]:
    """Return which landmark every mention stands for.

    Ties go to the map that is spoken of most, then to a place of the kind that its name says
    ("Chase Bank" is the bank rather than the tower), then to the first on the map.
    """
    homes = Counter[str]()
    for mention in state.landmarks:
        candidate_homes = {state.places.home(c) for c in mention.candidates}
        for home in candidate_homes:
            homes[home] += 4 // len(candidate_homes) if len(candidate_homes) < 4 else 1
    chosen: dict[int, int] = {}
    for mention in state.landmarks:
        fit = max(
            range(len(mention.candidates)),
            key=lambda k: (
                homes[state.places.home(mention.candidates[k])],
                _names_its_kind(state, mention, mention.candidates[k]),
                -k,
            ),
        )
        chosen[mention.first] = mention.candidates[fit]
    return chosen


def _names_its_kind(state: TextReading, mention: LandmarkMention, position: int) -> bool:
    amenity = state.city.landmarks[position].properties.get("amenity")
    return any(w.low == amenity for w in state.words[mention.first : mention.last])


def to_description(state: TextReading) -> Description:
    """Return what was read as a frozen value with character spans."""
    relations: dict[tuple[str, str, tuple[str, ...], bool], SpatialRelation] = {}
    for one in state.reading.attached:
        for relation in _relations(state, one):
            key = relation.figure, relation.relation, relation.grounds, relation.negated
            relations.setdefault(key, relation)
    return Description(
        text=state.text,
        map=state.city.name,
        targets=state.targets,
        relations=tuple(relations.values()),
        unresolved=_unresolved(state),
    )


def _relations(state: TextReading, one: Attached) -> list[SpatialRelation]:
    phrase = one.phrase
    whole = phrase.joint or phrase.each
    groups = [phrase.grounds] if whole else [(g,) for g in phrase.grounds]
    return [
        SpatialRelation(
            figure=figure,
            relation=relation,
            grounds=tuple(g.ids[0] for g in grounds),
            negated=phrase.negated,
            distance=phrase.distance,
            confidence=round(one.confidence * min(g.confidence for g in grounds), 3),
            spans=RelationSpans(
                _chars(state.words, *one.span),
                _chars(state.words, *phrase.cue),
                tuple(_chars(state.words, g.first, g.last) for g in grounds),
            ),
            each=phrase.each,
        )
        for figure in one.figures
        for relation in phrase.relations
        for grounds in groups
    ]


def _unresolved(state: TextReading) -> tuple[Unresolved, ...]:
    found: dict[tuple[int, int], Unresolved] = {}
    for ground in state.reading.loose:
        if ground.last <= ground.first:
            continue
        span = _chars(state.words, ground.first, ground.last)
        candidates = ground.candidates
        if not candidates and ground.kind == "unknown":
            candidates = nearest_landmarks(state.text[slice(*span)], state.places.index)
        found[span] = Unresolved(state.text[slice(*span)], span, candidates)
    return tuple(found[s] for s in sorted(found))


def _chars(words: Sequence[Word], first: int, last: int) -> tuple[int, int]:
    return words[first].start, words[last - 1].end
