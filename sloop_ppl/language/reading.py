"""Read a text on a map: the rule parser's steps, from words to a `Description`."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from sloop_ppl.language._assertion import assertions
from sloop_ppl.language._confidence import (
    PhraseContext,
    confidence,
    phrase_features,
    readings_of,
)
from sloop_ppl.language._objects import find_objects, find_speaker, own_cars
from sloop_ppl.language._part_reading import NamedText, Slot, read_parts
from sloop_ppl.language._place_phrases import find_places
from sloop_ppl.language.attachment import attach
from sloop_ppl.language.attachment_record import Attached, Attachments
from sloop_ppl.language.chunks import read_chunks
from sloop_ppl.language.coreference import Figures
from sloop_ppl.language.figures import FigureFinder, FigureMention
from sloop_ppl.language.grounds import Ground, GroundReader
from sloop_ppl.language.items import Chunk
from sloop_ppl.language.lexicon import lexicon
from sloop_ppl.language.linking import LandmarkMention, link_landmarks
from sloop_ppl.language.nearest import nearest_landmarks
from sloop_ppl.language.phrases import RelationPhrase
from sloop_ppl.language.place_index import PlaceIndex
from sloop_ppl.language.spelling import mend, split_run_ons
from sloop_ppl.language.street_parts import StreetPart
from sloop_ppl.language.targets import DEFAULT_TARGETS
from sloop_ppl.language.values import (
    NOT_ON_MAP,
    SPEAKER,
    Description,
    RelationSpans,
    SpatialRelation,
    Status,
    TargetObject,
    Unresolved,
)
from sloop_ppl.language.word_roles import find_roles
from sloop_ppl.language.words import Word, split_words
from sloop_ppl.maps import CityMap

__all__ = ["TextReading", "find_cues", "find_figures", "find_landmarks", "relate", "to_description"]


_DICTATED = {
    ("question", "mark"): "?",
    ("full", "stop"): ".",
    ("exclamation", "mark"): "!",
    ("exclamation", "point"): "!",
}
"""Marks as they are dictated."""


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
    inferred
        The objects that no one declared.
    features
        Of each relation in the order of the description, the features of its confidence.
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
    inferred: tuple[TargetObject, ...] = ()
    targets: tuple[TargetObject, ...] = ()
    grounds: Sequence[Ground] = ()
    features: Sequence[tuple[float, ...]] = ()
    description: Description | None = None


def find_landmarks(state: TextReading) -> None:
    """Cut the text into words and link those that name places."""
    vocabulary = state.places.index.vocabulary
    words = split_run_ons(
        _spoken_marks(split_words(state.text)), vocabulary.keys() | state.finder.vocabulary
    )
    state.words = words
    state.landmarks = link_landmarks(words, state.places.index)


def _spoken_marks(words: list[Word]) -> list[Word]:
    """Return words with marks that were dictated ("question mark", "full stop") as marks."""
    found: list[Word] = []
    for word in words:
        mark = _DICTATED.get((found[-1].low, word.low)) if found else None
        if mark is None:
            found.append(word)
        else:
            found[-1] = replace(found[-1], text=mark, low=mark, end=word.end, kind="mark")
    return found


def find_figures(state: TextReading) -> None:
    """Mend the spelling of the other words and find the objects among them."""
    taken = [False] * len(state.words)
    for mention in state.landmarks:
        taken[mention.first : mention.last] = [True] * (mention.last - mention.first)
    vocabulary = state.finder.vocabulary
    slang = lexicon().slang
    state.norms = [
        w.low if t or w.kind != "word" else slang.get(w.text) or _mended(w.low, vocabulary)
        for w, t in zip(state.words, taken, strict=True)
    ]
    kinds = find_places(
        state.norms,
        taken,
        find_roles(state.words),
        vocabulary,
        anywhere=state.finder.declared is not None,
    )
    for kind in kinds:
        if kind.last - kind.first > 1 or state.norms[kind.first] not in vocabulary:
            taken[kind.first : kind.last] = [True] * (kind.last - kind.first)
    figures = state.finder.find(state.norms, taken)
    if state.finder.declared is None:
        figures = own_cars(state.norms, figures)
        objects = find_objects(state.words, state.norms, taken, figures)
        figures, state.inferred = list(objects.mentions), objects.inferred
    speaker = find_speaker(state.norms, taken)
    if speaker and not any(t.id == SPEAKER for t in state.finder.known):
        state.inferred = (*state.inferred, TargetObject(SPEAKER))
    state.figures = sorted((*figures, *speaker), key=lambda m: m.first)
    owned = {w for m in state.figures for w in range(m.first, m.last)}
    state.kinds = [k for k in kinds if k.first not in owned]


def _mended(low: str, vocabulary: frozenset[str]) -> str:
    """Return a word with its spelling mended; verbs, persons and such are spelt as they are."""
    known = lexicon()
    if any(low in known.words_of(role) for role in ("ordinary_verbs", "kin", "adverbs", "times")):
        return low
    return mend(low, vocabulary)


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
    for target in state.inferred:
        figures.infer(target)
    if state.finder.declared is None:
        default = {t.id for t in DEFAULT_TARGETS}
        for mention in state.figures:
            for one in mention.candidates:
                if one not in default:
                    figures.infer(_inferred(one, mention, state))
    asserted = assertions(state.words, state.chunks)
    state.reading = attach(reader, figures, asserted)
    located = {f for one in state.reading.attached for f in one.figures}
    located |= {
        i
        for a in state.reading.attached
        for g in a.phrase.grounds
        if g.kind == "figure"
        for i in g.ids
    }
    inferred = {t.id for t in state.inferred}
    state.targets = tuple(t for t in figures.targets() if t.id in located or t.id not in inferred)
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
    found: dict[tuple[str, str, tuple[str, ...], bool], tuple[SpatialRelation, Attached]] = {}
    aside: dict[tuple[int, int], Unresolved] = {}
    held = [a for a in state.reading.attached if a.status is None]
    located = {f for a in held for f in a.figures}
    groups = 1 + max((a.either[0] for a in held if a.either), default=-1)
    parts = _parts(state, held)
    for index, one in enumerate(held):
        relations = _relations(state, one, index, parts)
        if one.either is None and _is_choice(state, one):
            relations, groups = _choice(relations, groups), groups + 1
        for relation in relations:
            nowhere = NOT_ON_MAP in relation.grounds and relation.figure != SPEAKER
            if nowhere or (SPEAKER in relation.grounds and SPEAKER not in located):
                if nowhere:
                    for ground in one.phrase.grounds:
                        span = _chars(state.words, ground.first, ground.last)
                        aside.setdefault(span, Unresolved(state.text[slice(*span)], span))
                else:
                    _add_aside(state, one.phrase, "other", aside)
                continue
            key = relation.figure, relation.relation, relation.grounds, relation.negated
            first, phrase = found.setdefault(key, (relation, one))
            if first.part is None and relation.part is not None:  # said again with its part
                found[key] = replace(first, part=relation.part), phrase
    unresolved = _unresolved(state, aside)
    read = list(found.values())
    around = _Surroundings(state, len(unresolved), len(read))
    state.features = [phrase_features(relation, around.of(one)) for relation, one in read]
    readings = readings_of([r for r, _ in read], [confidence(f) for f in state.features])
    return Description(
        text=state.text,
        map=state.city.name,
        targets=state.targets,
        relations=readings[0].relations,
        unresolved=unresolved,
        readings=readings if read else (),
    )


class _Surroundings:
    """What surrounds the phrases of a text, as far as it tells how probably they were misread."""

    def __init__(self, state: TextReading, aside: int, relations: int) -> None:
        self.state = state
        self.aside, self.relations = aside, relations
        self.stops = [0, *(c.first for c in state.chunks if c.kind == "stop"), len(state.words)]
        known = lexicon().words_of("adverbs") | lexicon().words_of("ordinary_verbs")
        unread = [c.first for c in state.chunks if c.kind == "word" and c.value not in known]
        self.unread = unread  # words that nothing was made of, in order
        self.named = {w for m in state.landmarks for w in range(m.first, m.last)}
        self.inferred = {t.id for t in state.inferred}

    def of(self, one: Attached) -> PhraseContext:
        """Return what surrounds one phrase."""
        end = bisect_right(self.stops, one.phrase.cue[0])
        first, last = self.stops[end - 1], self.stops[min(end, len(self.stops) - 1)]
        unread = bisect_left(self.unread, last) - bisect_left(self.unread, first)
        grounds = one.phrase.grounds
        words = [self.state.words[g.last - 1].low for g in grounds]
        return PhraseContext(
            attachment=one.confidence,
            ground=min(g.confidence for g in grounds),
            named=all(any(w in self.named for w in range(g.first, g.last)) for g in grounds),
            pointed=any(w in lexicon().words_of("pronouns") for w in words),
            target=any(g.kind == "figure" for g in grounds),
            inferred=any(f in self.inferred for f in one.figures),
            relations=self.relations,
            aside=self.aside,
            unread=unread / max(1, last - first),
            sentence=last - first,
        )


def _parts(state: TextReading, held: Sequence[Attached]) -> dict[Slot, StreetPart]:
    """Return the parts of streets that the phrases are about."""
    streets = state.places.streets
    text = NamedText(
        norms=state.norms,
        names=state.landmarks,
        figures=state.figures,
        stops=[c.first for c in state.chunks if c.kind == "stop"],
        ways={first for first, position in settle(state).items() if position in streets},
        way_ids={state.places.id(position) for position in streets},
    )
    return read_parts(held, text)


def _relations(
    state: TextReading, one: Attached, index: int, parts: Mapping[Slot, StreetPart]
) -> list[SpatialRelation]:
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
            either=one.either,
            part=parts.get((index, relation, grounds[0].first)),
            **_referents(grounds, phrase.each),
        )
        for figure in one.figures
        for relation in phrase.relations
        for grounds in groups
    ]


def _referents(grounds: Sequence[Ground], each: bool) -> dict[str, Any]:
    """Return the candidates and mentions of a relation's grounds, unless all are certain."""
    slots = tuple(GroundReader.slot(g) for g in grounds)
    if each or all(len(slot) == 1 and slot[0].ground is not None for slot in slots):
        return {}
    return {"candidates": slots, "mentions": tuple(_number(g) for g in grounds)}


def _number(ground: Ground) -> int:
    """Return the number of a ground's mention; one of its own where none was given."""
    return ground.mention if ground.mention >= 0 else ground.first


def _is_choice(state: TextReading, one: Attached) -> bool:
    """Whether the grounds of a phrase are alternatives: "near Ivy or Rumor"."""
    grounds = one.phrase.grounds
    if one.phrase.negated or one.phrase.joint or one.phrase.each or len(grounds) < 2:
        return False
    between = range(grounds[-2].last, grounds[-1].first)
    return any(state.words[k].low == "or" for k in between)


def _choice(relations: list[SpatialRelation], group: int) -> list[SpatialRelation]:
    """Return relations as branches of one alternative, one branch for each ground."""
    branches = {grounds: k for k, grounds in enumerate(dict.fromkeys(r.grounds for r in relations))}
    return [replace(r, either=(group, branches[r.grounds])) for r in relations]


def _unresolved(
    state: TextReading, found: dict[tuple[int, int], Unresolved]
) -> tuple[Unresolved, ...]:
    for ground in state.reading.loose:
        if ground.last <= ground.first:
            continue
        span = _chars(state.words, ground.first, ground.last)
        candidates = ground.nearest
        if not candidates and ground.kind == "unknown":
            candidates = nearest_landmarks(state.text[slice(*span)], state.places.index)
        found[span] = Unresolved(state.text[slice(*span)], span, candidates)
    for one in state.reading.attached:
        if one.status is not None:
            _add_aside(state, one.phrase, one.status, found)
    for phrase, status in state.reading.aside:
        _add_aside(state, phrase, status, found)
    return tuple(found[s] for s in sorted(found))


def _add_aside(
    state: TextReading,
    phrase: RelationPhrase,
    status: Status,
    found: dict[tuple[int, int], Unresolved],
) -> None:
    """Add a phrase that locates no target to what is unresolved."""
    span = _chars(state.words, phrase.cue[0], max(phrase.last, phrase.cue[0] + 1))
    grounds = tuple(i for g in phrase.grounds for i in g.ids[:1] if i in state.city)
    found.setdefault(span, Unresolved(state.text[slice(*span)], span, grounds, status))


def _chars(words: Sequence[Word], first: int, last: int) -> tuple[int, int]:
    return words[first].start, words[last - 1].end
