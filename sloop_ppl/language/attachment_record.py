"""Keep the book of which relations locate which objects, and settle what is not plain."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

from sloop_ppl.language.coreference import Figures
from sloop_ppl.language.grounds import Ground, GroundReader
from sloop_ppl.language.phrases import RelationPhrase
from sloop_ppl.language.relations import RELATIONS

__all__ = ["Attached", "AttachmentRecord", "Attachments", "converses"]


@dataclass(frozen=True, slots=True)
class Attached:
    """A relation phrase and the objects it locates.

    Parameters
    ----------
    figures
        Ids of the objects.
    span
        Half-open range of the words that name them.
    phrase
        What is said.
    confidence
        How sure the attachment is, in [0, 1].
    """

    figures: tuple[str, ...]
    span: tuple[int, int]
    phrase: RelationPhrase
    confidence: float = 1.0


@dataclass
class Attachments:
    """What a text says, in words and ids.

    Parameters
    ----------
    attached
        Relation phrases with their objects.
    loose
        Half-open ranges of words that were understood but found no home, with candidates.
    """

    attached: list[Attached] = field(default_factory=list)
    loose: list[Ground] = field(default_factory=list)


@dataclass
class AttachmentRecord:
    """Takes down relations while a text is read.

    Parameters
    ----------
    reader
        The items of the text.
    figures
        The objects spoken of.
    reading
        What has been taken down.
    sentence
        Where this sentence's relations begin.
    """

    reader: GroundReader
    figures: Figures
    reading: Attachments = field(default_factory=Attachments)
    sentence: int = 0

    @property
    def attached(self) -> list[Attached]:
        """All relations so far."""
        return self.reading.attached

    def recent(self, count: int = 8) -> list[Attached]:
        """Return the last relations of this sentence."""
        return self.attached[max(self.sentence, len(self.attached) - count) :]

    def end_sentence(self) -> None:
        """Settle a sentence."""
        self._respectively()
        self.sentence = len(self.attached)

    def lose(self, ground: Ground) -> None:
        """Report something that found no home."""
        self.reading.loose.append(ground)

    def converse(self, phrase: RelationPhrase, places: tuple[Ground, ...]) -> None:
        """Turn "the Dresden is west of the car" round."""
        relations = converses(phrase.relations)
        for ground in phrase.grounds:
            ids = self.figures.known(ground.ids)
            if ids and relations:
                turned = replace(phrase, relations=relations, grounds=places, joint=False)
                self.figures.spoke_of(ids)
                self.give(turned, ids, (ground.first, ground.last), 0.8)

    def give(
        self,
        phrase: RelationPhrase,
        ids: tuple[str, ...],
        span: tuple[int, int],
        confidence: float,
    ) -> None:
        """Attach a phrase, or report it when it has no figure or no ground."""
        if not ids:
            self.reading.loose.append(Ground("cue", *phrase.cue))
            return
        at_large = phrase.negated and not phrase.joint
        any_of = tuple(g for g in phrase.grounds if at_large and len(g.every) > 1)
        known = tuple(
            g for g in phrase.grounds if g.kind in ("landmark", "map") and g.ids and g not in any_of
        )
        self.reading.loose += [g for g in phrase.grounds if g not in (*known, *any_of)]
        if known:
            grounded = replace(phrase, grounds=known, joint=phrase.joint and len(known) > 1)
            self.reading.attached.append(Attached(ids, span, grounded, confidence))
        for ground in any_of:
            every = tuple(
                replace(ground, kind="landmark", ids=(one,), confidence=0.8) for one in ground.every
            )
            grounded = replace(phrase, grounds=every, joint=False, each=True)
            self.reading.attached.append(Attached(ids, span, grounded, confidence))

    def _respectively(self) -> None:
        """Deal places out to objects in order where a sentence says "respectively"."""
        attached = self.attached[self.sentence :]
        positions = range(0)
        if attached:
            positions = range(
                attached[0].span[0], min(len(self.reader.words), attached[-1].phrase.last + 3)
            )
        if not any(self.reader.words[k].low == "respectively" for k in positions):
            return
        dealt: list[Attached] = []
        for one in attached:
            if len(one.figures) == len(one.phrase.grounds) and len(one.figures) > 1:
                dealt += [
                    replace(
                        one, figures=(f,), phrase=replace(one.phrase, grounds=(g,), joint=False)
                    )
                    for f, g in zip(one.figures, one.phrase.grounds, strict=True)
                ]
            else:
                dealt.append(one)
        same = [d for d in dealt if len(d.figures) > 1]
        if len(same) == len(attached) == len(attached[0].figures):
            dealt = [
                replace(d, figures=(f,)) for d, f in zip(same, attached[0].figures, strict=True)
            ]
        self.attached[self.sentence :] = dealt


def converses(relations: Iterable[str]) -> tuple[str, ...]:
    """Return the relations of B to A for those of A to B, as far as they have one."""
    turned = (RELATIONS[relation].converse for relation in relations)
    return tuple(relation for relation in turned if relation is not None)
