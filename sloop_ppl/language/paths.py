"""The paper's parsing rule: relations along the dependency paths from targets to landmarks."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

from spacy.tokens import Doc, Token

from sloop_ppl.language.lexicon import Lexicon, lexicon
from sloop_ppl.language.spelling import mend
from sloop_ppl.language.words import fold

__all__ = ["PathRelation", "relations_on_paths"]

_SUBJECTS = frozenset(("nsubj", "nsubjpass", "expl", "csubj"))
_CLAUSES = frozenset(("conj", "advcl", "ccomp", "parataxis", "relcl", "acl"))
_MODIFIERS = frozenset(("amod", "compound", "advmod", "nmod", "npadvmod"))
_NEGATIONS = frozenset(("not", "n't", "never", "isn't", "aren't"))
_REACH = 200
_FILLERS = frozenset(("the", "a", "an"))


@dataclass(frozen=True, slots=True)
class PathRelation:
    """A relation word on the path from a target to a landmark.

    Parameters
    ----------
    figure, ground
        Positions of their tokens.
    relation
        Canonical relation.
    cue
        Positions of the tokens of the relation word.
    negated
        Whether "not" hangs on the path.
    """

    figure: int
    ground: int
    relation: str
    cue: tuple[int, ...]
    negated: bool = False


def relations_on_paths(
    doc: Doc, figures: Sequence[int], grounds: Sequence[int], *, every_path: bool = False
) -> list[PathRelation]:
    """Return the relations on all dependency paths from figures to grounds.

    Parameters
    ----------
    doc
        A text parsed with CLEAR labels.
    figures, grounds
        Positions of the tokens (the heads) that name targets and landmarks.
    every_path
        Whether paths through other figures and into other clauses count too.

    Returns
    -------
    list of PathRelation
        Of the relation words on a path the one nearest to the ground counts.

    Notes
    -----
    Source: SLOOP, the section on language understanding. Deviations: unless `every_path`, a path
    may not run through another figure it is not coordinated with, nor into a clause that has a
    subject of its own, because such paths relate what the text does not; words are looked up
    in the cue vocabulary rather than by cosine similarity, which means nothing without word
    vectors. Tokens more than 200 words apart are never related, so that time stays linear.
    """
    named = set(figures)
    found: list[PathRelation] = []
    sentence = {i: doc[i].sent.start for i in (*figures, *grounds)}
    order = sorted(grounds)
    for figure in figures:
        near = bisect_left(order, figure - _REACH), bisect_left(order, figure + _REACH)
        for ground in order[slice(*near)]:
            if sentence[figure] != sentence[ground]:
                continue
            path = _path(doc[figure], doc[ground])
            if not every_path and _crosses(path, doc[figure], named):
                continue
            relations = _path_relations(path)
            found += [PathRelation(figure, ground, *relation) for relation in relations]
    return found


def _path(start: Token, end: Token) -> list[Token]:
    """Return the tokens between two tokens of one tree, from the first to the second."""
    up = [start, *start.ancestors]
    down = [end, *end.ancestors]
    places = {token.i: k for k, token in enumerate(up)}
    for k, token in enumerate(down):
        if token.i in places:
            return [*up[1 : places[token.i] + 1], *reversed(down[1:k])]
    return []


def _crosses(path: list[Token], figure: Token, named: set[int]) -> bool:
    """Whether a path runs through another figure or into a clause with its own subject."""
    joined = {figure.i, *(t.i for t in figure.conjuncts)}
    if any(token.i in named and token.i not in joined for token in path):
        return True
    for one, other in pairwise(path):
        lower, upper = (one, other) if one.head == other else (other, one)
        if lower.dep_ not in _CLAUSES:
            continue
        entered = upper if lower == one else lower
        subjects = {c.i for c in entered.children if c.dep_ in _SUBJECTS}
        if subjects and not subjects & joined:
            return True
    return False


def _path_relations(path: list[Token]) -> Iterator[tuple[str, tuple[int, ...], bool]]:
    """Yield (relation, tokens, negated) for the relation words of a path nearest its end."""
    known = lexicon()
    words = [_norm(token) for token in path]
    negated = any(
        child.dep_ == "neg" or child.lower_ in _NEGATIONS for t in path for child in t.children
    )
    for last in range(len(path), 0, -1):
        directions = _directions(path[last - 1])
        if directions:
            for relation in directions:
                yield relation, (path[last - 1].i,), negated
            return
        for first in range(max(0, last - 6), last):
            cue = _bare_cues(known).get(tuple(words[first:last]))
            if cue is None or path[last - 1].dep_ in _SUBJECTS:
                continue
            yield cue[0], tuple(t.i for t in path[first:last]), negated != cue[1]
            return
        if words[last - 1] in known.directions and path[last - 1].dep_ != "conj":
            yield known.directions[words[last - 1]], (path[last - 1].i,), negated
            return


def _directions(token: Token) -> list[str]:
    """Return the directions that qualify a part: "the upper left corner of"."""
    known = lexicon()
    if not {"parts", "junctions"} & known.classes.get(_norm(token), frozenset()):
        return []
    return [
        known.directions[_norm(child)]
        for child in token.children
        if child.dep_ in _MODIFIERS and _norm(child) in known.directions
    ]


@lru_cache(maxsize=1)
def _bare_cues(known: Lexicon) -> Mapping[tuple[str, ...], tuple[str, bool]]:
    """Return the cues without articles, which never lie on a path."""
    bare = {tuple(w for w in form if w not in _FILLERS): cue for form, cue in known.cues.items()}
    return {form: cue for form, cue in bare.items() if form}


def _norm(token: Token) -> str:
    return mend(fold(token.text))
