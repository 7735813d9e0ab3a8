"""Attach relation phrases to the objects they locate, clause by clause."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from sloop_ppl.language._assertion import Assertion, correction_at
from sloop_ppl.language.attachment_record import AttachmentRecord, Attachments, converses
from sloop_ppl.language.coreference import Figures
from sloop_ppl.language.figures import FigureMention, inferred_target
from sloop_ppl.language.grounds import Ground, GroundReader
from sloop_ppl.language.lexicon import lexicon
from sloop_ppl.language.look_ahead import leads_on, named_later, shared
from sloop_ppl.language.phrases import RelationPhrase, read_relation
from sloop_ppl.language.relations import RELATIONS
from sloop_ppl.language.values import HEARER, SPEAKER

__all__ = ["attach"]

_WHENS = ("if", "when", "once", "until", "after", "before", "as", "unless", "while")
_HEDGES = frozenset(("maybe", "perhaps", "possibly", "might", "could", "may"))
_PASSED = {"up", "down", "along", "beyond", "towards", "around", "across"}
_RECENT = 8  # places that a pronoun may pass over
_NEW = ("a", "an", "another", "one", "some")
_PARTS = frozenset((",", ".", ";", "or", "and", "but"))
_RECALLS = frozenset(("guess", "remember", "recall", "right", "mistaken"))
_HEARERS = ("you", "you're", "you've", "we're", "i'm")


@dataclass
class _Clause:
    """State while reading on."""

    figures: tuple[str, ...] = ()
    span: tuple[int, int] = (0, 0)
    named: bool = False  # a figure was named in this sentence
    subject: tuple[Ground, ...] = ()  # landmarks are the subject
    carried: bool = False  # the figure was brought to another place
    acted: bool = False  # something was done before any object was named
    moving: bool = False  # the figure moves: where it passes is not where it is
    seen: tuple[Ground, ...] = ()  # a landmark that someone sees
    seen_at: int = 0  # the item that names it
    topic: Ground | None = None  # a landmark that no cue precedes
    grounds: tuple[Ground, ...] = ()  # such landmarks, joined by "and"
    pending: list[RelationPhrase] = field(default_factory=list)
    route: bool = False
    negated: bool = False
    aside: bool = False  # inside a relative clause about a landmark
    aside_used: bool = False  # that clause has said something
    open: bool = False  # the last thing read was a figure that may still be joined by another


def attach(reader: GroundReader, figures: Figures, asserted: Sequence[Assertion]) -> Attachments:
    """Return which relation phrases locate which objects; linear in the items.

    Parameters
    ----------
    reader
        The items of the text; remembers the places spoken of.
    figures
        The objects spoken of; remembers them.
    asserted
        What each word is: asserted, denied, asked, or held before.
    """
    walk = _Walk(reader, figures, asserted)
    at = 0
    while at < len(reader.chunks):
        at = walk.step(at)
    walk.end_sentence()
    return walk.record.reading


class _Walk:
    """One pass over the items of a text."""

    def __init__(
        self, reader: GroundReader, figures: Figures, asserted: Sequence[Assertion]
    ) -> None:
        self.reader = reader
        self.figures = figures
        self.record = AttachmentRecord(reader, figures, asserted)
        self.clause = _Clause()
        self.lows = [w.low for w in reader.words]
        self.noun_ends = {c.last for c in reader.chunks if c.kind in ("place", "word")}
        self.correcting = 0  # sentences for which a correction still waits for what is right
        self.own_kind = ""  # head of the kind of place that who speaks is at: "the bench"
        self.named_at: dict[str, int] = {}  # object -> word after its last mention
        self.crossing: tuple[Ground, ...] = ()  # streets whose crossing was spoken of last
        self.others: set[tuple[int, int]] = set()  # cues of waiting alternatives
        self.alternative = False  # "or" stands between the last relation and the next

    def step(self, at: int) -> int:
        """Read what begins at an item; return the item after it."""
        corrected = self._correction(at)
        if corrected > at:
            return corrected
        kind = self.reader.kind(at)
        step = getattr(self, f"_on_{kind}", None)
        if step is not None:
            after = int(step(at))
            if after > at:
                return after
        got = read_relation(self.reader, at)
        if got is not None:
            self._phrase(*got, at)
            return max(got[1], at + 1)
        return at + 1

    def _correction(self, at: int) -> int:
        """Read "no wait", "I mean", "correction": what follows replaces what was said last."""
        if not self.record.attached or self.record.attached[-1].status == "retracted":
            return at
        first = self.reader.chunks[at].first
        end = correction_at(self.lows, first)
        if end == first:
            return at
        before = self.reader.words[first - 1] if first else None
        parted = before is None or before.kind == "mark" or end - first > 1
        if not parted or (
            self.lows[first] in ("wait", "hold")
            and self.lows[first + 1 : first + 2] in (["for"], ["by"])
        ):
            return at
        self.correcting = 2
        while at < len(self.reader.chunks) and self.reader.chunks[at].first < end:
            if self.reader.kind(at) in ("cue", "dir", "landmark", "figure", "distance"):
                break
            at += 1
        return at

    def _give(
        self, phrase: RelationPhrase, ids: tuple[str, ...], span: tuple[int, int], confidence: float
    ) -> None:
        """Attach a phrase, as a correction or an alternative of the last where it is one."""
        before = len(self.record.attached)
        if self.correcting and before:
            self.record.retract(phrase)
        self.correcting = 0
        if ids == (SPEAKER,) and not phrase.negated and not self.own_kind:
            self._remember_kind(phrase)
        self.record.give(phrase, ids, span, confidence)
        if len(self.record.attached) > before:
            hedged = before > 0 and all(self._hedged(a.phrase) for a in self.record.attached[-2:])
            if before and (self.alternative or (hedged and before >= self.record.sentence)):
                self.record.alternate()
            self.alternative = False

    def _wait(self, phrase: RelationPhrase) -> None:
        """Keep a phrase until its object is named."""
        if self.alternative and self.clause.pending:
            self.others.add(phrase.cue)
        self.alternative = False
        self.clause.pending.append(phrase)

    def _remember_kind(self, phrase: RelationPhrase) -> None:
        """Remember what kind of place "meet me at the bench" names: it is the goal itself."""
        about = phrase.grounds[0]
        contact = all(RELATIONS[r].relation_class == "contact" for r in phrase.relations)
        if contact and about.last in self.noun_ends and about.last > about.first:
            self.own_kind = self.lows[about.last - 1]

    def _is_own(self, first: int, last: int) -> bool:
        """Whether words are the kind of place that who speaks is at, as "the bench" later on."""
        definite = {"the", "this", "that"} & set(self.lows[max(0, first - 2) : last - 1])
        return bool(self.own_kind and definite) and self.lows[last - 1] == self.own_kind

    def _hedged(self, phrase: RelationPhrase) -> bool:
        """Whether "maybe", "could be" and the like stand before a phrase, in its part."""
        first = phrase.cue[0]
        while first > 0 and self.lows[first - 1] not in _PARTS and first > phrase.cue[0] - 8:
            first -= 1
        return any(w in _HEDGES for w in self.lows[first : phrase.cue[0] + 1])

    def end_sentence(self) -> None:
        """Settle what waits for a figure, and forget what holds within a sentence."""
        clause = self.clause
        if clause.pending and clause.acted and clause.figures == (SPEAKER,):
            for phrase in clause.pending:  # "afterwards we can catch a film at ..."
                self.record.set_aside(phrase, "other")
        elif clause.pending and not clause.route:
            for phrase in clause.pending:
                self._give(phrase, self.clause.figures, self.clause.span, 0.7)
        self.record.end_sentence()
        self.correcting = max(0, self.correcting - 1)
        self.clause = _Clause(figures=clause.figures, span=clause.span)

    def _on_stop(self, at: int) -> int:
        self.end_sentence()
        return at + 1

    def _on_comma(self, at: int) -> int:
        self.clause.aside = False
        return at + 1

    def _on_and(self, at: int) -> int:
        return at + 1

    def _on_or(self, at: int) -> int:
        self.alternative = bool(self.record.attached or self.clause.pending)
        return at + 1

    def _on_sub(self, at: int) -> int:
        self.clause.open = self.clause.aside = self.clause.negated = False
        figure = self.reader.past(at + 1, "be", "det", "possessive")
        so_is = self.reader.value(at) == "so" and self.reader.kind(at + 1) == "be"
        if so_is and self.reader.kind(figure) == "figure":  # "so is the red bike"
            self._on_figure(figure)
            self._on_too(figure)
            return figure + 1
        return at + 1

    def _on_but(self, at: int) -> int:
        self.clause.negated = self.clause.aside = False
        word = str(self.reader.value(at))
        if word in ("rather", "instead") and self.reader.chunks[at + 1 : at + 2]:
            following = self.reader.words[self.reader.chunks[at + 1].first].low
            if following in ("than", "of"):
                self.clause.negated = True
                return at + 2
        return at + 1

    def _on_neg(self, at: int) -> int:
        ends = self.reader.kind(at + 1) in ("stop", "end", "comma")
        last = self.record.attached[-1] if self.record.attached else None
        if ends and self.clause.open and last is not None and last.figures != self.clause.figures:
            denied = replace(last.phrase, negated=not last.phrase.negated)  # "..., mine isn't"
            self._give(denied, self.clause.figures, self.clause.span, 0.7)
            self.clause.open = False
            return at + 1
        if self.reader.kind(at + 1) != "only" and self.reader.value(at + 1) != "just":
            self.clause.negated = True
        return at + 1

    def _on_be(self, at: int) -> int:
        word = self.reader.words[self.reader.chunks[at].first].low
        if word in lexicon().copula and self.clause.aside_used:
            self.clause.aside = self.clause.aside_used = False
        return at + 1

    def _on_which(self, at: int) -> int:
        before = at - 2 if self.reader.kind(at - 1) == "comma" else at - 1
        whose = self.reader.value(at) == "whose" and not self._acts(at)
        if self.reader.kind(before) == "landmark" or whose:
            self.clause.aside, self.clause.aside_used = True, False
        elif self.reader.kind(before) == "figure":
            mention: FigureMention = self.reader.chunks[before].value
            chunk = self.reader.chunks[before]
            ids = self.figures.known(mention.candidates)
            if ids and not set(ids) <= set(self.clause.figures):
                self._subject(ids, (chunk.first, chunk.last), joins=False)
        return at + 1

    def _acts(self, at: int) -> bool:
        """Whether a verb stands before "is": "whose front wheel came off is", "whose owner is"."""
        verbs = lexicon().words_of("ordinary_verbs")
        for k in range(at + 1, at + 8):
            if self.reader.kind(k) in ("be", "stop", "end"):
                return False
            if self.reader.value(k) in verbs:
                return True
        return False

    def _on_too(self, at: int) -> int:
        """Read "the green car is too": what was said of another figure holds again."""
        clause = self.clause
        attached = self.record.attached
        if clause.named and clause.open and attached:
            other = [
                a for a in attached[-3:] if a.figures == attached[-1].figures != clause.figures
            ]
            for one in other:
                self._give(one.phrase, clause.figures, clause.span, 0.8)
            clause.open = False
        return at + 1

    def _on_where(self, at: int) -> int:
        """Read "the Dresden is where the red bike is"."""
        place = self.clause.topic or self.reader.last_ground()
        if self.clause.pending:
            return at + 1
        figure = self.reader.past(
            at + 1, "det", "skip", "possessive", "same", "subject", "robot", "see", "be"
        )
        seen = figure > at + 1 and any(self.reader.kind(k) == "see" for k in range(at + 1, figure))
        if self.reader.kind(figure) != "figure" or place is None:
            return at + 1
        after = self.reader.past(figure + 1, "be", "skip")
        if not (seen or after > figure + 1) or read_relation(self.reader, after) is not None:
            return at + 1
        self.clause.subject = ()
        self._on_figure(figure)
        chunk = self.reader.chunks[at]
        phrase = RelationPhrase(("at",), (place,), (chunk.first, chunk.last), chunk.last)
        self._give(phrase, self.clause.figures, self.clause.span, 0.7)
        return after

    def _on_to(self, at: int) -> int:
        """Read "the stage was moved from Ivy to Rumor": it is at the second."""
        clause = self.clause
        if not (clause.carried and clause.named):
            return at
        got = self.reader.read(at + 1)
        if got is None or got[0].kind != "landmark":
            return at
        chunk = self.reader.chunks[at]
        phrase = RelationPhrase(("at",), (got[0],), (chunk.first, chunk.last), got[0].last)
        clause.carried = False
        self._give(phrase, clause.figures, clause.span, 0.8)
        return got[1]

    def _on_route(self, at: int) -> int:
        ours = self.clause.named and self.clause.figures == (SPEAKER,)
        if ours and self.reader.value(at) in ("get", "come", "go"):
            return at + 1  # "let's all get together at"
        if self.reader.kind(at + 1) == "dir" and self._meets(at + 2):
            chunk = self.reader.chunks[at + 1]  # "head east and meet me": east of who listens
            cue = chunk.first, chunk.last
            hearer = Ground("landmark", *cue, (HEARER,))
            phrase = RelationPhrase(tuple(chunk.value), (hearer,), cue, chunk.last)
            self._give(phrase, (SPEAKER,), cue, 0.8)
            return at + 2
        before = self.reader.kind(at - 1)
        if not self.clause.named or before in ("subject", "robot", "to", "sub", "and"):
            self.clause.route = True
            self.clause.pending = []
        return at + 1

    def _meets(self, at: int) -> bool:
        """Whether "and meet me" follows in the sentence."""
        for k in range(at, at + 10):
            if self.reader.kind(k) in ("stop", "end"):
                return False
            if self.reader.kind(k) == "figure":
                return SPEAKER in self.reader.chunks[k].value.candidates
        return False

    def _on_route_ing(self, at: int) -> int:
        moves = self.reader.value(at) != "heading"
        if moves and self.clause.named and self.reader.kind(at + 1) == "dir":
            return at + 2  # "moving east": a way, not a side of the place named last
        if not self.clause.named:
            self.clause.route = True
        return at + 1

    def _on_see(self, at: int) -> int:
        looks = self.reader.value(at) == "look" and self.reader.kind(at - 1) == "robot"
        self.clause.route = self.clause.route and looks
        return at + 1

    def _on_landmark(self, at: int) -> int:
        """Read a place that no cue precedes: the subject of a clause, or part of a route."""
        ground = self.clause.topic = self.reader.landmark(at)
        before = at - 2 if self.reader.kind(at - 1) == "det" else at - 1
        joined = self.reader.kind(before) == "and"
        if self.correcting and self._replaces(ground, at):
            return at + 1
        if self._listed(ground, at):
            return at + 1
        before_it = (
            self.reader.kind(before)
            if self.reader.kind(before) != "skip"
            else self.reader.kind(before - 1)
        )
        if self.alternative and before_it == "or" and self._replaces(ground, at):
            return at + 1
        if self.reader.kind(before) in ("neg", "but") and self._instead(ground, before):
            return at + 1
        if (self.reader.kind(before) == "be" or self._seen(at)) and self._waits_for_place(ground):
            return at + 1
        self.clause.grounds = (*self.clause.grounds[-3:], ground) if joined else (ground,)
        self.clause.seen, self.clause.seen_at = ((ground,), at) if self._seen(at) else ((), at)
        after = self.reader.past(at + 1, "place", "none", "skip", "plural")
        if self.reader.kind(after) == "be" or self.reader.kind(after) == "neg":
            self.clause.subject = self.clause.grounds
            self.clause.open = False
            self.clause.negated = False
        return at + 1

    def _listed(self, ground: Ground, at: int) -> bool:
        """Read "White van: West 4th" and "come to Rumor": the place right after the object."""
        clause = self.clause
        before = at - 1
        parted = False
        while before > at - 6:
            affirms = self.reader.value(before) in ("yes", "yeah", "yep", "definitely", "confirmed")
            if self.reader.kind(before) == "comma":
                parted = True
            elif self.reader.kind(before) not in ("det", "skip") and not affirms:
                break
            before -= 1
        parted = parted and self.reader.kind(before) == "figure"
        reached = self.reader.kind(before) == "to" and self.reader.kind(before - 1) == "figure"
        if not (clause.named and clause.open and (parted or reached)) or clause.route:
            return False
        onward = self.reader.past(at + 1, "place", "none", "skip")
        if self.reader.kind(onward) in ("be", "neg", "which"):
            return False
        chunk = self.reader.chunks[at]
        phrase = RelationPhrase(("at",), (ground,), (chunk.first, chunk.last), chunk.last)
        self._give(phrase, clause.figures, clause.span, 0.7)
        clause.open = False
        return True

    def _replaces(self, ground: Ground, at: int) -> bool:
        """Read "no wait, the Dresden" and "or the Dresden": the last relation, of that place."""
        onward = self.reader.past(at + 1, "place", "none", "skip", "plural")
        if self.reader.kind(onward) in ("be", "cue", "dir") or not self.record.attached:
            return False
        last = self.record.attached[-1]
        phrase = replace(last.phrase, grounds=(ground,), joint=False)
        self._give(phrase, last.figures, last.span, 0.8)
        return True

    def _on_place(self, at: int) -> int:
        """Read a kind of place that no cue precedes: "a school is west of it"."""
        seen = self._seen(at)
        chunk = self.reader.chunks[at]
        onward = self.reader.past(at + 1, "skip", "none")
        if self._is_own(chunk.first, chunk.last) and self.reader.kind(onward) == "be":
            self._subject((SPEAKER,), (chunk.first, chunk.last), joins=False)
            return at + 1
        got = self.reader.read(at)
        if got is None or got[1] <= at:
            return at + 1
        ground, after = got
        onward = self.reader.past(after, "skip", "none")
        before = [self.reader.kind(k) for k in range(at - 3, at)]
        replaces = self.correcting or (self.alternative and "or" in before)
        if replaces and ground.kind == "landmark" and self._replaces(ground, after - 1):
            return after
        if self.clause.pending and (seen or "be" in before) and self._waits_for_place(ground):
            return after
        leads = seen or self.reader.kind(onward) in ("be", "neg") or self._introduced(at, after)
        if leads and not self.clause.pending:
            self.clause.subject, self.clause.topic = (ground,), ground
            self.clause.open = self.clause.negated = False
        elif "be" in (self.reader.kind(at - 1), self.reader.kind(at - 2)) and self.clause.pending:
            self._waits_for_place(ground)
        return after

    def _introduced(self, at: int, after: int) -> bool:
        """Whether a new place opens a sentence: "a bank on this block is to the east"."""
        lead = at - 1
        while self.reader.kind(lead) in ("word", "skip", "figure") and lead > at - 4:
            lead -= 1
        if self.clause.named or self.clause.pending or self.reader.value(lead) not in _NEW:
            return False
        if self.reader.kind(lead - 1) not in ("stop", "end", "and", "comma", "too"):
            return False
        for k in range(after, after + 14):
            if self.reader.kind(k) in ("stop", "end"):
                return False
            if self.reader.kind(k) == "be":
                return True
        return False

    def _seen(self, at: int) -> bool:
        """Whether "there is", "you'll see" or "it has" stands before a place."""
        before = at - 1
        while self.reader.kind(before) in ("det", "skip", "be", "possessive") and before > at - 4:
            if self.reader.kind(before) == "be" and self.reader.value(before) in ("has", "have"):
                return True
            before -= 1
        return self.reader.kind(before) == "see" or self.reader.value(before) == "there"

    def _instead(self, ground: Ground, before: int) -> bool:
        """Read "not the Dresden", "but the Dresden" after a relation: it holds of that place."""
        recent = self.record.recent()
        if not recent or recent[-1].figures != self.clause.figures:
            return False
        denied = self.reader.kind(before) == "neg"
        phrase = replace(recent[-1].phrase, grounds=(ground,), joint=False, negated=denied)
        self._give(phrase, self.clause.figures, self.clause.span, 0.8)
        self.clause.negated = False
        return True

    def _waits_for_place(self, ground: Ground) -> bool:
        """Read "to the east of the red bike is Hoyt Block"."""
        waiting = self.clause.pending
        grounds = [self._spoken_of(p) for p in waiting]
        if not waiting or any(g is None for g in grounds):
            return False
        self.clause.pending = []
        for phrase, about in zip(waiting, grounds, strict=True):
            if about is not None:
                self.record.converse(replace(phrase, grounds=(about,)), (ground,))
        return True

    def _spoken_of(self, phrase: RelationPhrase) -> Ground | None:
        """Return the object that a phrase about a place is relative to: "west of it", "of me"."""
        if not phrase.grounds:
            ids = self.figures.last()
            turns = all(
                RELATIONS[r].is_compass or RELATIONS[r].converse == r for r in phrase.relations
            )
            return Ground("figure", *phrase.cue, ids) if ids and turns else None
        about = phrase.grounds[0]
        if about.kind == "figure":
            return about
        words = self.lows[about.first : about.last]
        if about.kind == "robot":
            mine = any(w in ("me", "us", "my", "our", "here") for w in words)
            return replace(about, kind="figure", ids=(SPEAKER,)) if mine else None
        if words and self._is_own(about.first, about.last):
            return replace(about, kind="figure", ids=(SPEAKER,))
        if (words and words[-1] in ("it", "him", "her", "them")) or phrase.own:
            ids = self.figures.last()
            return replace(about, kind="figure", ids=ids) if ids else None
        return None

    def _on_pronoun(self, at: int) -> int:
        word = str(self.reader.value(at))
        if word == "that's" and self.reader.kind(at + 1) == "where":
            return at + 1
        if word == "there" and self.reader.kind(at + 1) != "be" and self.clause.named:
            self._there(at)
        if word in ("its", "there") or self.reader.kind(at + 1) == "stop":
            return at + 1
        animate = word.removesuffix("'s") in ("he", "she")
        self._refer(self.figures.person() if animate else self.figures.last(), at)
        return at + 1

    def _there(self, at: int) -> None:
        """Read "the red car is there" and "isn't there": the last place that was spoken of."""
        clause = self.clause
        before = self.reader.kind(at - 1)
        if before not in ("be", "neg", "figure", "skip", "too", "only"):
            return
        attached = self.record.attached
        negated, clause.negated = clause.negated, False
        if attached and attached[-1].figures != clause.figures and clause.open and not negated:
            self._give(attached[-1].phrase, clause.figures, clause.span, 0.8)
        elif negated or (clause.open and before in ("be", "figure", "skip")):
            place = self.reader.last_ground()
            if place is None:
                return
            chunk = self.reader.chunks[at]
            cue = chunk.first, chunk.last
            crossing = self.crossing if place in self.crossing else ()
            self._give(
                RelationPhrase(
                    ("at",), crossing or (place,), cue, chunk.last, bool(crossing), negated=negated
                ),
                clause.figures,
                clause.span,
                0.7,
            )
        clause.open = False

    def _on_plural(self, at: int) -> int:
        after = self.reader.past(at + 1, "det", "skip", "of", "same")
        if self.reader.kind(after) in ("figure",):
            return at + 1
        if len(self.clause.figures) > 1 and self.clause.open:
            return at + 1
        if self.reader.kind(after) not in ("be", "neg", "cue", "dir", "to", "plural"):
            return at + 1  # "they keep the red bike in ..."
        self._refer(self.figures.all(), at)
        return at + 1

    def _refer(self, ids: tuple[str, ...], at: int) -> None:
        """Make objects spoken of before the subject again."""
        if ids:
            chunk = self.reader.chunks[at]
            self._subject(ids, (chunk.first, chunk.last), joins=False)

    def _on_figure(self, at: int) -> int:
        chunk = self.reader.chunks[at]
        mention: FigureMention = chunk.value
        before = at - 2 if self.reader.kind(at - 1) == "det" else at - 1
        denied = self.reader.value(before) if self.reader.kind(before) == "neg" else ""
        if denied == "not":
            self.clause.negated = False
            return at + 1
        if (
            mention.back
            and not mention.plural
            and not self.clause.named
            and named_later(self.reader, at)
        ):
            return at + 1
        ids = self.figures.resolve(mention)
        if not ids and mention.candidates and self.figures.open_ended:
            noun = self.reader.norms[chunk.last - 1].removesuffix("'s")
            target = inferred_target([noun])
            self.figures.infer(target)
            ids = (target.id,)
        if not ids:
            self.record.lose(Ground("unknown", chunk.first, chunk.last))
            if self.clause.named and self.clause.figures == (SPEAKER,):
                return at + 1  # "I'm parking my bike at the bank"
        parted = self.reader.kind(before) in ("and", "comma", "or", "too")
        joins = self.clause.open and (parted or self.reader.kind(before) == "figure")
        if SPEAKER in (*ids, *self.clause.figures):  # "my guy, I'm at": not one of a list
            joins = joins and self.reader.kind(before) == "and"
        self._subject(ids, (chunk.first, chunk.last), joins=joins)
        self.clause.negated = denied in ("neither", "nor")
        return at + 1

    def _on_robot(self, at: int) -> int:
        """Pass over what the hearer does: "if you are facing the bank"."""
        onward = self.reader.past(at + 1, "be", "skip")
        cued = self.reader.kind(onward) == "cue" and self.reader.value(at) in _HEARERS
        ahead = {self.reader.value(k) for k in range(at + 1, at + 5)}
        when = self.reader.value(at - 1) in _WHENS and not ahead & _RECALLS
        waits = self.reader.value(at - 1) in ("wait", "meet", "expect", "for", "see")
        cued = cued and not (waits and self.clause.named)
        self.clause.route = self.clause.route or cued or when
        return at

    _on_subject = _on_robot

    def _on_word(self, at: int) -> int:
        """Pass over a word; a verb ends a list of objects: "the man told me my bag is"."""
        word = str(self.reader.value(at))
        if word in ("former", "latter"):
            ids = self.figures.all()
            self._refer(ids[:1] if word == "former" else ids[-1:], at)
        elif word in lexicon().words_of("ordinary_verbs"):
            self.clause.open = False
            self.clause.carried = self.clause.carried or word in lexicon().words_of("carrying")
            self.clause.moving = self.clause.moving or word in lexicon().words_of("motion_verbs")
            self.clause.acted = self.clause.acted or not self.clause.named
        elif not self.figures.open_ended:
            return self._on_unknown(at)
        return at + 1

    def _on_unknown(self, at: int) -> int:
        """Read "there is a kiln to its east": something else is located, that no map holds."""
        end = at
        while self.reader.kind(end) in ("word", "skip"):
            end += 1
        if self.reader.kind(end) == "place":
            return end  # "a large school"
        led = self.reader.kind(at - 1) in ("det", "possessive", "skip")
        onward = self.reader.past(end, "skip", "none")
        predicated = led and (self.reader.kind(onward) == "be" or self._introduced(at, end))
        if not (predicated or (led and self._seen(at))) or self.clause.pending:
            return at + 1
        while end > at + 1 and self.reader.kind(end - 1) == "skip":
            end -= 1
        first, last = self.reader.chunks[at].first, self.reader.chunks[end - 1].last
        if self._is_own(first, last):
            self._subject((SPEAKER,), (first, last), joins=False)
            return end
        self.clause.subject = (Ground("unknown", first, last),)
        self.clause.open = self.clause.negated = False
        return end

    def _subject(self, ids: tuple[str, ...], span: tuple[int, int], joins: bool) -> None:
        """Make objects the subject, and give them what was said before they were named."""
        clause = self.clause
        if joins and clause.figures:
            ids = tuple(dict.fromkeys((*clause.figures, *ids)))
            span = clause.span[0], span[1]
        waiting, clause.pending = clause.pending, []
        if not clause.route:
            for phrase in waiting:
                self.alternative = self.alternative or phrase.cue in self.others
                self._give(phrase, ids, span, 0.9)
        self.figures.spoke_of(ids)
        self.named_at |= dict.fromkeys(ids, span[1])
        clause.figures, clause.span = ids, span
        clause.named, clause.open, clause.route, clause.topic = True, True, False, None
        clause.subject, clause.negated, clause.aside = (), False, False

    def _phrase(self, phrase: RelationPhrase, after: int, at: int) -> None:
        """Decide whose relation a phrase is."""
        clause = self.clause
        if phrase.joint:
            self.crossing = phrase.grounds
        if not phrase.relations:
            return
        if clause.negated:
            phrase = replace(phrase, negated=not phrase.negated)
            if self.reader.kind(after) != "or" and self.reader.value(after) != "nor":
                clause.negated = False
        near = clause.seen and at - clause.seen_at < 4
        places = clause.subject or (clause.seen if near else ())
        about = self._spoken_of(phrase) if places and not phrase.grounds else None
        if (
            about is not None and not clause.route
        ):  # "Rumor is to the north", "you'll see Rumor to the north"
            self.record.converse(replace(phrase, grounds=(about,)), places)
            return
        if not phrase.grounds and self._place_follows(after):
            about = self._spoken_of(phrase)  # "to the west is a bank"
            if about is not None:
                self._wait(replace(phrase, grounds=(about,)))
                return
        if not phrase.grounds:
            back = shared(self.reader, phrase, after) or self._left_out(phrase, after)
            if back is None:
                return
            phrase = back
        phrase = self._pointed(phrase)
        clause.open = False
        if clause.aside or clause.route:
            clause.aside_used = clause.aside
            self.record.set_aside(phrase, "route" if clause.route else "other")
            return
        onto = self.lows[phrase.cue[0]] in ("onto", "through", "via")
        if clause.moving and (onto or set(phrase.relations) <= _PASSED):
            self.record.set_aside(phrase, "route")
            return
        about = phrase.grounds[0]
        clause.grounds = ()
        if phrase.own and clause.named and clause.topic is not None:
            turned = converses(phrase.relations)
            phrase = replace(phrase, relations=turned, grounds=(clause.topic,))
        if clause.subject:
            spoken_of = self._spoken_of(phrase)
            if spoken_of is not None:
                self.record.converse(replace(phrase, grounds=(spoken_of,)), clause.subject)
            else:
                self.record.set_aside(phrase, "other")
            return
        waits = bool(clause.pending)
        if waits or (clause.named and leads_on(self.reader, at, after)):
            self._wait(phrase)
        elif clause.named:
            self._give(phrase, clause.figures, clause.span, 1.0)
        else:
            self._wait(phrase)

    def _pointed(self, phrase: RelationPhrase) -> RelationPhrase:
        """Read "there's a skip, we are behind that": the object named since the last place."""
        about = phrase.grounds[0]
        words = self.lows[about.first : about.last]
        if words and words[-1] in ("him", "her") and about.kind in ("landmark", "unknown"):
            who = tuple(i for i in self.figures.person() if i not in self.clause.figures)
            ground = Ground("figure", about.first, about.last, who, confidence=0.8)
            return replace(phrase, grounds=(ground, *phrase.grounds[1:])) if who else phrase
        if about.kind != "landmark" or not words or words[-1] not in ("it", "that"):
            return phrase
        recent = self.reader.grounds[-_RECENT:]
        place = max((g.last for g in recent if g.last <= phrase.cue[0]), default=0)
        since = [
            i
            for i, at in self.named_at.items()
            if place < at <= phrase.cue[0] and i not in self.clause.figures
        ]
        if not since:
            return phrase
        ground = Ground("figure", about.first, about.last, (since[-1],), confidence=0.8)
        return replace(phrase, grounds=(ground, *phrase.grounds[1:]))

    def _place_follows(self, after: int) -> bool:
        """Whether "is a bank", "there is a bank" or "you'll see a bank" follows a phrase."""
        if self.clause.named or self.clause.subject:
            return False
        onward = self.reader.past(after, "comma", "skip", "pronoun", "see", "be", "robot")
        between = {self.reader.kind(k) for k in range(after, onward)}
        if not between & {"be", "see"}:
            return False
        place = self.reader.past(onward, "det", "skip", "word", "too")
        return self.reader.kind(place) in ("place", "landmark") or place > onward + 1

    def _left_out(self, phrase: RelationPhrase, after: int) -> RelationPhrase | None:
        """Return a phrase without ground ("on the right side") with the place meant, if any."""
        clause, relations = self.clause, phrase.relations
        given = [a for a in self.record.recent() if a.figures == clause.figures]
        compass = all(RELATIONS[r].is_compass for r in relations)
        hearer = bool(given) and given[-1].phrase.grounds[0].ids == (HEARER,)
        if clause.figures == (SPEAKER,) and compass and (hearer or phrase.distance is not None):
            place = Ground("landmark", *phrase.cue, (HEARER,))  # "a few blocks west": of you
            return replace(phrase, grounds=(place,), joint=False)
        if clause.figures == (SPEAKER,) and not (clause.named or given):
            return None  # "... is to the north": of who speaks, and what is there was not read
        last_ground = self.reader.last_ground()
        record = RELATIONS[relations[0]]
        sided = record.converse is not None or record.part or len(relations) > 1
        while self.reader.value(after) in lexicon().words_of("adverbs"):
            after += 1
        ends = self.reader.kind(after) in ("stop", "end", "comma", "and", "but", "sub", "which")
        if given and phrase.part and given[-1].phrase.joint and given[-1].phrase.corner:
            return replace(phrase, grounds=given[-1].phrase.grounds, joint=True)
        sided = sided or (ends and record.bare)
        elsewhere = phrase.part and bool(self.record.attached)
        expected = given or clause.pending or (ends and (record.bare or elsewhere))
        if last_ground is None or not sided or not expected:
            if clause.named and not clause.route and relations[0] not in ("at", "in", "on"):
                self.record.lose(Ground("cue", *phrase.cue))
            return None
        return replace(phrase, grounds=(replace(last_ground, confidence=0.7),), joint=False)
