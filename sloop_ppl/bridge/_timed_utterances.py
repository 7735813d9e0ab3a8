"""Read what is said later on, such as ``12=it is closer to the bank``, in the light of before."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from sloop_ppl.bridge.facade import parse
from sloop_ppl.errors import InputError
from sloop_ppl.language import Description, RelationSpans, TargetObject, no_relation_found

if TYPE_CHECKING:
    from sloop_ppl.inference import Posterior

__all__ = ["descriptions_of", "follow_up", "read_utterances"]

_TIMED = re.compile(r"\s*(?P<step>-?\d+)\s*=\s*(?P<text>.*\S)\s*", re.DOTALL)


def read_utterances(typed: Sequence[str]) -> dict[int, str]:
    """Return steps taken -> the words that are said then.

    Parameters
    ----------
    typed
        One ``STEP=TEXT`` per utterance.

    Raises
    ------
    InputError
        When one is malformed, its step is negative, or a step is given twice.

    Examples
    --------
    >>> read_utterances(["12=it is closer to the bank"])
    {12: 'it is closer to the bank'}
    """
    utterances: dict[int, str] = {}
    for text in typed:
        match = _TIMED.fullmatch(text)
        if match is None:
            raise InputError(
                f"Words '{text}' are malformed; expected STEP=TEXT, such as "
                "12=it is closer to the bank"
            )
        step = int(match["step"])
        if step < 0:
            raise InputError(
                f"Words for step {step} are given; expected a step of at least 0, before the first"
            )
        if step in utterances:
            raise InputError(f"Words for step {step} are given twice; say all of it at once")
        utterances[step] = match["text"]
    return utterances


def follow_up(posterior: Posterior, text: str, before: Sequence[str] = ()) -> Description:
    """Read a text that goes on from what was said, so that "it" is what was spoken of last.

    Parameters
    ----------
    posterior
        Knows the targets and what was said of them.
    before
        What was said after that and before this.

    Returns
    -------
    Description
        What this text adds; a figure that it names only by "it" has an empty span when the noun
        stands in an earlier text.

    Raises
    ------
    NoRelationFound
        When it says nothing of a target.
    """
    known = {t.id: t for d in posterior.descriptions for t in d.targets}
    targets = tuple(known.get(name, TargetObject(name)) for name in posterior.targets)
    # One text, so that the parser resolves "it"; each part ends its sentence.
    earlier = "".join(f"{t.rstrip(' .!?;,')}. " for t in (*posterior.texts, *before) if t.strip())
    viewpoint = posterior.descriptions[-1].viewpoint if posterior.descriptions else "map"
    hearer = posterior.descriptions[-1].hearer if posterior.descriptions else None
    whole = parse(
        earlier + text, posterior.city, targets=targets, viewpoint=viewpoint, hearer=hearer
    )
    n = len(earlier)
    relations = tuple(
        replace(relation, spans=_moved(relation.spans, n))
        for relation in whole.relations
        if relation.spans is not None and relation.spans.relation[0] >= n
    )
    mentioned = {relation.figure for relation in relations}
    description = Description(
        text,
        whole.map,
        tuple(t for t in targets if t.id in mentioned),
        relations,
        tuple(
            replace(u, span=(u.span[0] - n, u.span[1] - n))
            for u in whole.unresolved
            if u.span[0] >= n
        ),
        viewpoint=viewpoint,
        hearer=hearer,
    )
    if not relations:
        raise no_relation_found(description, posterior.city, targets)
    return description


def descriptions_of(
    posterior: Posterior, utterances: Mapping[int, str | Description]
) -> dict[int, Description]:
    """Return steps taken -> description, in the order in which they are said.

    Raises
    ------
    InputError
        When a step is negative.
    NoRelationFound
        When a text says nothing of a target.
    """
    read: dict[int, Description] = {}
    for step in sorted(utterances):
        if step < 0:
            raise InputError(
                f"Words for step {step} are given; expected a step of at least 0, before the first"
            )
        words = utterances[step]
        if isinstance(words, str):
            words = follow_up(posterior, words, [d.text for d in read.values()])
        read[step] = words
    return read


def _moved(spans: RelationSpans | None, by: int) -> RelationSpans | None:
    if spans is None:
        return None

    def moved(span: tuple[int, int]) -> tuple[int, int]:
        return max(span[0] - by, 0), max(span[1] - by, 0)

    return RelationSpans(
        moved(spans.figure), moved(spans.relation), tuple(moved(s) for s in spans.grounds)
    )
