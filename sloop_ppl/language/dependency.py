"""Run the paper's parsing rule on any spaCy pipeline whose parser has CLEAR labels."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path

import spacy
from spacy.language import Language
from spacy.tokens import Doc

from sloop_ppl.errors import InputError
from sloop_ppl.language.coreference import Figures
from sloop_ppl.language.figures import figure_finder
from sloop_ppl.language.paths import PathRelation, relations_on_paths
from sloop_ppl.language.pipeline import CONTEXT, keep_description
from sloop_ppl.language.place_index import place_index
from sloop_ppl.language.reading import TextReading, find_figures, find_landmarks, settle
from sloop_ppl.language.targets import load_targets
from sloop_ppl.language.values import (
    Description,
    RelationSpans,
    SpatialRelation,
    TargetObject,
)
from sloop_ppl.maps import CityMap, load_map

__all__ = [
    "check_parser",
    "dependency_parser",
    "installed_pipeline",
    "make_dependency_paths",
    "shared_dependency_parser",
]

_Reader = Callable[[str, CityMap, Sequence[TargetObject] | None], Description]

_PIPELINES = ("en_core_web_md", "en_core_web_lg", "en_core_web_sm")
_FIGURE_WORDS = ("car", "bike", "truck")
_GROUND_WORDS = ("Boston", "London", "Paris", "Rome", "Berlin", "Madrid")
_LONGEST = 100_000


def check_parser(nlp: Language) -> None:
    """Raise `InputError` unless a pipeline has a dependency parser with CLEAR labels."""
    name = f"{nlp.lang}_{nlp.meta.get('name') or 'pipeline'}"
    if not nlp.has_pipe("parser"):
        raise InputError(
            f"The spaCy pipeline '{name}' has no dependency parser; the rule dependency_paths "
            "needs one with CLEAR labels, such as en_core_web_md"
        )
    labels = set(nlp.pipe_labels["parser"])
    if not {"pobj", "prep"} <= labels:
        ud = sorted(labels & {"obl", "case", "nmod"})
        what = f"UD labels ({', '.join(ud)})" if ud else "other labels"
        raise InputError(
            f"The parser of the spaCy pipeline '{name}' gives {what}; the rule dependency_paths "
            "follows prep and pobj and needs CLEAR labels, such as those of en_core_web_md"
        )


@Language.factory(
    "dependency_paths",
    default_config={"map": None, "targets": None, "placeholders": True, "every_path": False},
)
def make_dependency_paths(
    nlp: Language,
    name: str,  # noqa: ARG001
    map: str | None,  # noqa: A002
    targets: str | None,
    placeholders: bool,
    every_path: bool,
) -> _Paths:
    """Return the component that reads relations along dependency paths.

    Parameters
    ----------
    nlp
        The pipeline, whose parser stands before this component.
    name
        Given by spaCy.
    map
        Bundled name or path of the map; None when each ``Doc`` brings its own.
    targets
        Path of a targets file; None for the default objects and any others.
    placeholders
        Whether names are replaced by simple words before parsing, which helps small parsers;
        without it the text's own parse is used.
    every_path
        Whether paths into other clauses count, as in the paper to the letter.
    """
    check_parser(nlp)
    city = None if map is None else load_map(map)
    declared = None if targets is None else load_targets(targets)

    return _Paths(nlp, city, declared, placeholders, every_path)


@dataclass
class _Paths:
    """The component: reads relations off the parse of a text."""

    nlp: Language
    city: CityMap | None
    declared: Sequence[TargetObject] | None
    placeholders: bool
    every_path: bool

    def __call__(self, doc: Doc) -> Doc:
        """Set ``doc._.spatial_relations``."""
        given, objects = doc.user_data.pop(CONTEXT, (self.city, self.declared))
        if given is None:
            raise InputError(
                "The component 'dependency_paths' has no map; add it with "
                "config={'map': NAME_OR_PATH}"
            )
        state = _read_names(doc.text, given, objects)
        parsed = _parsed(self.nlp, state) if self.placeholders else _Parsed.of(doc, state)
        keep_description(doc, _description(state, parsed, self.every_path))
        return doc


def _read_names(text: str, city: CityMap, targets: Sequence[TargetObject] | None) -> TextReading:
    """Find the landmarks and the objects that a text names."""
    state = TextReading(text, city, place_index(city), figure_finder(targets))
    find_landmarks(state)
    find_figures(state)
    return state


class _Parsed:
    """A parsed text and where its figures and grounds stand in it."""

    def __init__(self, doc: Doc, spans: Sequence[tuple[int, int]]) -> None:
        self.doc = doc
        self.spans = spans  # token -> character range of the text
        self.figures: dict[int, int] = {}  # token -> number of the mention
        self.grounds: dict[int, int] = {}

    @classmethod
    def of(cls, doc: Doc, state: TextReading) -> _Parsed:
        """Return a text parsed as it stands, the heads of names standing for them."""
        parsed = cls(doc, [(t.idx, t.idx + len(t)) for t in doc])
        figures = [(m.first, m.last) for m in state.figures]
        grounds = [(m.first, m.last) for m in state.landmarks]
        for table, mentions in ((parsed.figures, figures), (parsed.grounds, grounds)):
            for number, (first, last) in enumerate(mentions):
                start, end = state.words[first].start, state.words[last - 1].end
                span = doc.char_span(start, end, alignment_mode="expand")
                if span is not None and len(span):
                    table[span.root.i] = number
        return parsed


def _parsed(nlp: Language, state: TextReading) -> _Parsed:
    """Parse a text whose names are replaced by simple words."""
    figures = {m.first: (n, m) for n, m in enumerate(state.figures)}
    grounds = {m.first: (n, m) for n, m in enumerate(state.landmarks)}
    words: list[str] = []
    spans: list[tuple[int, int]] = []
    named: list[tuple[bool, int, int]] = []
    at = 0
    while at < len(state.words):
        number, mention = figures.get(at) or grounds.get(at) or (0, None)
        if mention is None:
            words.append(
                state.norms[at] if state.words[at].kind == "word" else state.words[at].text
            )
            spans.append((state.words[at].start, state.words[at].end))
            at += 1
            continue
        stock = _FIGURE_WORDS if at in figures else _GROUND_WORDS
        named.append((at in figures, len(words), number))
        words.append(stock[number % len(stock)])
        spans.append((state.words[mention.first].start, state.words[mention.last - 1].end))
        at = mention.last
    parsed_doc = Doc(nlp.vocab, words=words)
    for _, pipe in nlp.pipeline:
        if not isinstance(pipe, _Paths):
            parsed_doc = pipe(parsed_doc)
    parsed = _Parsed(parsed_doc, spans)
    for is_figure, token, number in named:
        (parsed.figures if is_figure else parsed.grounds)[token] = number
    return parsed


def _description(state: TextReading, parsed: _Parsed, every_path: bool) -> Description:
    """Return what stands on the paths as a `Description`."""
    chosen = settle(state)
    figures = Figures(state.finder)
    ids: dict[int, tuple[str, ...]] = {}
    for token, number in sorted(parsed.figures.items()):
        ids[token] = figures.resolve(state.figures[number])
        figures.spoke_of(ids[token])
    relations: dict[tuple[str, str, str], SpatialRelation] = {}
    found = relations_on_paths(
        parsed.doc, sorted(parsed.figures), sorted(parsed.grounds), every_path=every_path
    )
    for path in found:
        mention = state.landmarks[parsed.grounds[path.ground]]
        ground = state.places.id(chosen[mention.first])
        for figure in ids[path.figure]:
            relations.setdefault(
                (figure, path.relation, ground),
                SpatialRelation(
                    figure,
                    path.relation,
                    (ground,),
                    path.negated,
                    confidence=round(min(1.0, 0.4 + 0.5 * mention.score), 3),
                    spans=_spans(parsed, path),
                ),
            )
    return Description(state.text, state.city.name, figures.targets(), tuple(relations.values()))


def _spans(parsed: _Parsed, path: PathRelation) -> RelationSpans:
    cue = [parsed.spans[t] for t in path.cue]
    return RelationSpans(
        parsed.spans[path.figure],
        (min(a for a, _ in cue), max(b for _, b in cue)),
        (parsed.spans[path.ground],),
    )


def installed_pipeline() -> str:
    """Return the name of an installed spaCy pipeline with a CLEAR-label parser.

    Raises
    ------
    InputError
        When none is installed; it says how to give one.
    """
    for name in _PIPELINES:
        if find_spec(name) is not None:
            return name
    raise InputError(
        "The parser 'dependency_paths' needs a spaCy pipeline with a CLEAR-label parser and none "
        f"of {', '.join(_PIPELINES)} is installed; install one, or name one with --nlp"
    )


def dependency_parser(
    pipeline: str | Path | Language | None = None, *, every_path: bool = False
) -> _Reader:
    """Return a parser that follows the paper's rule on a spaCy pipeline.

    Parameters
    ----------
    pipeline
        A pipeline, or the name or folder of one; None for an installed one.
    every_path
        Whether paths into other clauses count, as in the paper to the letter.

    Raises
    ------
    InputError
        When it cannot be loaded, or its parser is missing or has other labels.
    """
    nlp = pipeline if isinstance(pipeline, Language) else _load(pipeline or installed_pipeline())
    check_parser(nlp)

    def read(text: str, city: CityMap, targets: Sequence[TargetObject] | None) -> Description:
        if len(text) > _LONGEST:
            return Description(text, city.name, (), ())
        state = _read_names(text, city, targets)
        return _description(state, _parsed(nlp, state), every_path)

    return read


@lru_cache(maxsize=1)
def shared_dependency_parser() -> _Reader:
    """Return the parser on an installed pipeline; the parser ``dependency_paths`` by name."""
    return dependency_parser()


def _load(pipeline: str | Path) -> Language:
    try:
        return spacy.load(pipeline)
    except (OSError, ValueError, ImportError) as error:
        raise InputError(
            f"The spaCy pipeline '{pipeline}' cannot be loaded: "
            f"{str(error).splitlines()[0].split('. ')[0]}"
        ) from error
