"""The spaCy pipeline: four registered components that run the rule parser's steps on a text.

Importing this module imports spaCy; `sloop_ppl.parse` runs the same steps without it
(`sloop_ppl.language.rules`). The components are

``sloop_landmarks``   words that name places of the map
``sloop_targets``     words that name objects
``sloop_cues``        relation cues and the small words around them
``sloop_attachment``  which relation locates which object; sets ``doc._.spatial_relations`` and
                      ``doc._.sloop_description``
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import msgspec
import spacy
from spacy.language import Language
from spacy.tokens import Doc
from spacy.util import registry
from spacy.vocab import Vocab

from sloop_ppl._foreign import ForeignFault, parse_json
from sloop_ppl.errors import InputError
from sloop_ppl.language.figures import FigureMention
from sloop_ppl.language.items import Chunk
from sloop_ppl.language.linking import LandmarkMention
from sloop_ppl.language.reading import TextReading
from sloop_ppl.language.rules import STEPS, begin, encodable
from sloop_ppl.language.targets import load_targets
from sloop_ppl.language.values import Description, SpatialRelation, TargetObject
from sloop_ppl.language.words import split_words
from sloop_ppl.maps import CityMap, from_geojson, load_map, to_geojson

__all__ = ["COMPONENTS", "WordTokenizer", "keep_description", "load_pipeline"]

COMPONENTS: Final = tuple(STEPS)
"""The factories of the rule parser, in the order they run."""

_STATE = "sloop_reading"
_DESCRIPTION = "sloop_description"
CONTEXT = "sloop_context"

Component = Callable[[Doc], Doc]


class WordTokenizer:
    """A tokenizer that is linear in any text and cuts words as the rule parser does.

    spaCy's own tokenizer is quadratic on unspaced punctuation.

    Parameters
    ----------
    vocab
        The vocabulary of the pipeline.
    """

    def __init__(self, vocab: Vocab) -> None:
        self.vocab = vocab

    def __call__(self, text: str) -> Doc:
        """Return the words of `text`; the text of the result is `text`."""
        clean = encodable(text)
        pieces: list[str] = []
        spaces: list[bool] = []
        at = 0
        for word in split_words(clean):
            if word.start > at:
                _add_gap(pieces, spaces, clean[at : word.start])
            pieces.append(clean[word.start : word.end])
            spaces.append(False)
            at = word.end
        if at < len(clean):
            _add_gap(pieces, spaces, clean[at:])
        return Doc(self.vocab, words=pieces, spaces=spaces)

    def to_bytes(self, **_: Any) -> bytes:
        """Return nothing: there is nothing to save."""
        return b""

    def from_bytes(self, _: bytes, **__: Any) -> WordTokenizer:
        """Return self: there is nothing to load."""
        return self

    def to_disk(self, *_: Any, **__: Any) -> None:
        """Save nothing."""

    def from_disk(self, *_: Any, **__: Any) -> WordTokenizer:
        """Return self: there is nothing to load."""
        return self


def _add_gap(pieces: list[str], spaces: list[bool], gap: str) -> None:
    """Add white space: one blank after a word belongs to the word."""
    if pieces and gap[0] == " ":
        spaces[-1] = True
        gap = gap[1:]
    if gap:
        pieces.append(gap)
        spaces.append(False)


@registry.tokenizers("sloop_ppl.words.v1")  # type: ignore[untyped-decorator]
def create_word_tokenizer() -> Callable[[Language], WordTokenizer]:
    """Return what makes the tokenizer of a pipeline."""
    return lambda nlp: WordTokenizer(nlp.vocab)


class _Saved(msgspec.Struct):
    """What `_Landmarks` is saved as."""

    map: dict[str, Any] | None
    targets: tuple[TargetObject, ...] | None


@dataclass
class _Landmarks:
    """The component that links landmarks.

    Parameters
    ----------
    city
        The map; None when each ``Doc`` brings its own.
    declared
        The objects that can be spoken of; None for the default ones and any others.
    """

    city: CityMap | None
    declared: tuple[TargetObject, ...] | None

    def __call__(self, doc: Doc) -> Doc:
        """Begin to read a text, and mark the places it names."""
        city, declared = doc.user_data.pop(CONTEXT, (self.city, self.declared))
        if city is None:
            raise InputError(
                "The component 'sloop_landmarks' has no map; add it with "
                "config={'map': NAME_OR_PATH}, or read texts with sloop_ppl.parse"
            )
        state = begin(doc.text, city, declared)
        doc.user_data[_STATE] = state
        STEPS["sloop_landmarks"](state)
        _mark(doc, state, "sloop_landmarks", state.landmarks, _landmark_label)
        return doc

    def to_bytes(self, **_: Any) -> bytes:
        """Return the map and the declared objects."""
        city = None if self.city is None else to_geojson(self.city)
        return json.dumps({"map": city, "targets": msgspec.to_builtins(self.declared)}).encode()

    def from_bytes(self, data: bytes, **_: Any) -> _Landmarks:
        """Take the map and the declared objects from bytes."""
        try:
            record = msgspec.convert(parse_json(data.decode()), _Saved)
        except (UnicodeDecodeError, ForeignFault, msgspec.ValidationError) as error:
            raise InputError(
                f"The saved component 'sloop_landmarks' cannot be read: {error}; expected what "
                "to_disk wrote"
            ) from error
        self.city = None if record.map is None else from_geojson(record.map)
        self.declared = record.targets
        return self

    def to_disk(self, path: str | Path, **_: Any) -> None:
        """Write the map and the declared objects to a file."""
        Path(path).write_bytes(self.to_bytes())

    def from_disk(self, path: str | Path, **_: Any) -> _Landmarks:
        """Take the map and the declared objects from a file."""
        return self.from_bytes(Path(path).read_bytes())


@dataclass
class _Step:
    """A component that goes on with a text that `_Landmarks` has begun to read."""

    step: str
    name: str

    def __call__(self, doc: Doc) -> Doc:
        """Do the step, and mark what it found."""
        state: TextReading | None = doc.user_data.get(_STATE)
        if state is None:
            raise InputError(
                f"The component '{self.name}' found no landmarks read; add 'sloop_landmarks' "
                "before it"
            )
        STEPS[self.step](state)
        if self.step == "sloop_targets":
            _mark(doc, state, "sloop_objects", state.figures, _object_label)
            _mark(doc, state, "sloop_kinds", state.kinds, _chunk_label)
        elif self.step == "sloop_cues":
            cues = [c for c in state.chunks if c.kind in ("cue", "dir", "distance")]
            _mark(doc, state, "sloop_cues", cues, _chunk_label)
        elif state.description is not None:  # the reading is done: keep only what can be saved
            keep_description(doc, state.description.placed(None))
            del doc.user_data[_STATE]
        return doc


def _mark(
    doc: Doc,
    state: TextReading,
    group: str,
    found: Sequence[Any],
    label: Callable[[TextReading, Any], tuple[str, str]],
) -> None:
    """Put what was found into ``doc.spans``: a label, and in ``kb_id_`` the id it refers to."""
    spans = []
    for one in found:
        start, end = state.words[one.first].start, state.words[one.last - 1].end
        name, kb_id = label(state, one)
        span = doc.char_span(start, end, label=name, kb_id=kb_id, alignment_mode="expand")
        if span is not None:
            spans.append(span)
    doc.spans[group] = spans


def _landmark_label(state: TextReading, mention: LandmarkMention) -> tuple[str, str]:
    return "LANDMARK", state.places.id(mention.candidates[0])


def _object_label(state: TextReading, mention: FigureMention) -> tuple[str, str]:  # noqa: ARG001
    return "OBJECT", mention.candidates[0] if mention.candidates else ""


def _chunk_label(state: TextReading, chunk: Chunk) -> tuple[str, str]:  # noqa: ARG001
    if chunk.kind == "cue":
        return "RELATION", str(chunk.value.relation)
    if chunk.kind == "dir":
        return "RELATION", str(chunk.value[0])
    return {"distance": ("DISTANCE", ""), "place": ("KIND", str(chunk.value))}[chunk.kind]


@Language.factory("sloop_landmarks", default_config={"map": None, "targets": None})
def make_landmarks(
    nlp: Language,  # noqa: ARG001
    name: str,  # noqa: ARG001
    map: str | None,  # noqa: A002
    targets: str | None,
) -> Component:
    """Return the component that links landmarks.

    Parameters
    ----------
    nlp, name
        Given by spaCy.
    map
        Bundled name or path of the map; None when each ``Doc`` brings its own.
    targets
        Path of a targets file; None for the default objects and any others.
    """
    city = None if map is None else load_map(map)
    return _Landmarks(city, None if targets is None else load_targets(targets))


@Language.factory("sloop_targets")
def make_targets(nlp: Language, name: str) -> Component:  # noqa: ARG001
    """Return the component that finds the objects spoken of."""
    return _Step("sloop_targets", name)


@Language.factory("sloop_cues")
def make_cues(nlp: Language, name: str) -> Component:  # noqa: ARG001
    """Return the component that finds relation cues."""
    return _Step("sloop_cues", name)


@Language.factory("sloop_attachment", assigns=["doc._.spatial_relations"])
def make_attachment(nlp: Language, name: str) -> Component:  # noqa: ARG001
    """Return the component that attaches relations to objects."""
    return _Step("sloop_attachment", name)


def keep_description(doc: Doc, description: Description) -> None:
    """Keep a description with its text, as plain values that ``Doc.to_bytes`` can save."""
    doc.user_data[_DESCRIPTION] = msgspec.to_builtins(description)


def _relations(doc: Doc) -> tuple[SpatialRelation, ...]:
    description = _description(doc)
    return () if description is None else description.relations


def _description(doc: Doc) -> Description | None:
    kept = doc.user_data.get(_DESCRIPTION)
    return None if kept is None else msgspec.convert(kept, Description)


if not Doc.has_extension("spatial_relations"):
    Doc.set_extension("spatial_relations", getter=_relations)
    Doc.set_extension("sloop_description", getter=_description)


def load_pipeline(
    map: str | CityMap | None = None,  # noqa: A002
    targets: str | None = None,
) -> Language:
    """Return a spaCy pipeline that reads spatial relations, without trained weights.

    What it recognises stands in ``doc.spans``: ``sloop_landmarks``, ``sloop_kinds``,
    ``sloop_objects`` and ``sloop_cues``, each span with a label and, in ``kb_id_``, the id of the
    landmark or object, or the canonical relation. It can be pickled, saved, and run in several
    processes.

    Parameters
    ----------
    map
        Bundled name or path of the map, or a map; None when each ``Doc`` brings its own.
    targets
        Path of a targets file; None for the default objects and any others.

    Examples
    --------
    >>> nlp = load_pipeline("cleveland")
    >>> [r.ground for r in nlp("The red bike is behind Velvet Dog")._.spatial_relations]
    ['VelvetDog']
    """
    nlp = spacy.blank("en", config={"nlp": {"tokenizer": {"@tokenizers": "sloop_ppl.words.v1"}}})
    nlp.max_length = 10**9
    name = None if isinstance(map, CityMap) else map
    landmarks = nlp.add_pipe(COMPONENTS[0], config={"map": name, "targets": targets})
    if isinstance(map, CityMap) and isinstance(landmarks, _Landmarks):
        landmarks.city = map
    for component in COMPONENTS[1:]:
        nlp.add_pipe(component)
    return nlp
