"""Find the objects that a text speaks of: declared ones, default ones, or any head noun."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from sloop_ppl.language.lexicon import camel_words, lexicon
from sloop_ppl.language.targets import DEFAULT_TARGETS
from sloop_ppl.language.values import TargetObject
from sloop_ppl.language.words import split_words

__all__ = ["FigureFinder", "FigureMention", "figure_finder", "inferred_target"]

_COLOURS = {"grey": "gray", "golden": "gold"}
_ADJECTIVES = frozenset(
    ("small", "big", "large", "little", "old", "new", "parked", "tiny", "huge", "lone", "single")
)


@dataclass(frozen=True, slots=True)
class FigureMention:
    """Words that name one object, or several of a kind.

    Parameters
    ----------
    first, last
        Half-open range of words.
    candidates
        Ids of the objects meant; several when the words do not tell them apart or when all of them
        are meant.
    plural
        Whether all candidates are meant.
    other
        Whether the one that was not spoken of last is meant ("the other car").
    back
        Whether the words only point back ("the red one", "the car").
    """

    first: int
    last: int
    candidates: tuple[str, ...]
    plural: bool = False
    other: bool = False
    back: bool = False


@dataclass
class FigureFinder:
    """Finds mentions of a fixed set of objects.

    Parameters
    ----------
    declared
        The objects that can be spoken of; None for the default ones and any others.
    """

    declared: tuple[TargetObject, ...] | None
    known: tuple[TargetObject, ...] = ()
    vocabulary: frozenset[str] = frozenset()
    _names: dict[str, list[tuple[str, ...]]] = field(default_factory=dict)
    _kinds: dict[str, str | None] = field(default_factory=dict)
    _colours: dict[str, str | None] = field(default_factory=dict)
    _nouns: frozenset[str] = frozenset()

    def __post_init__(self) -> None:
        self.known = DEFAULT_TARGETS if self.declared is None else self.declared
        kinds = lexicon().object_kinds
        for target in self.known:
            words = camel_words(target.id)
            names = [_spelt(n) for n in target.names] or [tuple(words)]
            names.append(tuple(words))
            colour = target.colour or next((w for w in words if w in lexicon().colours), None)
            self._names[target.id] = [n for n in names if n]
            self._colours[target.id] = _plain(colour.lower()) if colour else None
            noun = (target.kind or (words[-1] if words else "")).lower()
            self._kinds[target.id] = kinds.get(noun, noun) or None
        name_words = {w for names in self._names.values() for n in names for w in n}
        self._nouns = (
            frozenset(
                {n[-1] for names in self._names.values() for n in names}
                | {k for k in self._kinds.values() if k and " " not in k}
            )
            - lexicon().colours
        )
        self.vocabulary = frozenset(name_words) | self._nouns

    def find(self, norms: Sequence[str], taken: Sequence[bool]) -> list[FigureMention]:
        """Return the mentions among words that no landmark has taken, in order.

        Parameters
        ----------
        norms
            The words, spelling mended.
        taken
            Whether each word is part of a name or of a kind of place.
        """
        mentions: list[FigureMention] = []
        i = 0
        while i < len(norms):
            if taken[i] or not self._may_start(norms[i]):
                i += 1
                continue
            last = i
            while last < len(norms) and not taken[last] and self._belongs(norms[last], last - i):
                last += 1
                titled = norms[last - 1] in lexicon().words_of("titles")
                if titled and norms[last : last + 1] == ["."]:  # "Mr. Paws"
                    last += 1
                elif norms[last : last + 1] == ["-"] and self._names_go_on(norms, last + 1):
                    last += 1  # "U-Haul"
            mention = self._mention(norms, i, last)
            if mention is None:
                i += 1
            else:
                mentions.append(mention)
                i = mention.last
        return mentions

    def _may_start(self, norm: str) -> bool:
        return norm in ("other", "second") or self._is_name_word(_bare(norm))

    def _is_name_word(self, word: str) -> bool:
        known = lexicon()
        return word in known.colours or word in known.object_kinds or word in self.vocabulary

    def _belongs(self, norm: str, offset: int) -> bool:
        return offset < 8 and (
            norm in _ADJECTIVES
            or norm in ("other", "one", "ones", "second")
            or self._is_name_word(_bare(norm))
        )

    def _mention(self, norms: Sequence[str], first: int, last: int) -> FigureMention | None:
        kinds = lexicon().object_kinds
        words = [_bare(n) for n in norms[first:last]]
        if "." in words or "-" in words:
            return self._titled(words, first)
        other = words[0] in ("other", "second")
        heads = [
            i
            for i, w in enumerate(words)
            if w in kinds or w in self._nouns or (w in ("one", "ones") and i > 0)
        ]
        if not heads:
            return None
        end = _head_end(heads)
        words = words[:end]
        last = first + end
        if not any(w in lexicon().colours for w in words):
            after = _postposed(norms, last)
            if after:
                words, last = [norms[after - 1], *words], after
        plural = words[-1].endswith("s") and words[-1][:-1] in {*kinds, *self._nouns, "one"}
        colour = next((_plain(w) for w in words if w in lexicon().colours), None)
        if words[-1] in ("one", "ones"):
            return FigureMention(first, last, self._coloured(colour), plural, other, back=True)
        found = self._fitting(words, colour)
        lead = norms[first - 1] if first and norms[first - 1] == "my" else ""
        if found and not (lead and colour is None and self.declared is None):
            back = len(found) > 1 and not plural
            return FigureMention(first, last, found, plural, other, back)
        if self.declared is not None:
            return FigureMention(first, last, ())
        return FigureMention(
            first, last, (inferred_target(words, lead).id,), plural=plural, other=other
        )

    def _names_go_on(self, norms: Sequence[str], at: int) -> bool:
        return at < len(norms) and _bare(norms[at]) in self.vocabulary

    def _titled(self, words: list[str], first: int) -> FigureMention | None:
        """Return the mention that "Mr. Paws" makes."""
        named = [w for w in words if w not in (".", "-")]
        found = tuple(
            i for i, names in self._names.items() if any(_within(n, named) for n in names)
        )
        return FigureMention(first, first + len(words), found) if found else None

    def _coloured(self, colour: str | None) -> tuple[str, ...]:
        return tuple(t.id for t in self.known if colour is None or self._colours[t.id] == colour)

    def _fitting(self, words: list[str], colour: str | None) -> tuple[str, ...]:
        """Return the objects that fit best: colour decides, then the longest name, then kind."""
        kinds = lexicon().object_kinds
        mentioned_kinds = {kinds.get(w) or kinds.get(w[:-1]) or w for w in words}
        best: dict[str, int] = {}
        for target in self.known:
            own = self._colours[target.id]
            if colour and own and own != colour:
                continue
            names = max((len(n) for n in self._names[target.id] if _within(n, words)), default=0)
            if not names and self._kinds[target.id] not in mentioned_kinds:
                continue
            if not names and colour and own is None:
                continue
            agree = 10 if colour and own == colour else 0
            best[target.id] = agree + names
        top = max(best.values(), default=0)
        return tuple(i for i, score in best.items() if score == top)


def inferred_target(words: Sequence[str], lead: str = "") -> TargetObject:
    """Return the object that a noun phrase names: CamelCase of colour, modifiers and head noun.

    Parameters
    ----------
    words
        The phrase without its article; sizes and ages are left out.
    lead
        ``"my"`` where it stands for a colour that was not said.

    Examples
    --------
    >>> inferred_target(["dog"], "my").id, inferred_target(["big", "blue", "delivery", "van"]).id
    ('MyDog', 'BlueDeliveryVan')
    """
    noun = words[-1]
    colour = next((w for w in words[:-1] if w in lexicon().colours), None)
    dropped = lexicon().words_of("size_adjectives") | lexicon().colours
    modifiers = [w for w in words[:-1] if w not in dropped and w.isalnum()]
    first = colour or lead
    kind = lexicon().object_kinds.get(noun, noun)
    parts = [p for p in (first, *modifiers, noun) if p]
    phrase = " ".join(parts)
    return TargetObject("".join(map(_camel, parts)), (phrase,), colour, kind)


def _camel(word: str) -> str:
    return word.upper() if word in ("suv", "atm", "rv") else word.capitalize()


_FINDERS: dict[tuple[TargetObject, ...] | None, FigureFinder] = {}


def figure_finder(targets: Sequence[TargetObject] | None) -> FigureFinder:
    """Return the (cached) finder of declared targets, or of the default ones."""
    key = None if targets is None else tuple(targets)
    if key not in _FINDERS:
        if len(_FINDERS) > 64:
            _FINDERS.clear()
        _FINDERS[key] = FigureFinder(key)
    return _FINDERS[key]


def _spelt(name: str) -> tuple[str, ...]:
    """Return a name as words without marks: "U-Haul" is u, haul."""
    return tuple(w.low for w in split_words(name) if w.kind != "mark")


def _bare(norm: str) -> str:
    return norm[:-2] if norm.endswith("'s") else norm


def _plain(colour: str) -> str:
    return _COLOURS.get(colour, colour)


def _head_end(heads: list[int]) -> int:
    """Return where the noun phrase ends: after the first unbroken run of head nouns."""
    end = heads[0] + 1
    while end in heads:
        end += 1
    return end


def _postposed(norms: Sequence[str], at: int) -> int:
    """Return where "that is red" ends when it stands at a word, else 0."""
    if norms[at : at + 1] in (["that's"], ["which's"]):
        at += 1
    elif norms[at : at + 1] in (["that"], ["which"]) and norms[at + 1 : at + 2] in (
        ["is"],
        ["was"],
    ):
        at += 2
    elif norms[at : at + 1] in (["("], [","]) and norms[at + 2 : at + 3] in ([")"], [","]):
        coloured = norms[at + 1] in lexicon().colours
        return at + 2 if coloured else 0
    else:
        return 0
    follows = norms[at + 1] if at + 1 < len(norms) else ""
    coloured = at < len(norms) and norms[at] in lexicon().colours
    return at + 1 if coloured and follows not in lexicon().object_kinds else 0


def _within(name: tuple[str, ...], words: list[str]) -> bool:
    n = len(name)
    return any(tuple(words[i : i + n]) == name for i in range(len(words) - n + 1))
