"""Find which of the offered answers some words mean."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

__all__ = ["Choice", "chosen"]

_UNKNOWING = re.compile(
    r"(?:i\s+)?(?:really\s+)?(?:do\s*n[o']?t|don[’']t|dont|can[’']?t|cannot|could\s*n[o']t)\s+"
    r"(?:know|remember|recall|say|tell)\b.*|no idea.*|not sure.*|(?:i\s+)?dunno.*|unsure|"
    r"i have no idea.*|no clue.*|(?:i['’]m|i am) not sure.*|\?+|unknown|skip|pass",
    re.DOTALL,
)
_YES = ("yes", "yeah", "yep", "yup", "right", "correct", "exactly", "true", "i do", "sure")
_NO = ("no", "nope", "nah", "wrong", "false", "i do not", "i don't", "not at all")
_NEITHER = ("neither", "neither of them", "neither of these", "none", "none of them",
            "none of these", "none of those", "another", "another one", "other", "some other",
            "a different one", "somewhere else")  # fmt: skip
_OTHERS = ("none of these", "another one")
_FILLER = re.compile(
    r"^(?:well|um+|uh+|oh|hmm+|i think|i believe|i guess|probably|maybe|perhaps|it is|it's|"
    r"it’s|that is|that's|i am|i'm|i mean|on|in|at|to|the|it|is|by|a|an|its)\s+|"
    r"\s+(?:of it|side|of them|one|please|i think|i guess)$"
)
_EMPHASIS = frozenset(
    ("definitely", "certainly", "surely", "clearly", "nearer", "closer", "nearest", "close", "near",
     "more", "rather", "mostly", "mainly", "slightly", "roughly", "about", "just", "to", "the",
     "is", "it", "its", "side", "end", "part", "one", "i", "think", "guess", "believe", "maybe",
     "probably", "of", "them")
)  # fmt: skip


class Choice(NamedTuple):
    """Which answer some words mean.

    Attributes
    ----------
    kind
        ``"option"``, ``"not"`` (it is not that option), ``"other"`` (one that is understood but not
        offered), or ``"unknown"`` ("I don't know").
    place
        Position of the option, or of the other answer.
    rest
        Words that say more than the choice; may be empty.
    """

    kind: str
    place: int = 0
    rest: str = ""


def chosen(text: str, options: Sequence[str], others: Sequence[str] = ()) -> Choice | None:
    """Return what an answer chooses; None when it chooses nothing.

    Parameters
    ----------
    text
        The answer.
    options
        The answers that were offered.
    others
        Answers that are understood as well.

    Examples
    --------
    >>> chosen("on the north side", ("north", "south"))
    Choice(kind='option', place=0, rest='')
    >>> chosen("no idea", ("north", "south")).kind
    'unknown'
    """
    words = _plain(text)
    if _UNKNOWING.fullmatch(words):
        return Choice("unknown")
    known = [_plain(option) for option in options]
    found = _whole(words, known, [_plain(other) for other in others])
    if found is not None:
        return found
    parts = re.split(r"\s*(?:[,;.]| and | but )\s*", words, maxsplit=1)
    if len(parts) == 2 and parts[0]:
        first = _whole(parts[0], known, [_plain(other) for other in others])
        if first is not None:
            # In the words as they were written, so that names keep their capitals.
            at = text.casefold().find(parts[1].casefold())
            return first._replace(rest=text[at:].strip() if at >= 0 else parts[1])
    return None


def _whole(words: str, options: Sequence[str], others: Sequence[str]) -> Choice | None:
    """Return what words choose, taken as a whole."""
    bare = _bare(words)
    for form in dict.fromkeys((words, bare)):
        if form in options:
            return Choice("option", options.index(form))
        if form.isdigit() and 1 <= int(form) <= len(options):
            return Choice("option", int(form) - 1)
        if options[:2] == ["yes", "no"] and form in (*_YES, *_NO):
            return Choice("option", 0 if form in _YES else 1)
        if form in others:
            return Choice("other", others.index(form))
        if form in _NEITHER:
            place = next((i for i, o in enumerate(options) if o in _OTHERS), None)
            if place is not None:
                return Choice("option", place)
            return (
                Choice("other", others.index("neither"))
                if "neither" in others
                else Choice("unknown")
            )
    if bare.startswith("not ") and (inner := _whole(bare[4:], options, ())) is not None:
        return Choice("not", inner.place) if inner.kind == "option" else None
    bare_options = [_bare(option) for option in options]
    if bare in bare_options and bare_options.count(bare) == 1:
        return Choice("option", bare_options.index(bare))
    # "nearer to Ivy", "Ivy, definitely": one option's words and nothing of another's.
    held = [i for i, option in enumerate(bare_options) if _holds(bare, option)]
    longest = [i for i in held if not any(_holds(bare_options[j], bare_options[i])
                                          for j in held if j != i)]  # fmt: skip
    # "the tower" of "Chase Bank Tower": a part of one option's words and of no other's.
    own = set(bare.split())
    parts = [i for i, option in enumerate(bare_options) if own and own <= set(option.split())]
    if len(parts) == 1 and not held:
        return Choice("option", parts[0])
    # Nothing but emphasis round it: "south of the church" is a sentence of its own.
    rest = set(bare.split()).difference(*(bare_options[i].split() for i in longest[:1]))
    if len(longest) == 1 and rest <= _EMPHASIS:
        return Choice("option", longest[0])
    return None


def _holds(text: str, words: str) -> bool:
    return bool(words) and re.search(rf"(?<!\w){re.escape(words)}(?!\w)", text) is not None


def _plain(text: str) -> str:
    return " ".join(text.casefold().strip(" \t\n.!,;").split())


def _bare(text: str) -> str:
    """Return words without what is put round an answer."""
    while True:
        shorter = _FILLER.sub("", text)
        if shorter == text:
            return text
        text = shorter
