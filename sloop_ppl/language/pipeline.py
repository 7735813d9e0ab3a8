"""The spaCy pipeline: four registered components that run the rule parser's steps on a text.

Importing this module imports spaCy; `sloop_ppl.parse` runs the same steps without it
(`sloop_ppl.language.rules`). The components are

``sloop_landmarks``   words that name places of the map
``sloop_targets``     words that name objects
``sloop_cues``        relation cues and the small words around them
``sloop_attachment``  which relation locates which object; sets ``doc._.spatial_relations``
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import spacy
from spacy.language import Language
from spacy.tokens import Doc
from spacy.util import registry
from spacy.vocab import Vocab

from sloop_ppl.errors import InputError
from sloop_ppl.language.reading import TextReading
from sloop_ppl.language.rules import STEPS, begin, encodable
from sloop_ppl.language.targets import load_targets
from sloop_ppl.language.values import Description, SpatialRelation
from sloop_ppl.language.words import split_words
from sloop_ppl.maps import load_map

__all__ = ["COMPONENTS", "WordTokenizer", "load_pipeline"]

COMPONENTS: Final = tuple(STEPS)
"""The factories of the rule parser, in the order they run."""

STATE = "sloop_reading"
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
    declared = None if targets is None else load_targets(targets)

    def landmarks(doc: Doc) -> Doc:
        given, objects = doc.user_data.pop(CONTEXT, (city, declared))
        if given is None:
            raise InputError(
                "The component 'sloop_landmarks' has no map; add it with "
                "config={'map': NAME_OR_PATH}, or read texts with sloop_ppl.parse"
            )
        state = begin(doc.text, given, objects)
        doc.user_data[STATE] = state
        STEPS["sloop_landmarks"](state)
        return doc

    return landmarks


@Language.factory("sloop_targets")
def make_targets(nlp: Language, name: str) -> Component:  # noqa: ARG001
    """Return the component that finds the objects spoken of."""
    return _step("sloop_targets", name)


@Language.factory("sloop_cues")
def make_cues(nlp: Language, name: str) -> Component:  # noqa: ARG001
    """Return the component that finds relation cues."""
    return _step("sloop_cues", name)


@Language.factory("sloop_attachment", assigns=["doc._.spatial_relations"])
def make_attachment(nlp: Language, name: str) -> Component:  # noqa: ARG001
    """Return the component that attaches relations to objects."""
    return _step("sloop_attachment", name)


def _step(step: str, name: str) -> Component:
    run = STEPS[step]

    def component(doc: Doc) -> Doc:
        state: TextReading | None = doc.user_data.get(STATE)
        if state is None:
            raise InputError(
                f"The component '{name}' found no landmarks read; add 'sloop_landmarks' before it"
            )
        run(state)
        return doc

    return component


def _relations(doc: Doc) -> tuple[SpatialRelation, ...]:
    description = _description(doc)
    return () if description is None else description.relations


def _description(doc: Doc) -> Description | None:
    state = doc.user_data.get(STATE)
    return None if state is None or state.description is None else state.description.placed(None)


if not Doc.has_extension("spatial_relations"):
    Doc.set_extension("spatial_relations", getter=_relations)
    Doc.set_extension("sloop_description", getter=_description)


def load_pipeline(map: str | None = None, targets: str | None = None) -> Language:  # noqa: A002
    """Return a spaCy pipeline that reads spatial relations, without trained weights.

    Parameters
    ----------
    map
        Bundled name or path of the map; None when each ``Doc`` brings its own.
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
    nlp.add_pipe(COMPONENTS[0], config={"map": map, "targets": targets})
    for component in COMPONENTS[1:]:
        nlp.add_pipe(component)
    return nlp
