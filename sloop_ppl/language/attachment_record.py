"""Keep the book of which relations locate which objects, and settle what is not plain."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

from sloop_ppl.language._assertion import Assertion
from sloop_ppl.language.coreference import Figures
from sloop_ppl.language.grounds import Ground, GroundReader
from sloop_ppl.language.kinds import is_kind_noun
from sloop_ppl.language.lexicon import lexicon
from sloop_ppl.language.phrases import RelationPhrase
from sloop_ppl.language.relations import RELATIONS
from sloop_ppl.language.values import HEARER, NOT_ON_MAP, SPEAKER, Candidate, Status

_HEARERS = frozenset(("you", "your", "yourself", "you're"))

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
    status
        Why it is not asserted; None for what is asserted or denied.
    either
        Group and branch, for one of several alternatives.
    """

    figures: tuple[str, ...]
    span: tuple[int, int]
    phrase: RelationPhrase
    confidence: float = 1.0
    status: Status | None = None
    either: tuple[int, int] | None = None


@dataclass
class Attachments:
    """What a text says, in words and ids.

    Parameters
    ----------
    attached
        Relation phrases with their objects.
    loose
        Half-open ranges of words that were understood but found no home, with candidates.
    aside
        Phrases that locate no target, with why.
    """

    attached: list[Attached] = field(default_factory=list)
    loose: list[Ground] = field(default_factory=list)
    aside: list[tuple[RelationPhrase, Status]] = field(default_factory=list)


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
    assertions
        What each word is: asserted, denied, asked, or held before.
    sentence
        Where this sentence's relations begin.
    """

    reader: GroundReader
    figures: Figures
    assertions: Sequence[Assertion]
    reading: Attachments = field(default_factory=Attachments)
    sentence: int = 0
    groups: int = 0

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

    def set_aside(self, phrase: RelationPhrase, status: Status) -> None:
        """Report a phrase that locates no target."""
        self.reading.aside.append((phrase, status))

    def retract(self, phrase: RelationPhrase) -> None:
        """Take back the last relation, and those of its sentence that `phrase` replaces too."""
        attached = self.attached
        classes = {RELATIONS[r].relation_class for r in phrase.relations}
        for k in range(len(attached) - 1, -1, -1):
            same = {RELATIONS[r].relation_class for r in attached[k].phrase.relations} & classes
            last = k == len(attached) - 1
            if last or (
                same and attached[k].figures == attached[-1].figures and k >= self.sentence
            ):
                attached[k] = replace(attached[k], status="retracted")

    def alternate(self) -> None:
        """Make the last two relations branches of one alternative."""
        attached = self.attached
        if len(attached) < 2 or any(a.phrase.negated or a.status for a in attached[-2:]):
            return
        before, after = attached[-2:]
        if before.figures != after.figures:
            return
        group, branch = before.either or (self.groups, 0)
        if before.either is None:
            self.groups += 1
        attached[-2] = replace(before, either=(group, branch))
        attached[-1] = replace(after, either=(group, branch + 1))

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
        assertion = (
            self.assertions[phrase.cue[0]] if phrase.cue[0] < len(self.assertions) else "asserted"
        )
        if assertion == "denied":
            phrase = replace(phrase, negated=True)
        status = assertion if assertion in ("asked", "past", "other") else None
        at_large = phrase.negated and not phrase.joint
        any_of = tuple(g for g in phrase.grounds if at_large and len(g.every) > 1)
        framed = any(RELATIONS[r].needs_frame for r in phrase.relations)
        grounds = tuple(
            # "On your left": no one knows which way who listens faces.
            g if framed and g.kind == "robot" else self._target_ground(g, ids)
            for g in phrase.grounds
        )
        phrase = replace(phrase, grounds=grounds)
        known = tuple(
            g
            for g in phrase.grounds
            if g.kind in ("landmark", "map", "figure") and g.ids and g not in any_of
        )
        self.reading.loose += [g for g in phrase.grounds if g not in (*known, *any_of)]
        if known:
            grounded = replace(phrase, grounds=known, joint=phrase.joint and len(known) > 1)
            self.attached.append(Attached(ids, span, grounded, confidence, status))
        for ground in any_of:
            every = tuple(
                replace(ground, kind="landmark", ids=(one,), confidence=0.8) for one in ground.every
            )
            grounded = replace(phrase, grounds=every, joint=False, each=True)
            self.attached.append(Attached(ids, span, grounded, confidence, status))

    def _target_ground(self, ground: Ground, ids: tuple[str, ...]) -> Ground:
        """Return a ground that is another target with its id, one of none as unknown."""
        if ground.kind == "robot":
            words = {w.low for w in self.reader.words[ground.first : ground.last]}
            if words & {"me", "us", "my", "our", "here"} and SPEAKER not in ids:
                return replace(ground, kind="figure", ids=(SPEAKER,))
            return replace(ground, kind="landmark", ids=(HEARER,)) if words & _HEARERS else ground
        if ground.kind == "unknown" and ids == (SPEAKER,) and ground.candidates:
            first = ground.candidates[0].ground or NOT_ON_MAP  # any of a kind: it is the goal's own
            return replace(ground, kind="landmark", ids=(first,), mention=ground.first)
        if ground.kind == "unknown" and ids == (SPEAKER,) and self._names(ground):
            # Who says where he is speaks of a place, though the map does not hold it.
            return replace(
                ground,
                kind="landmark",
                ids=(NOT_ON_MAP,),
                candidates=(Candidate(None, 1.0),),
                mention=ground.first,
            )
        if ground.kind != "figure":
            return ground
        found = tuple(i for i in self.figures.known(ground.ids) if i not in ids)
        self.figures.referred_to(found)
        return replace(ground, kind="figure" if found else "unknown", ids=found)

    def _names(self, ground: Ground) -> bool:
        """Whether words are a name or a kind of place, rather than a time or a part of a place."""
        words = self.reader.words[ground.first : ground.last]
        if not words or not words[-1].low.isalpha():
            return False
        named = all(w.text[:1].isupper() for w in words if w.kind == "word")
        return (
            words[-1].low == "block"
            or is_kind_noun(words[-1].low)
            or (named and words[-1].low not in lexicon().closed)
        )

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
