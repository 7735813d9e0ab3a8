"""Find the kinds of places that a text speaks of: "the parking garage", "a pharmacy"."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from sloop_ppl.language.items import Chunk
from sloop_ppl.language.kinds import is_kind_noun
from sloop_ppl.language.lexicon import lexicon
from sloop_ppl.language.place_index import kind_name
from sloop_ppl.language.word_roles import Roles

__all__ = ["find_places"]

_LONGEST = 3
_DESCRIBING = frozenset((
    "big", "small", "old", "new", "little", "large", "tall", "abandoned", "empty", "main", "local",
    "nearest", "closest", "next", "other", "first", "second", "third", "same", "former", "brick",
    "northern", "southern", "eastern", "western", "northeastern", "northwestern", "southeastern",
    "southwestern", "northernmost", "southernmost", "easternmost", "westernmost",
))  # fmt: skip


def find_places(
    norms: Sequence[str],
    taken: Sequence[bool],
    roles: Roles,
    objects: Collection[str] = (),
    *,
    anywhere: bool = False,
) -> list[Chunk]:
    """Return the kinds of places that are said, the longest phrase first.

    A kind of the everyday list counts wherever it stands; another ("tree", "bench", "kiosk") where
    a place is expected, for elsewhere it may be a thing that is spoken of.

    Parameters
    ----------
    norms
        The words, spelling mended.
    taken
        Whether each word is part of a name.
    roles
        The roles of the words.
    objects
        Words for objects, which alone are no places.
    anywhere
        Whether a kind counts wherever it stands: where all objects are declared, what is no object
        is a place.
    """
    known = lexicon()
    found: list[Chunk] = []
    i = 0
    while i < len(norms):
        step = 1
        for n in range(min(_LONGEST, len(norms) - i), 0, -1):
            if any(taken[i : i + n]):
                continue
            words = tuple(norms[i : i + n])
            listed = words in known.place_phrases
            if not listed and (n == 1 and (words[0] in known.closed or words[0] in objects)):
                continue
            # "parking entrance" is a kind, though an entrance alone is a part of something.
            closed = [known.classes[w] for w in words if w in known.classes]
            open_words = not closed or (n > 1 and all(c == {"parts"} for c in closed))
            plural = open_words and bool(kind_name(words))
            if (
                listed
                or plural
                or (open_words and (anywhere or _expected(norms, i, roles)) and _is_kind(words))
            ):
                found.append(Chunk("place", i, i + n, " ".join(words)))
                step = n
                break
        i += step
    return found


def _is_kind(words: tuple[str, ...]) -> bool:
    plain = all(w.replace("'", "").isalpha() for w in words)
    return plain and len(words[-1]) > 2 and is_kind_noun(" ".join(words))


def _expected(norms: Sequence[str], at: int, roles: Roles) -> bool:
    """Whether a place is expected at a word, or at the words that describe it."""
    known = lexicon()
    first = at
    while (
        first > 0
        and at - first < 3
        and (norms[first - 1] in _DESCRIBING or norms[first - 1] in known.colours)
    ):
        first -= 1
    return roles.placed[first] or roles.placed[at]
